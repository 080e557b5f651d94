#include "hub/decode/decode_set.h"

#include <gtest/gtest.h>

#include "shared/codec/view_codec.h"
#include "tests/unit/shared/codec/sample_views.h"

namespace touchline::decode {
namespace {

scene::FrameSetEntry entry(const std::string& camera) {
  return {{camera}, *codec::encode(samples::view(camera, 4))};
}

TEST(DecodeSet, KeepsConfigurationOrderAndReasons) {
  scene::FrameSet set;
  set.instant.ns = 160'000'000;
  set.entries = {entry("m2"), {{"f1"}, scene::Absent{scene::AbsentReason::kLate}}, entry("m1")};
  const auto decoded = decode_set(set);
  ASSERT_TRUE(decoded);
  EXPECT_EQ(decoded->instant, set.instant);
  ASSERT_EQ(decoded->views.size(), 2u);
  EXPECT_EQ(decoded->views[0].id.camera.value, "m2");
  EXPECT_EQ(decoded->views[1].id.camera.value, "m1");
  ASSERT_EQ(decoded->absent.size(), 1u);
  EXPECT_EQ(decoded->absent[0].reason, scene::AbsentReason::kLate);
  EXPECT_FALSE(decoded->absent[0].error);
}

TEST(DecodeSet, AViewThatDoesNotDecodeIsAbsentNotEmpty) {
  scene::FrameSet set;
  set.entries = {entry("m1"), entry("m2")};
  std::get<codec::EncodedView>(set.entries[0].view).parts[0].bytes.resize(9);
  const auto decoded = decode_set(set);
  ASSERT_TRUE(decoded);
  ASSERT_EQ(decoded->views.size(), 1u);
  ASSERT_EQ(decoded->absent.size(), 1u);
  EXPECT_EQ(decoded->absent[0].camera.value, "m1");
  EXPECT_EQ(decoded->absent[0].reason, scene::AbsentReason::kUndecodable);
  ASSERT_TRUE(decoded->absent[0].error);
  EXPECT_EQ(decoded->absent[0].error->kind, base::ErrorKind::kTruncated);
}

TEST(DecodeSet, RefusesMixedUpSets) {
  scene::FrameSet set;
  set.entries = {entry("m1"), entry("m1")};
  EXPECT_FALSE(decode_set(set));
  set.entries = {entry("m1")};
  set.entries[0].camera.value = "m2";
  EXPECT_FALSE(decode_set(set));
}

}  // namespace
}  // namespace touchline::decode
