// Bounds name their field; sizes and faults scale as they should.
#include "tools/sim/camera/camera_spec.h"

#include <gtest/gtest.h>

#include <cmath>

namespace touchline::sim::camera {
namespace {

CameraSpec good() {
  CameraSpec spec = usual(Role::kMatch);
  spec.id = base::CameraId{"m1"};
  return spec;
}

TEST(CameraSpec, EveryRoleIsSoundAsItComes) {
  for (const Role role : {Role::kMatch, Role::kFixed, Role::kCloseup}) {
    CameraSpec spec = usual(role);
    spec.id = base::CameraId{"x"};
    const auto status = spec.validate();
    EXPECT_TRUE(status) << base::to_string(status.error());
  }
}

TEST(CameraSpec, WrongValuesAreNamed) {
  CameraSpec spec = good();
  spec.lens.corner_wide = -0.3;
  const auto status = spec.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "camera.m1.lens.corner_wide");
  EXPECT_NE(status.error().what.find("-0.3"), std::string::npos);
  EXPECT_FALSE(status.error().cure.empty());
  spec = good();
  spec.sensor.gain.y() = std::nan("");
  EXPECT_FALSE(spec.validate());
  spec = good();
  spec.id = base::CameraId{"virtual07"};
  EXPECT_FALSE(spec.validate());
}

TEST(CameraSpec, ResizingKeepsTheView) {
  CameraSpec spec = good();
  spec.lens.centre_px = {9, -6};
  spec.sensor.softness_px = 0.9;
  const CameraSpec small = resized(spec, 640, 360);
  EXPECT_NEAR(small.lens.centre_px.x(), 3, 1e-12);
  EXPECT_NEAR(small.sensor.softness_px, 0.3, 1e-12);
  EXPECT_EQ(small.width, 640);
}

TEST(CameraSpec, FaultsFollowSeedAndId) {
  CameraSpec spec = good();
  EXPECT_EQ(varied(spec, 1).sensor.gain, spec.sensor.gain);
  spec.vary = 1;
  const CameraSpec a = varied(spec, 1), b = varied(spec, 1), c = varied(spec, 2);
  EXPECT_EQ(a.sensor.gain, b.sensor.gain);
  EXPECT_NE(a.sensor.gain, c.sensor.gain);
  spec.id = base::CameraId{"m2"};
  EXPECT_NE(a.sensor.gain, varied(spec, 1).sensor.gain);
  EXPECT_TRUE(a.validate());
}

TEST(CameraSpec, SidesAreThoseNearest) {
  EXPECT_EQ(side_of({0, -60, 10}, 105, 68), Side::kMain);
  EXPECT_EQ(side_of({20, 60, 10}, 105, 68), Side::kReverse);
  EXPECT_EQ(side_of({-80, 10, 10}, 105, 68), Side::kLeft);
  EXPECT_EQ(side_of({80, 10, 10}, 105, 68), Side::kRight);
}

}  // namespace
}  // namespace touchline::sim::camera
