#include "shared/codec/partial_codec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/shared/codec/hostile_bytes.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

using geometry::Partial;

Partial round_trip(const Partial& partial) {
  const auto bytes = encode_partial(partial);
  EXPECT_TRUE(bytes) << to_string(bytes.error());
  auto back = decode_partial(*bytes, kPartialVersion, {});
  EXPECT_TRUE(back) << to_string(back.error());
  return *back;
}

TEST(PartialCodec, KeepsOrderAndStaysWithinTheStatedTolerance) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const Partial partial = samples::partial(seed);
    const Partial back = round_trip(partial);
    ASSERT_EQ(back.polygons.size(), partial.polygons.size());
    EXPECT_GE(back.tolerance_px, partial.tolerance_px);
    EXPECT_LE(back.tolerance_px, partial.tolerance_px + 0.05f);
    for (std::size_t i = 0; i < partial.polygons.size(); ++i) {
      const auto& was = partial.polygons[i];
      const auto& is = back.polygons[i];
      EXPECT_EQ(is.hole, was.hole);
      EXPECT_LE(is.near_m, was.near_m + 1e-4f);
      EXPECT_GE(is.near_m, was.near_m - 0.011f);
      EXPECT_GE(is.far_m, was.far_m - 1e-4f);
      EXPECT_LE(is.far_m, was.far_m + 0.011f);
      ASSERT_EQ(is.ring.size(), was.ring.size());
      for (std::size_t k = 0; k < was.ring.size(); ++k) {
        EXPECT_LE((is.ring[k] - was.ring[k]).norm(), back.tolerance_px - partial.tolerance_px);
      }
    }
    ASSERT_EQ(back.features.size(), partial.features.size());
    for (std::size_t i = 0; i < partial.features.size(); ++i) {
      const auto& was = partial.features[i];
      const auto& is = back.features[i];
      EXPECT_LE((is.position - was.position).norm(), 0.05f);
      EXPECT_NEAR(is.scale, was.scale, kPartialScaleStep / 2);
      EXPECT_NEAR(std::remainder(is.angle - was.angle, 2 * std::numbers::pi), 0, 0.001);
      EXPECT_EQ(is.descriptor, was.descriptor);
    }
  }
}

TEST(PartialCodec, EncodesADecodedPartialToTheSameBytes) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    const auto once = encode_partial(samples::partial(seed));
    ASSERT_TRUE(once);
    const auto back = decode_partial(*once, kPartialVersion, {});
    ASSERT_TRUE(back);
    const auto twice = encode_partial(*back);
    ASSERT_TRUE(twice);
    EXPECT_EQ(*twice, *once);
  }
}

TEST(PartialCodec, KeepsPartialsWithoutPolygonsOrFeatures) {
  Partial partial = samples::partial(1);
  partial.features.clear();
  EXPECT_EQ(round_trip(partial).polygons.size(), partial.polygons.size());
  partial = samples::partial(1);
  partial.polygons.clear();
  for (auto& feature : partial.features) feature.descriptor.clear();
  EXPECT_EQ(round_trip(partial).features.size(), partial.features.size());
  const Partial none = round_trip(Partial{});
  EXPECT_TRUE(none.polygons.empty());
  EXPECT_TRUE(none.features.empty());
}

TEST(PartialCodec, RefusesWhatItCannotKeep) {
  const auto refused = [](const Partial& partial) {
    const auto bytes = encode_partial(partial);
    return !bytes && bytes.error().kind == base::ErrorKind::kArgument;
  };
  Partial partial = samples::partial(2);
  partial.polygons[0].ring.resize(2);
  EXPECT_TRUE(refused(partial));
  partial = samples::partial(2);
  partial.polygons[1].ring[0].x() = std::nanf("");
  EXPECT_TRUE(refused(partial));
  partial = samples::partial(2);
  partial.polygons[1].far_m = partial.polygons[1].near_m - 1;
  EXPECT_TRUE(refused(partial));
  partial = samples::partial(2);
  partial.features[1].descriptor.pop_back();
  EXPECT_TRUE(refused(partial));
  partial = samples::partial(2);
  partial.features.resize(201, partial.features[0]);
  EXPECT_TRUE(refused(partial));
}

TEST(PartialCodec, RefusesOtherVersionsAndMoreThanTheLimits) {
  const auto bytes = encode_partial(samples::partial(3));
  ASSERT_TRUE(bytes);
  EXPECT_EQ(decode_partial(*bytes, 9, {}).error().kind, base::ErrorKind::kUnsupported);
  DecodeLimits limits;
  limits.max_vertices = 5;
  EXPECT_EQ(decode_partial(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
  limits = {};
  limits.max_polygons = 2;
  EXPECT_EQ(decode_partial(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
  limits = {};
  limits.max_features = 6;
  EXPECT_EQ(decode_partial(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
}

TEST(PartialCodec, SurvivesHostileBytes) {
  const auto bytes = encode_partial(samples::partial(4));
  ASSERT_TRUE(bytes);
  const auto decode = [](std::span<const std::uint8_t> b) { return decode_partial(b, 1, {}); };
  samples::expect_errors_when_cut(*bytes, decode);
  samples::survive_changes(*bytes, 3000, [&](std::span<const std::uint8_t> b) {
    const auto partial = decode(b);
    if (partial) {
      EXPECT_TRUE(encode_partial(*partial));
    }
    return partial.has_value();
  });
}

}  // namespace
}  // namespace touchline::codec
