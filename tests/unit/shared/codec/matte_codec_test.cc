#include "shared/codec/matte_codec.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/folders.h"
#include "tests/unit/shared/codec/hostile_bytes.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::codec {
namespace {

void expect_round_trip(const image::Matte& matte) {
  const auto bytes = encode_matte(matte);
  ASSERT_TRUE(bytes) << to_string(bytes.error());
  const auto back = decode_matte(*bytes, kMatteVersion, {});
  ASSERT_TRUE(back) << to_string(back.error());
  EXPECT_TRUE(*back == matte);
}

TEST(MatteCodec, KeepsMattesExactly) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    samples::Numbers numbers(seed);
    expect_round_trip(samples::matte(1 + numbers.below(90), 1 + numbers.below(70), seed));
  }
}

TEST(MatteCodec, KeepsNoiseExactly) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    samples::Numbers numbers(seed);
    expect_round_trip(samples::noise_matte(1 + numbers.below(50), 1 + numbers.below(40), seed));
  }
}

TEST(MatteCodec, KeepsEmptyAndFullPicturesAndRegions) {
  image::Matte matte = samples::matte(33, 21, 5);
  for (auto* plane : {&matte.alpha, &matte.unknown, &matte.occluders}) {
    *plane = image::Image<std::uint8_t>(33, 21, 255);
  }
  expect_round_trip(matte);
  for (auto* plane : {&matte.alpha, &matte.unknown, &matte.occluders}) {
    *plane = image::Image<std::uint8_t>(33, 21, 0);
  }
  expect_round_trip(matte);
  matte.region = {7, 3, 20, 11};
  matte.alpha(7, 3) = 1;
  matte.alpha(26, 13) = 254;
  matte.unknown(26, 3) = 255;
  expect_round_trip(matte);
  matte = image::Matte{};
  expect_round_trip(matte);
}

TEST(MatteCodec, RefusesMattesThatBreakTheirOwnRules) {
  image::Matte matte = samples::matte(40, 30, 1);
  matte.unknown(3, 4) = 7;
  EXPECT_EQ(encode_matte(matte).error().kind, base::ErrorKind::kArgument);
  matte = samples::matte(40, 30, 1);
  matte.occluders = image::Image<std::uint8_t>(39, 30);
  EXPECT_EQ(encode_matte(matte).error().kind, base::ErrorKind::kArgument);
  matte = samples::matte(40, 30, 1);
  matte.region = {0, 0, 41, 30};
  EXPECT_EQ(encode_matte(matte).error().kind, base::ErrorKind::kArgument);
  matte = samples::matte(40, 30, 1);
  matte.alpha(39, 29) = 9;
  matte.region = {0, 0, 40, 29};
  EXPECT_EQ(encode_matte(matte).error().kind, base::ErrorKind::kArgument);
}

TEST(MatteCodec, RefusesOtherVersionsAndLargerPictures) {
  const auto bytes = encode_matte(samples::matte(40, 30, 1));
  ASSERT_TRUE(bytes);
  EXPECT_EQ(decode_matte(*bytes, 2, {}).error().kind, base::ErrorKind::kUnsupported);
  DecodeLimits limits;
  limits.max_width = 39;
  EXPECT_EQ(decode_matte(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
  limits = {};
  limits.max_part_bytes = 10;
  EXPECT_EQ(decode_matte(*bytes, 1, limits).error().kind, base::ErrorKind::kLimit);
}

TEST(MatteCodec, SurvivesHostileBytes) {
  const auto bytes = encode_matte(samples::matte(40, 30, 3));
  ASSERT_TRUE(bytes);
  const auto decode = [](std::span<const std::uint8_t> b) { return decode_matte(b, 1, {}); };
  samples::expect_errors_when_cut(*bytes, decode);
  // Whatever decodes is a matte that the encoder takes.
  samples::survive_changes(*bytes, 3000, [&](std::span<const std::uint8_t> b) {
    const auto matte = decode(b);
    if (matte) {
      EXPECT_TRUE(encode_matte(*matte));
    }
    return matte.has_value();
  });
}

// The budget of the chapter's 45 Mbit/s a camera: 16 KB in the mean, 48 KB at worst.
TEST(MatteCodecData, MattesOfPeopleAreSmall) {
  const auto data = support::data_folder();
  if (!data) GTEST_SKIP() << "set TOUCHLINE_DATA: no recordings here";
  const std::filesystem::path truth = *data / "recordings" / "dev-attack" / "truth";
  if (!std::filesystem::exists(truth)) GTEST_SKIP() << "no recording dev-attack here";
  std::size_t sum = 0;
  std::size_t count = 0;
  std::size_t worst = 0;
  for (const char* camera : {"m1", "m2", "m3", "f1", "f2", "c1"}) {
    for (const char* frame : {"000000.png", "000015.png", "000029.png"}) {
      const cv::Mat1b picture =
          cv::imread((truth / camera / "matte" / frame).string(), cv::IMREAD_GRAYSCALE);
      if (picture.empty()) continue;
      image::Matte matte;
      matte.region = {0, 0, picture.cols, picture.rows};
      matte.alpha = image::Image<std::uint8_t>(picture.cols, picture.rows);
      matte.unknown = image::Image<std::uint8_t>(picture.cols, picture.rows);
      matte.occluders = image::Image<std::uint8_t>(picture.cols, picture.rows);
      std::copy(picture.begin(), picture.end(), matte.alpha.data());
      expect_round_trip(matte);
      const std::size_t size = encode_matte(matte)->size();
      sum += size;
      worst = std::max(worst, size);
      ++count;
    }
  }
  ASSERT_GT(count, 0u);
  EXPECT_LE(sum / count, 16'384u);
  EXPECT_LE(worst, 49'152u);
}

}  // namespace
}  // namespace touchline::codec
