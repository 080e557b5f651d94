#include "shared/codec/view_codec.h"

#include <gtest/gtest.h>

#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

TEST(ViewCodec, KeepsIdentityAndParts) {
  const CameraView view = samples::view("m1", 3);
  const auto encoded = encode(view);
  ASSERT_TRUE(encoded) << to_string(encoded.error());
  EXPECT_EQ(encoded->id, view.id);
  EXPECT_EQ(encoded->stamp, view.stamp);
  ASSERT_EQ(encoded->parts.size(), 3u);
  EXPECT_EQ(encoded->parts[0].kind, PartKind::kMatte);
  const auto back = decode(*encoded);
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_EQ(back->matte, view.matte);
  EXPECT_EQ(back->partial->polygons.size(), view.partial->polygons.size());
  EXPECT_EQ(back->tiles->size(), view.tiles->size());
}

TEST(ViewCodec, LeavesOutPartsThatTheViewLacks) {
  CameraView view = samples::view("m1", 3);
  view.matte.reset();
  view.tiles.reset();
  const auto encoded = encode(view);
  ASSERT_TRUE(encoded);
  ASSERT_EQ(encoded->parts.size(), 1u);
  const auto back = decode(*encoded);
  ASSERT_TRUE(back);
  EXPECT_FALSE(back->matte);
  EXPECT_FALSE(back->tiles);
}

TEST(ViewCodec, SkipsUnknownKindsAndRefusesDoubles) {
  auto encoded = encode(samples::view("m1", 3));
  ASSERT_TRUE(encoded);
  encoded->parts.push_back({static_cast<PartKind>(99), 1, {1, 2, 3}});
  EXPECT_TRUE(decode(*encoded));
  encoded->parts.push_back(encoded->parts[0]);
  EXPECT_FALSE(decode(*encoded));
}

TEST(ViewCodec, NamesCameraFrameAndPartInErrors) {
  auto encoded = encode(samples::view("m1", 3));
  ASSERT_TRUE(encoded);
  encoded->parts[1].version = 77;
  const auto back = decode(*encoded);
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().kind, base::ErrorKind::kUnsupported);
  EXPECT_EQ(back.error().where, "m1#3 partial");
}

TEST(ViewCodec, RefusesAMatteOfAnotherSizeUnlessLost) {
  CameraView view = samples::view("m1", 3);
  view.estimate.model.width = 65;
  EXPECT_FALSE(decode(*encode(view)));
  view.estimate.evidence = geometry::Evidence::kLost;
  EXPECT_TRUE(decode(*encode(view)));
}

}  // namespace
}  // namespace touchline::codec
