// Lenses: distortion that can be undone, smooth over zoom.
#include "tools/sim/camera/lens.h"

#include <gtest/gtest.h>

#include <cmath>

namespace touchline::sim::camera {
namespace {

LensSpec strong() {
  LensSpec spec;
  spec.corner_wide = -0.06;
  spec.corner_tele = 0.02;
  return spec;
}

TEST(Lens, ShiftsTheCornerAsStated) {
  const Lens lens(strong(), 1920, 1080);
  const auto model = lens.model(lens.wide_px());
  const double corner = std::hypot(960.0, 540.0) / model.fx;
  const double r2 = corner * corner;
  EXPECT_NEAR(model.k1 * r2 + model.k2 * r2 * r2, -0.06, 1e-12);
}

TEST(Lens, DistortionGrowsWithTheRadiusInsideThePictureAtEveryZoom) {
  const Lens lens(strong(), 1920, 1080);
  for (double u = 0; u <= 1; u += 0.05) {
    const double focal = lens.wide_px() * std::pow(lens.tele_px() / lens.wide_px(), u);
    const auto model = lens.model(focal);
    double last = -1;
    for (int i = 0; i <= 120; ++i) {
      const double r = i / 100.0 * std::hypot(960.0, 540.0) / model.fx;
      const double distorted = r * (1 + model.k1 * r * r + model.k2 * r * r * r * r);
      EXPECT_GT(distorted, last) << "zoom " << u;
      last = distorted;
    }
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(1919, 0), Eigen::Vector2d(1919, 1079)}) {
      const auto back = model.project(model.unproject(pixel));
      ASSERT_TRUE(back) << "zoom " << u;
      EXPECT_LT((*back - pixel).norm(), 1e-6);
    }
  }
}

TEST(Lens, IsSmoothOverZoom) {
  const Lens lens(strong(), 1920, 1080);
  double last = 0, last_step = 0;
  for (int i = 0; i <= 200; ++i) {
    const double focal = lens.wide_px() * std::pow(lens.tele_px() / lens.wide_px(), i / 200.0);
    const auto model = lens.model(focal);
    const double r2 = (960.0 * 960 + 540.0 * 540) / (focal * focal);
    const double shift = model.k1 * r2 + model.k2 * r2 * r2;
    if (i > 1) {
      EXPECT_NEAR(shift - last, last_step, 1e-5);
    }
    if (i > 0) last_step = shift - last;
    last = shift;
  }
  EXPECT_NEAR(last, 0.02, 1e-9);
}

TEST(Lens, MovesItsPupilBetweenItsEnds) {
  LensSpec spec;
  spec.pupil_wide_m = 0.2;
  spec.pupil_tele_m = -0.1;
  const Lens lens(spec, 1920, 1080);
  EXPECT_NEAR(lens.pupil_m(lens.wide_px()), 0.2, 1e-12);
  EXPECT_NEAR(lens.pupil_m(lens.tele_px()), -0.1, 1e-12);
  EXPECT_NEAR(lens.pupil_m(std::sqrt(lens.wide_px() * lens.tele_px())), 0.05, 1e-12);
}

TEST(Lens, ShowsTheSameFieldAtAnySize) {
  const Lens big(LensSpec{}, 1920, 1080), small(LensSpec{}, 640, 360);
  EXPECT_NEAR(big.px_from_mm(50) / 1920, small.px_from_mm(50) / 640, 1e-12);
}

}  // namespace
}  // namespace touchline::sim::camera
