#include "edge/encode/assemble.h"

#include <gtest/gtest.h>

#include "edge/encode/tile_places.h"
#include "shared/codec/view_codec.h"
#include "tests/unit/edge/encode/scene.h"

namespace touchline::encode {
namespace {

pitch::PitchModel soccer() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

bool covered(const std::vector<image::Rect>& places, int x, int y) {
  int n = 0;
  for (const image::Rect& place : places) n += place.contains(x, y) ? 1 : 0;
  return n == 1;  // no two overlap
}

TEST(TilePlaces, CoverTheForegroundWithItsMarginOnce) {
  image::Matte matte = samples::empty_matte(333, 201);
  samples::add_disc(matte, 60, 50, 15);
  samples::add_disc(matte, 90, 66, 12);
  samples::add_disc(matte, 330, 190, 30);
  const int margin = 8;
  const std::vector<image::Rect> places = tile_places(matte, margin, 24);
  for (int y = 0; y < 201; ++y) {
    for (int x = 0; x < 333; ++x) {
      if (matte.alpha(x, y) == 0) continue;
      for (int dy = -margin; dy <= margin; dy += margin) {
        for (int dx = -margin; dx <= margin; dx += margin) {
          if (!matte.alpha.contains(x + dx, y + dy)) continue;
          ASSERT_TRUE(covered(places, x + dx, y + dy)) << x + dx << ", " << y + dy;
        }
      }
    }
  }
  for (const image::Rect& place : places) {
    EXPECT_EQ(place.x % 8, 0);
    EXPECT_EQ(place.y % 8, 0);
    EXPECT_LE(place.x + place.width, 333);
    EXPECT_LE(place.y + place.height, 201);
  }
}

TEST(TilePlaces, TakeUnknownPixelsOnlyNearForeground) {
  image::Matte matte = samples::empty_matte(320, 200);
  samples::add_disc(matte, 60, 50, 15);
  matte.unknown(82, 50) = 255;
  matte.unknown(300, 150) = 255;
  const std::vector<image::Rect> places = tile_places(matte, 8, 24);
  EXPECT_TRUE(covered(places, 90, 50));
  EXPECT_FALSE(covered(places, 300, 150));
  EXPECT_TRUE(tile_places(samples::empty_matte(320, 200), 8, 24).empty());
}

TEST(Assemble, HoldsTilesPartialAndMatteOfTheFrame) {
  const image::Frame frame = samples::frame(320, 200);
  image::Matte matte = samples::empty_matte(320, 200);
  samples::add_disc(matte, 160, 110, 40);
  const codec::CameraView view =
      assemble(frame, samples::camera(320, 200, 900), matte, soccer(), {});
  EXPECT_EQ(view.id, frame.id);
  EXPECT_EQ(view.matte, matte);
  ASSERT_TRUE(view.partial && view.tiles);
  EXPECT_FALSE(view.tiles->empty());
  EXPECT_FALSE(view.partial->features.empty());
  EXPECT_LE(view.partial->features.size(), 120u);
  for (const geometry::Feature& feature : view.partial->features) {
    EXPECT_GE(matte.alpha(static_cast<int>(feature.position.x() + 0.5f),
                          static_cast<int>(feature.position.y() + 0.5f)),
              128);
    EXPECT_EQ(feature.descriptor.size(), 32u);
  }
  EXPECT_TRUE(codec::encode(view));
}

TEST(Assemble, DepthsEncloseWhoeverStandsThere) {
  const geometry::CameraEstimate camera = samples::camera(320, 200, 900);
  image::Matte matte = samples::empty_matte(320, 200);
  samples::add_disc(matte, 160, 110, 25);
  const codec::CameraView view = assemble(samples::frame(320, 200), camera, matte, soccer(), {});
  ASSERT_EQ(view.partial->polygons.size(), 1u);
  const auto& polygon = view.partial->polygons[0];
  // Heights from the turf to the top of a head on the rays through the silhouette's middle.
  for (const double height : {0.0, 1.0, 2.4}) {
    const Eigen::Vector3d origin = geometry::position_in_world(camera);
    const Eigen::Vector3d ray = geometry::ray_in_world(camera, {160, 110});
    const Eigen::Vector3d point = origin + ray * ((height - origin.z()) / ray.z());
    const double depth = (camera.cam_from_world * point).z();
    EXPECT_GT(depth, polygon.near_m);
    EXPECT_LT(depth, polygon.far_m);
  }
  EXPECT_LT(polygon.far_m - polygon.near_m, 40);
}

TEST(Assemble, ALostCameraHasNoDepths) {
  geometry::CameraEstimate camera = samples::camera(320, 200, 900);
  camera.evidence = geometry::Evidence::kLost;
  image::Matte matte = samples::empty_matte(320, 200);
  samples::add_disc(matte, 160, 110, 12);
  const codec::CameraView view = assemble(samples::frame(320, 200), camera, matte, soccer(), {});
  ASSERT_EQ(view.partial->polygons.size(), 1u);
  EXPECT_EQ(view.partial->polygons[0].far_m, 0);
}

TEST(Assemble, OptionsNameTheFieldThatIsWrong) {
  EncodeOptions options;
  EXPECT_TRUE(options.validate());
  options.simplify_px = 0.6f;
  EXPECT_EQ(options.validate().error().where, "simplify_px");
  options = {};
  options.ball_height_m = 1;
  EXPECT_EQ(options.validate().error().where, "ball_height_m");
}

}  // namespace
}  // namespace touchline::encode
