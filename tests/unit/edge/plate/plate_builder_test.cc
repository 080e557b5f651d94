// The plate of painted pitches: what is learnt, and what never is.
#include "edge/plate/plate_builder.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/edge/plate/turf_scene.h"

namespace touchline::plate {
namespace {

constexpr double kScale = 1.0 / 500;
const Eigen::Vector3d kCentre(0, -60, 18);

// The plate's mean at a pixel of a camera, nearest sample; nothing where it has none.
std::optional<std::array<float, 3>> plate_at(const image::PlateSnapshot& plate,
                                             const geometry::CameraEstimate& camera,
                                             const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d p =
      image::plate_from_direction(plate, geometry::ray_in_world(camera, pixel));
  const int u = static_cast<int>(std::lround(p.x()));
  const int v = static_cast<int>(std::lround(p.y()));
  const image::PlateTileKey key{static_cast<int>(std::floor(u / 256.0)),
                                static_cast<int>(std::floor(v / 256.0))};
  const auto found = plate.tiles.find(key);
  if (found == plate.tiles.end()) return std::nullopt;
  const int x = u - 256 * key.column;
  const int y = v - 256 * key.row;
  const auto& mean = found->second->mean;
  if (mean[0](x, y) == 0) return std::nullopt;
  return std::array<float, 3>{mean[0](x, y) / 16.f, mean[1](x, y) / 16.f, mean[2](x, y) / 16.f};
}

TEST(PlateBuilder, APanningCameraReproducesTheScene) {
  const auto pitch = test_pitch();
  PlateBuilder builder(pitch, kCentre, kScale);
  for (int k = 0; k < 12; ++k) {
    const auto camera = test_camera(-0.1 + 0.02 * k);
    builder.add(render(camera, pitch, {}, static_cast<unsigned>(k)), camera);
  }
  const auto plate = builder.snapshot(true);
  EXPECT_EQ(builder.frames(), 12);
  const auto camera = test_camera(0);
  double sum = 0;
  int count = 0;
  for (int y = 10; y < 260; y += 7)
    for (int x = 10; x < 470; x += 7) {
      const auto got = plate_at(*plate, camera, {x, y});
      ASSERT_TRUE(got) << x << ' ' << y;
      const auto wanted = background_at(camera, pitch, {x, y});
      sum += std::abs((*got)[0] - wanted[0]);
      ++count;
    }
  EXPECT_LT(sum / count, 8);  // code values; most of it at edges half a plate pixel away
}

TEST(PlateBuilder, APersonWhoStandsStillIsNeverLearntOnTurf) {
  const auto pitch = test_pitch();
  const auto camera = test_camera(0);
  const Backdrop scene(camera, pitch);
  // Red, black, and the colour of a dark arm.
  for (const auto& colour :
       {std::array<float, 3>{400, 440, 760}, std::array<float, 3>{100, 512, 510},
        std::array<float, 3>{200, 485, 520}}) {
    const Disc person{{180, 200}, 9, colour};
    PlateBuilder builder(pitch, kCentre, kScale);
    for (unsigned k = 0; k < 20; ++k) builder.add(scene.frame({person}, k), camera);
    const auto plate = builder.snapshot(true);
    for (int y = 190; y <= 210; y += 2)
      for (int x = 170; x <= 190; x += 2) {
        const auto got = plate_at(*plate, camera, {x, y});
        ASSERT_TRUE(got);
        const auto wanted = background_at(camera, pitch, {x, y});
        EXPECT_NEAR((*got)[2], wanted[2], 20) << x << ' ' << y;
        EXPECT_NEAR((*got)[0], wanted[0], 40) << x << ' ' << y;
      }
  }
}

TEST(PlateBuilder, WhereNobodyEverSawTurfTheDeviationIsRaised) {
  const auto pitch = test_pitch();
  const auto camera = test_camera(0);
  const Backdrop scene(camera, pitch);
  PlateBuilder builder(pitch, kCentre, kScale);
  for (unsigned k = 0; k < 12; ++k) builder.add(scene.frame({Disc{{180, 200}, 9}}, k), camera);
  const auto plate = builder.snapshot(true);
  const Eigen::Vector2d p =
      image::plate_from_direction(*plate, geometry::ray_in_world(camera, {180, 200}));
  const image::PlateTileKey key{static_cast<int>(std::floor(p.x() / 256)),
                                static_cast<int>(std::floor(p.y() / 256))};
  const image::PlateTile& tile = *plate->tiles.at(key);
  const int x = static_cast<int>(std::lround(p.x())) - 256 * key.column;
  const int y = static_cast<int>(std::lround(p.y())) - 256 * key.row;
  EXPECT_LE(tile.count(x, y), 1);
  EXPECT_GE(tile.deviation[0](x, y), 16 * PlateOptions{}.filled_codes);
  EXPECT_GE(tile.count(x + 40, y), 5);
}

TEST(PlateBuilder, OffTheTurfTheMedianForgetsWhoWalksBy) {
  const auto pitch = test_pitch();
  const auto camera = test_camera(0, -0.1);
  const Backdrop scene(camera, pitch);
  PlateBuilder builder(pitch, kCentre, kScale);
  for (unsigned k = 0; k < 12; ++k)
    builder.add(scene.frame({Disc{{60.0 + 25 * k, 30}, 10}}, k), camera);
  const auto plate = builder.snapshot(true);
  for (int x = 60; x < 340; x += 5) {
    const auto got = plate_at(*plate, camera, {x, 30});
    const auto wanted = background_at(camera, pitch, {x, 30});
    ASSERT_TRUE(got);
    EXPECT_LT(std::abs((*got)[2] - wanted[2]), 80) << x;  // red is 250 away
  }
}

TEST(PlateBuilder, SeedsFillWhatTheVideoNeverShowed) {
  const auto pitch = test_pitch();
  PlateBuilder builder(pitch, kCentre, kScale);
  const auto wide = test_camera(0.1, -0.25, 300);
  auto still = render(wide, pitch, {}, 99);
  // The still is brighter by a tenth: the fit to the video takes that out.
  for (std::size_t i = 0; i < still.planes[0].size(); ++i)
    still.planes[0].data()[i] =
        static_cast<std::uint16_t>(64 + 1.1 * (still.planes[0].data()[i] - 64));
  builder.seed(still, wide);
  const auto camera = test_camera(0);
  const Backdrop scene(camera, pitch);
  const Disc person{{180, 200}, 9};
  for (unsigned k = 0; k < 8; ++k) builder.add(scene.frame({person}, k), camera);
  const auto plate = builder.snapshot(true);
  const auto got = plate_at(*plate, camera, {180, 200});
  ASSERT_TRUE(got);
  const auto wanted = background_at(camera, pitch, {180, 200});
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR((*got)[c], wanted[c], 12);
}

TEST(PlateBuilder, LostCamerasAddNothing) {
  const auto pitch = test_pitch();
  PlateBuilder builder(pitch, kCentre, kScale);
  auto camera = test_camera(0);
  const auto frame = render(camera, pitch, {});
  camera.evidence = geometry::Evidence::kLost;
  builder.add(frame, camera);
  EXPECT_EQ(builder.frames(), 0);
  EXPECT_TRUE(builder.snapshot()->tiles.empty());
}

TEST(PlateBuilder, ASnapshotIsKeptUntilThereIsReasonForAnother) {
  const auto pitch = test_pitch();
  PlateBuilder builder(pitch, kCentre, kScale);
  const auto camera = test_camera(0);
  const auto frame = render(camera, pitch, {});
  builder.add(frame, camera);
  const auto first = builder.snapshot();
  const image::PlateSnapshot copy = *first;
  for (int k = 0; k < 6; ++k) builder.add(frame, camera);
  EXPECT_EQ(builder.snapshot(), first);
  const auto second = builder.snapshot(true);
  EXPECT_NE(second, first);
  EXPECT_GT(second->version, first->version);
  EXPECT_EQ(builder.snapshot(true), second);
  EXPECT_EQ(*first, copy);  // who holds a version keeps it
}

TEST(PlateBuilder, TilesThatHardlyChangeStayAsTheyWerePublished) {
  const auto pitch = test_pitch();
  PlateOptions options;
  options.learn_frames = 8;
  options.update_every = 2;
  options.update_rate = 0.05;
  PlateBuilder builder(pitch, kCentre, kScale, options);
  const auto camera = test_camera(0);
  const Backdrop scene(camera, pitch);
  for (unsigned k = 0; k < 10; ++k) builder.add(scene.frame({}, k), camera);
  builder.snapshot(true);
  for (unsigned k = 10; k < 60; ++k) builder.add(scene.frame({}, k), camera);
  const auto first = builder.snapshot(true);
  for (unsigned k = 60; k < 90; ++k) builder.add(scene.frame({}, k), camera);
  EXPECT_EQ(builder.snapshot(true), first);  // noise is no news

  // Something is put down in one place: its tile changes, the others do not.
  for (unsigned k = 90; k < 170; ++k)
    builder.add(scene.frame({Disc{{100, 25}, 20, {500, 500, 560}}}, k), camera);
  const auto second = builder.snapshot(true);
  ASSERT_NE(second, first);
  int changed = 0;
  for (const auto& [key, tile] : second->tiles) {
    const bool same = first->tiles.at(key) == tile;
    EXPECT_EQ(first->tiles.at(key).is(tile), same);  // what is as it was is not made again
    changed += same ? 0 : 1;
  }
  EXPECT_GE(changed, 1);
  EXPECT_LT(changed, static_cast<int>(second->tiles.size()) / 2);
}

TEST(PlateBuilder, WhatComesIntoViewIsInTheNextVersion) {
  const auto pitch = test_pitch();
  PlateBuilder builder(pitch, kCentre, kScale);
  geometry::CameraEstimate camera;
  for (int k = 0; k < 9; ++k) {
    camera = test_camera(0.08 * k);
    builder.add(render(camera, pitch, {}, static_cast<unsigned>(k)), camera);
  }
  const auto plate = builder.snapshot(true);
  for (int y = 4; y < 270; y += 9)
    for (int x = 4; x < 480; x += 9) EXPECT_TRUE(plate_at(*plate, camera, {x, y})) << x << ' ' << y;
}

TEST(PlateBuilder, TheSameFramesGiveTheSamePlate) {
  const auto pitch = test_pitch();
  const auto build = [&] {
    PlateBuilder builder(pitch, kCentre, kScale);
    for (int k = 0; k < 5; ++k) {
      const auto camera = test_camera(0.03 * k);
      builder.add(render(camera, pitch, {Disc{{200, 190}, 8}}, static_cast<unsigned>(k)), camera);
    }
    return builder.snapshot(true);
  };
  EXPECT_EQ(*build(), *build());
}

TEST(PlateBuilder, ACameraThatLooksAcrossTheSeamHasAWholePlate) {
  const auto pitch = test_pitch();
  geometry::CameraEstimate camera = test_camera(3.1);
  const Eigen::Vector3d centre(0, 60, 18);
  camera.cam_from_world.translation = -(camera.cam_from_world.rotation * centre);
  const Backdrop scene(camera, pitch);
  PlateBuilder builder(pitch, centre, kScale);
  for (unsigned k = 0; k < 5; ++k) builder.add(scene.frame({}, k), camera);
  const auto plate = builder.snapshot(true);
  for (int x = 5; x < 475; x += 3) EXPECT_TRUE(plate_at(*plate, camera, {x, 200})) << x;
}

TEST(PlateBuilder, OldTilesAreDroppedBeyondTheBound) {
  const auto pitch = test_pitch();
  PlateOptions options;
  options.max_tiles = 14;
  PlateBuilder builder(pitch, kCentre, kScale, options);
  for (int k = 0; k < 6; ++k) {
    const auto camera = test_camera(-0.6 + 0.24 * k);
    builder.add(render(camera, pitch, {}), camera);
  }
  EXPECT_LE(builder.snapshot(true)->tiles.size(), 14U);
}

TEST(PlateOptions, ValidateNamesFieldValueAndBound) {
  EXPECT_TRUE(PlateOptions{}.validate());
  PlateOptions options;
  options.samples = 99;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "samples");
  EXPECT_NE(status.error().what.find("99"), std::string::npos);
  EXPECT_NE(status.error().what.find("32"), std::string::npos);
}

}  // namespace
}  // namespace touchline::plate
