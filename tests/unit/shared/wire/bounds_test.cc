#include "shared/wire/bounds.h"

#include <gtest/gtest.h>

#include <limits>

namespace touchline::wire {
namespace {

TEST(Bounds, AFrameWithTooMuchIsNamed) {
  FrameMessage message;
  message.camera = "m1";
  EXPECT_TRUE(check_bounds(message));
  message.parts.resize(kMaxParts);
  EXPECT_TRUE(check_bounds(message));
  message.parts.resize(kMaxParts + 1);
  const base::Status many = check_bounds(message);
  ASSERT_FALSE(many);
  EXPECT_EQ(many.error().kind, base::ErrorKind::kLimit);
  EXPECT_EQ(many.error().where, "m1");
  message.parts.resize(1);
  message.parts[0].bytes.resize(kMaxPartBytes);
  EXPECT_TRUE(check_bounds(message));
  message.parts[0].bytes.resize(kMaxPartBytes + 1);
  EXPECT_FALSE(check_bounds(message));
  message.parts.assign(3, Part{1, 1, std::vector<std::uint8_t>(kMaxPartBytes)});
  EXPECT_FALSE(check_bounds(message));
}

TEST(Bounds, OnlyValidCameraIds) {
  PlateMessage message;
  EXPECT_FALSE(check_bounds(message));
  message.camera = "a b";
  EXPECT_FALSE(check_bounds(message));
  message.camera = "m1";
  EXPECT_TRUE(check_bounds(message));
  message.bytes.resize(kMaxPlateBytes + 1);
  EXPECT_FALSE(check_bounds(message));
}

TEST(Bounds, TextsAndListsOfAStatus) {
  StatusMessage message;
  message.camera = "m1";
  EXPECT_TRUE(check_bounds(message));
  message.text.assign(kMaxTextChars + 1, 'x');
  EXPECT_FALSE(check_bounds(message));
  message.text = std::string("a\0b", 3);
  EXPECT_EQ(check_bounds(message).error().kind, base::ErrorKind::kFormat);
  message.text.clear();
  message.stages.resize(kMaxListEntries + 1);
  EXPECT_FALSE(check_bounds(message));
  message.stages.assign(1, StageRate{std::string(kMaxNameChars + 1, 's'), 1, 1});
  EXPECT_FALSE(check_bounds(message));
}

TEST(Bounds, PlacesAreNumbersNearThePitch) {
  PeopleMessage message;
  message.camera = "m1";
  message.places = {{10, -20, 0.2F}};
  EXPECT_TRUE(check_bounds(message));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const Place& bad : {Place{nan, 0, 1}, Place{0, nan, 1}, Place{0, 0, nan}, Place{0, 0, 0},
                           Place{1e6F, 0, 1}, Place{0, -1e6F, 1}, Place{0, 0, -1}}) {
    message.places = {{10, -20, 0.2F}, bad};
    const auto refused = check_bounds(message);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, base::ErrorKind::kFormat);
  }
  message.places.assign(kMaxPlaces + 1, Place{0, 0, 1});
  const auto refused = check_bounds(message);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, base::ErrorKind::kLimit);
}

}  // namespace
}  // namespace touchline::wire
