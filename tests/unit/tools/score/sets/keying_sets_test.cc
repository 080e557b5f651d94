// The keying sets on small made-up data of the same layout.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "shared/image/colour.h"
#include "tests/support/folders.h"
#include "tools/draw/canvas.h"
#include "tools/score/sets/fixed_view.h"
#include "tools/score/sets/keying_cdnet_highway.h"
#include "tools/score/sets/keying_lemur.h"
#include "tools/score/sets/set_pictures.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;
using Grey = image::Image<std::uint8_t>;
using Rgb = image::Image<image::Rgb8>;

constexpr int kWidth = 160;
constexpr int kHeight = 120;

// Ground with a pattern; a bright box at `left` when it is not negative.
Rgb scene(int left) {
  Rgb out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const auto v = static_cast<std::uint8_t>(90 + 20 * std::sin(x * 0.13) * std::cos(y * 0.09));
      out(x, y) = {v, static_cast<std::uint8_t>(v + 10), static_cast<std::uint8_t>(v - 10)};
      if (left >= 0 && x >= left && x < left + 20 && y >= 50 && y < 80) out(x, y) = {230, 40, 50};
    }
  }
  return out;
}

Grey box(int left) {
  Grey out(kWidth, kHeight);
  for (int y = 50; y < 80; ++y) {
    for (int x = std::max(0, left); x < std::min(kWidth, left + 20); ++x) out(x, y) = 255;
  }
  return out;
}

const SetCell& cell(const SetRow& row, const std::string& name) {
  for (const SetCell& c : row.cells) {
    if (c.name == name) return c;
  }
  ADD_FAILURE() << row.label << " has no " << name;
  static const SetCell kNone;
  return kNone;
}

TEST(FixedView, FindsWhatWasNotThereBefore) {
  FixedView view(kWidth, kHeight);
  for (int i = 0; i < 8; ++i) {
    view.learn(image::from_rgb(scene(-1), image::PixelFormat::kYuv422p10, {}));
  }
  const auto format = image::PixelFormat::kYuv422p10;
  const Grey empty = view.key(image::from_rgb(scene(-1), format, {}));
  const Grey found = view.key(image::from_rgb(scene(60), format, {}));
  const Grey truth = box(60);
  int wrong = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    EXPECT_EQ(empty.data()[i], 0);
    wrong += (truth.data()[i] >= 128) != (found.data()[i] >= 128);
  }
  EXPECT_LT(wrong, 60);
}

TEST(FixedView, WithoutPlateShowsNobodyEverywhere) {
  FixedView view(kWidth, kHeight);
  const Grey found = view.key(image::from_rgb(scene(60), image::PixelFormat::kYuv422p10, {}));
  EXPECT_EQ(found.width(), kWidth);
}

TEST(ChangeCounts, FollowTheConventions) {
  Grey truth(6, 1), region(6, 1, 255), found(6, 1);
  const std::uint8_t labels[] = {255, 255, 0, 50, 170, 85};
  for (int i = 0; i < 6; ++i) truth(i, 0) = labels[i];
  found(0, 0) = found(3, 0) = found(4, 0) = found(5, 0) = 255;
  ChangeCounts counts;
  counts.add(truth, region, found);
  EXPECT_EQ(counts.true_positive, 1);
  EXPECT_EQ(counts.false_negative, 1);
  EXPECT_EQ(counts.false_positive, 1);  // the shadow
  EXPECT_EQ(counts.true_negative, 1);
  EXPECT_DOUBLE_EQ(counts.f_score(), 0.5);
  EXPECT_DOUBLE_EQ(counts.shadow_as_motion(), 1);
  ChangeCounts none;
  none.add(truth, Grey(6, 1), found);
  EXPECT_TRUE(std::isnan(none.f_score()));
}

