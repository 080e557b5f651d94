// A plate that goes on from one that was learnt earlier.
#include <gtest/gtest.h>

#include <cmath>

#include "edge/plate/plate_builder.h"
#include "tests/unit/edge/plate/turf_scene.h"

namespace touchline::plate {
namespace {

constexpr double kScale = 1.0 / 500;
constexpr double kMoved = 0.25;
const Eigen::Vector3d kCentre(0, -60, 18);

class Resume : public testing::Test {
 protected:
  PlateBuilder builder() const { return {pitch_, kCentre, kScale}; }
  // Learnt from frames without anybody.
  std::shared_ptr<const image::PlateSnapshot> saved() const {
    PlateBuilder first = builder();
    for (unsigned k = 0; k < 8; ++k) first.add(scene_.frame({}, k), camera_);
    return first.snapshot(true);
  }
  // Luma of a plate at a pixel of the camera.
  double luma(const image::PlateSnapshot& plate, const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d p =
        image::plate_from_direction(plate, geometry::ray_in_world(camera_, pixel));
    const int u = static_cast<int>(std::lround(p.x()));
    const int v = static_cast<int>(std::lround(p.y()));
    const image::PlateTileKey key{static_cast<int>(std::floor(u / 256.0)),
                                  static_cast<int>(std::floor(v / 256.0))};
    const auto found = plate.tiles.find(key);
    return found == plate.tiles.end()
               ? 0.0
               : found->second->mean[0](u - 256 * key.column, v - 256 * key.row) / 16.0;
  }

  pitch::PitchModel pitch_ = test_pitch();
  geometry::CameraEstimate camera_ = test_camera(0);
  Backdrop scene_{camera_, pitch_};
};

TEST_F(Resume, WithoutANewFrameItIsThePlateThatWasSavedInItsNextVersion) {
  const auto before = saved();
  PlateBuilder second = builder();
  ASSERT_TRUE(second.resume(*before, kMoved));
  const auto plate = second.snapshot(true);
  EXPECT_EQ(plate->version, before->version + 1);
  EXPECT_EQ(plate->tiles, before->tiles);
  EXPECT_FALSE(second.resumed_apart());
}

TEST_F(Resume, TheFirstFramesChangeLittleOfWhatTheyConfirm) {
  const auto before = saved();
  PlateBuilder second = builder();
  ASSERT_TRUE(second.resume(*before, kMoved));
  for (unsigned k = 0; k < 8; ++k) second.add(scene_.frame({}, 100 + k), camera_);
  const auto plate = second.snapshot(true);
  ASSERT_TRUE(second.resumed_apart());
  EXPECT_LT(*second.resumed_apart(), 0.01);
  for (int x = 20; x < 460; x += 20)
    for (int y = 20; y < 260; y += 20)
      EXPECT_NEAR(luma(*plate, {x, y}), luma(*before, {x, y}), 6) << x << ' ' << y;
}

TEST_F(Resume, WherePeopleStandFromTheFirstFrameOnItKnowsTheTurf) {
  PlateBuilder second = builder();
  const auto before = saved();
  ASSERT_TRUE(second.resume(*before, kMoved));
  const Disc person{{180, 200}, 9};
  for (unsigned k = 0; k < 6; ++k) second.add(scene_.frame({person}, k), camera_);
  const auto plate = second.snapshot(true);
  EXPECT_NEAR(luma(*plate, {180, 200}), luma(*before, {180, 200}), 1);
}

TEST_F(Resume, LiveFramesInAnotherLightWinAndTheRestGoesWithThem) {
  PlateBuilder second = builder();
  ASSERT_TRUE(second.resume(*saved(), kMoved));
  const Disc person{{180, 200}, 9};
  for (unsigned k = 0; k < 10; ++k) {
    image::Frame frame = scene_.frame({person}, 30 + k);
    for (std::size_t i = 0; i < frame.planes[0].size(); ++i) {
      std::uint16_t& y = frame.planes[0].data()[i];
      y = static_cast<std::uint16_t>(64 + 0.8 * (y - 64));
    }
    second.add(frame, camera_);
  }
  const auto plate = second.snapshot(true);
  const auto lit = [&](const Eigen::Vector2d& at) {
    return 64 + 0.8 * (background_at(camera_, pitch_, at)[0] - 64);
  };
  EXPECT_NEAR(luma(*plate, {300, 200}), lit({300, 200}), 8);
  EXPECT_NEAR(luma(*plate, {180, 200}), lit({180, 200}), 16);  // under the person
  ASSERT_TRUE(second.resumed_apart());
  EXPECT_LT(*second.resumed_apart(), 0.5);
}

TEST_F(Resume, APlateOfAnotherViewIsForgotten) {
  // The same pictures, taken to be of a camera that looked elsewhere.
  auto elsewhere = camera_;
  elsewhere.cam_from_world = test_camera(0.37, -0.2).cam_from_world;
  PlateBuilder first = builder();
  for (unsigned k = 0; k < 8; ++k) first.add(scene_.frame({}, k), elsewhere);
  PlateBuilder second = builder();
  ASSERT_TRUE(second.resume(*first.snapshot(true), kMoved));
  PlateBuilder fresh = builder();
  const auto high = test_camera(0.2, -0.05);
  const Backdrop stands(high, pitch_);
  for (unsigned k = 0; k < 10; ++k) {
    const auto frame = stands.frame({}, 60 + k);
    second.add(frame, high);
    fresh.add(frame, high);
  }
  const auto plate = second.snapshot(true);
  ASSERT_TRUE(second.resumed_apart());
  EXPECT_GT(*second.resumed_apart(), 0.5);
  const auto wanted = fresh.snapshot(true);
  for (const auto& [key, tile] : plate->tiles)
    for (int y = 0; y < 256; y += 16)
      for (int x = 0; x < 256; x += 16)
        if (wanted->tiles.contains(key) && wanted->tiles.at(key)->count(x, y) > 3) {
          EXPECT_NEAR(tile->mean[0](x, y), wanted->tiles.at(key)->mean[0](x, y), 40);
        }
}

TEST_F(Resume, WhatDoesNotFitIsRefused) {
  const auto before = saved();
  PlateBuilder finer(pitch_, kCentre, kScale / 2);
  EXPECT_FALSE(finer.resume(*before, kMoved));
  PlateBuilder moved(pitch_, kCentre + Eigen::Vector3d(0.3, 0, 0), kScale);
  EXPECT_FALSE(moved.resume(*before, kMoved));
  PlateBuilder begun = builder();
  begun.add(scene_.frame({}, 1), camera_);
  EXPECT_FALSE(begun.resume(*before, kMoved));
}

}  // namespace
}  // namespace touchline::plate
