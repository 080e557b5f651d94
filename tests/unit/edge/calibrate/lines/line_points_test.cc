#include "edge/calibrate/lines/line_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

struct Seen {
  int windows = 0;
  int found = 0;
  int bare = 0;
  double width_px = 0;
};

Seen far_touchline(const image::Frame& frame, const pitch::PitchModel& pitch,
                   const geometry::CameraEstimate& camera) {
  Seen seen;
  for (const LinePoint& point : measure_lines(frame, pitch, camera, {})) {
    if (std::abs(point.point_in_world.y() - 0.5 * pitch.width_m) > 0.2) continue;
    ++seen.windows;
    seen.width_px += point.width_px;
    seen.found += point.state == WindowState::kFound ? 1 : 0;
    seen.bare += point.state == WindowState::kBare ? 1 : 0;
  }
  if (seen.windows > 0) seen.width_px /= seen.windows;
  return seen;
}

// Ground beyond the far touchline that is paler than the pitch, `wide` pixels of it, then darker.
void add_pale_band(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                   double wide, image::Frame& frame) {
  for (int x = 0; x < frame.width(); ++x) {
    double edge = -1;
    for (double along = -60; along <= 60; along += 0.05) {
      const auto pixel = geometry::project(camera, pitch.on_turf({along, 0.5 * pitch.width_m}));
      if (pixel && std::abs(pixel->x() - x) < 0.6) edge = pixel->y();
    }
    if (edge < 0) continue;
    for (int y = 0; y < frame.height(); ++y) {
      const double into = std::min(1.0, std::max(0.0, edge + 0.5 - y)) -
                          1.6 * std::min(1.0, std::max(0.0, edge - wide + 0.5 - y));
      frame.planes[0](x, y) =
          static_cast<std::uint16_t>(std::max(64.0, frame.planes[0](x, y) + 80 * into));
    }
  }
}

class FarTouchline : public testing::Test {
 protected:
  pitch::PitchModel pitch_ = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.0, {}});
  geometry::CameraEstimate camera_ = camera_at(test_mount(), 0, -8, 1500);
};

TEST_F(FarTouchline, ThinPaintIsFound) {
  const image::Frame frame = paint_pitch(pitch_, camera_, {4, 0});
  const Seen seen = far_touchline(frame, pitch_, camera_);
  ASSERT_GT(seen.windows, 50);
  ASSERT_LT(seen.width_px, 1.2);
  EXPECT_GT(seen.found, 0.9 * seen.windows);
}

TEST_F(FarTouchline, APalerBandBesideThePitchIsNoPaintAndHidesIt) {
  image::Frame frame = paint_pitch(pitch_, camera_, {4, 0, false});
  add_pale_band(pitch_, camera_, 6, frame);
  const Seen seen = far_touchline(frame, pitch_, camera_);
  ASSERT_GT(seen.windows, 50);
  EXPECT_LT(seen.found, 0.1 * seen.windows);
}

}  // namespace
}  // namespace touchline::calibrate
