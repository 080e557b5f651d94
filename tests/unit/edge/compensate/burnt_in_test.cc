#include "edge/compensate/burnt_in.h"

#include <gtest/gtest.h>

#include <cmath>

#include "shared/image/no_picture.h"

namespace touchline::compensate {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 360;
const image::Rect kBug{40, 24, 150, 26};

struct Scene {
  double right_px = 23;  // the head turns this much from picture to picture
  double down_px = 5;
  bool bug = true;
};

image::Frame picture(const Scene& scene, int index) {
  image::Frame frame;
  frame.planes[0] = image::Image<std::uint16_t>(kWidth, kHeight);
  for (int i : {1, 2})
    frame.planes[static_cast<std::size_t>(i)] =
        image::Image<std::uint16_t>(kWidth / 2, kHeight, 480);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const double u = x + scene.right_px * index;
      const double v = y + scene.down_px * index;
      const double texture = 200 * std::sin(u / 4.1) * std::sin(v / 3.7 + u / 90);
      const double hoarding = v > 90 && v < 110 ? 300 : 0;
      frame.planes[0](x, y) = static_cast<std::uint16_t>(300 + texture + hoarding);
      if (scene.bug && kBug.contains(x, y))
        frame.planes[0](x, y) = ((x - kBug.x) / 6 + (y - kBug.y) / 9) % 2 == 0 ? 900 : 150;
    }
  }
  return frame;
}

std::vector<image::FramePtr> take(const Scene& scene) {
  std::vector<image::FramePtr> pictures;
  for (int i = 0; i < 12; ++i)
    pictures.push_back(std::make_shared<const image::Frame>(picture(scene, i)));
  return pictures;
}

TEST(BurntIn, CoversAScoreBugAndLittleElse) {
  const BurntIn found = find_burnt_in(take({}), {});
  ASSERT_FALSE(found.empty());
  int covered = 0;
  int beside = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (found.mask(x, y) == 0) continue;
      EXPECT_TRUE(found.bounds.contains(x, y));
      ++(kBug.contains(x, y) ? covered : beside);
    }
  }
  EXPECT_EQ(covered, kBug.width * kBug.height);
  EXPECT_LT(beside, kBug.width * kBug.height / 2);
}

TEST(BurntIn, FindsNothingWhereThereIsNothing) {
  EXPECT_TRUE(find_burnt_in(take({23, 5, false}), {}).empty());
  // A hoarding's edge stands while the head only pans.
  EXPECT_TRUE(find_burnt_in(take({23, 0, false}), {}).empty());
  // All stands while the head stands.
  EXPECT_TRUE(find_burnt_in(take({0, 0, true}), {}).empty());
  EXPECT_TRUE(find_burnt_in({}, {}).empty());
}

TEST(BurntIn, BlanksWhatIsUnderTheMaskAlone) {
  const BurntIn found = find_burnt_in(take({}), {});
  ASSERT_FALSE(found.empty());
  const image::Frame before = picture({}, 3);
  image::Frame after = before;
  blank(found, after);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool gone = image::no_picture(after.planes[1](x / 2, y), after.planes[2](x / 2, y));
      if (found.mask(x, y) != 0) {
        EXPECT_TRUE(gone);
      } else {
        EXPECT_EQ(after.planes[0](x, y), before.planes[0](x, y));
        EXPECT_TRUE(!gone || found.mask(x ^ 1, y) != 0);
      }
    }
  }
  image::Frame other = before;
  blank({}, other);
  EXPECT_EQ(other.planes[0], before.planes[0]);
}

TEST(BurntInOptions, NamesTheFieldThatIsOutOfBounds) {
  BurntInOptions options;
  options.least_share = 0;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_NE(base::to_string(status.error()).find("least_share"), std::string::npos);
}

}  // namespace
}  // namespace touchline::compensate
