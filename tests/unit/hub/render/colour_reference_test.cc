#include "hub/render/colour_reference.h"

#include <gtest/gtest.h>

#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

TEST(ColourReference, FindsTheGainsBetweenPlates) {
  const Eigen::Vector3d a(1.08, 1.0, 0.94);
  const Eigen::Vector3d b(0.95, 1.02, 1.03);
  std::map<base::CameraId, image::PlateSnapshot> plates;
  plates[{"a"}] = draw_plate({-4, -15, 8}, 1.0 / 600, 8, a);
  plates[{"b"}] = draw_plate({6, -15, 7}, 1.0 / 500, 8, b);
  const ColourReference reference = estimate_colour_reference(flat_pitch(), plates);
  EXPECT_GT(reference.points, 50);
  EXPECT_LT(reference.rms_after, 0.5 * reference.rms_before);
  const Eigen::Vector3d ga = reference.of({"a"});
  const Eigen::Vector3d gb = reference.of({"b"});
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(ga[k] * a[k] / (gb[k] * b[k]), 1, 0.01);
    EXPECT_NEAR(ga[k] * gb[k], 1, 1e-6);
  }
  EXPECT_EQ(reference.of({"unknown"}), Eigen::Vector3d(1, 1, 1));
}

TEST(ColourReference, WithoutSharedTurfEveryGainIsOne) {
  std::map<base::CameraId, image::PlateSnapshot> plates;
  plates[{"a"}] = draw_plate({-4, -15, 8}, 1.0 / 300, 8);
  const ColourReference reference = estimate_colour_reference(flat_pitch(), plates);
  EXPECT_EQ(reference.of({"a"}), Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(reference.points, 0);
}

TEST(ColourReference, OptionsNameTheFieldThatIsOut) {
  ColourReferenceOptions options;
  options.grid_m = 0;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().where.find("grid_m"), std::string::npos);
}

}  // namespace
}  // namespace touchline::render