TEST(KeyingCdnet, ScoresAMovingBox) {
  const support::TempFolder data;
  const fs::path folder = data / "keying-cdnet-highway";
  fs::create_directories(folder / "groundtruth");
  ASSERT_TRUE(write_rgb(folder / "ROI.bmp", Rgb(kWidth, kHeight, {255, 255, 255})));
  for (int i = 0; i < 24; ++i) {
    const int left = i < 8 ? -100 : 8 * (i - 8);
    ASSERT_TRUE(write_rgb(folder / "input" / fmt::format("in{:06}.jpg", 560 + i), scene(left)));
    ASSERT_TRUE(write_rgb(folder / "groundtruth" / fmt::format("gt{:06}.png", 560 + i),
                          draw::from_grey(box(left))));
  }
  SetOptions options;
  options.data = data.path();
  options.pictures = data / "pictures";
  const auto report = run_keying_cdnet_highway(options);
  ASSERT_TRUE(report) << base::to_string(report.error());
  ASSERT_EQ(report->rows.size(), 8U);
  EXPECT_GT(cell(report->rows[0], "F-score").value, 0.8);
  for (const SetRow& row : report->rows) EXPECT_GT(cell(row, "F-score").n, 0U) << row.label;
  EXPECT_TRUE(fs::exists(data / "pictures" / "keying-cdnet-highway-0.png"));
}

TEST(AlphaError, CountsTheUnknownPixelsOnly) {
  Grey truth(4, 1), found(4, 1), trimap(4, 1);
  truth(1, 0) = 255;
  found(3, 0) = 255;
  trimap(0, 0) = 0;
  trimap(1, 0) = trimap(2, 0) = 128;
  trimap(3, 0) = 255;
  const AlphaError error = alpha_error(truth, found, trimap);
  EXPECT_EQ(error.pixels, 2U);
  EXPECT_DOUBLE_EQ(error.mean, 0.5);
  EXPECT_DOUBLE_EQ(error.sum, 1);
  EXPECT_EQ(error.iou, 0);
  EXPECT_EQ(alpha_error(truth, truth, {}).mean, 0);
  EXPECT_EQ(alpha_error(truth, truth, {}).iou, 1);
}

TEST(KeyingLemur, ScoresABox) {
  const support::TempFolder data;
  const fs::path folder = data / "keying-lemur";
  fs::create_directories(folder);
  const Grey truth = box(60);
  Grey trimap = truth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool outer = x >= 55 && x < 85 && y >= 45 && y < 85;
      const bool inner = x >= 65 && x < 75 && y >= 55 && y < 75;
      if (outer && !inner) trimap(x, y) = 128;
    }
  }
  ASSERT_TRUE(write_rgb(folder / "lemur.png", scene(60)));
  ASSERT_TRUE(write_rgb(folder / "lemur_background.png", scene(-1)));
  ASSERT_TRUE(write_rgb(folder / "lemur_foreground.png", Rgb(kWidth, kHeight, {230, 40, 50})));
  ASSERT_TRUE(write_rgb(folder / "lemur_alpha.png", draw::from_grey(truth)));
  ASSERT_TRUE(write_rgb(folder / "lemur_trimap.png", draw::from_grey(trimap)));
  SetOptions options;
  options.data = data.path();
  const auto report = run_keying_lemur(options);
  ASSERT_TRUE(report) << base::to_string(report.error());
  ASSERT_GE(report->rows.size(), 5U);
  EXPECT_LT(cell(report->rows[0], "alpha error").value, 10);
  EXPECT_GT(cell(report->rows[0], "IoU at 0.5").value, 85);
  EXPECT_LT(cell(report->rows.back(), "alpha error").value, 1);  // both colours known
}

TEST(KeyingSets, SayWhatIsNotThere) {
  const support::TempFolder data;
  SetOptions options;
  options.data = data.path();
  for (const auto run : {run_keying_cdnet_highway, run_keying_lemur}) {
    const auto missing = run(options);
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().kind, base::ErrorKind::kNotFound);
    EXPECT_THAT(missing.error().where, testing::HasSubstr("keying-"));
  }
  fs::create_directories(data / "keying-lemur");
  EXPECT_FALSE(run_keying_lemur(options));
  fs::create_directories(data / "keying-cdnet-highway");
  EXPECT_FALSE(run_keying_cdnet_highway(options));
}

}  // namespace
}  // namespace touchline::score
