// free-d D1: bytes written by hand from the manual's field table, whole counts kept, and what is no
// such message refused by name.
#include "shared/codec/free_d.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace touchline::codec {
namespace {

// Camera 1; pan +90, tilt -10, roll +0.5 degrees; x 1500 mm, y -52500 mm, height 20250 mm; zoom
// 85000, focus 0, spare 0x0102. The other 28 bytes sum to 1514 = 0x5EA; 0x40 - 0xEA = 0x56.
constexpr std::array<std::uint8_t, kFreeDBytes> kByHand{
    0xD1, 0x01, 0x2D, 0x00, 0x00, 0xFB, 0x00, 0x00, 0x00, 0x40, 0x00, 0x01, 0x77, 0x00, 0xCC,
    0xBB, 0x00, 0x13, 0xC6, 0x80, 0x01, 0x4C, 0x08, 0x00, 0x00, 0x00, 0x01, 0x02, 0x56};

FreeD by_hand() {
  FreeD out;
  out.camera_id = 1;
  out.pan = 90 * 32768;
  out.tilt = -10 * 32768;
  out.roll = 16384;
  out.x = 1500 * 64;
  out.y = -52500 * 64;
  out.height = 20250 * 64;
  out.zoom = 85000;
  out.spare = 0x0102;
  return out;
}

TEST(FreeD, WritesTheBytesOfTheManual) {
  const auto bytes = encode_free_d(by_hand());
  ASSERT_TRUE(bytes.has_value()) << base::to_string(bytes.error());
  EXPECT_THAT(*bytes, testing::ElementsAreArray(kByHand));
}

TEST(FreeD, ReadsTheBytesOfTheManual) {
  const auto message = decode_free_d(kByHand);
  ASSERT_TRUE(message.has_value()) << base::to_string(message.error());
  EXPECT_EQ(*message, by_hand());
}

// Appendix B gives the ends of the ranges in hex.
TEST(FreeD, TheManualsEndsOfRanges) {
  FreeD message;
  message.pan = -180 * 32768;
  message.roll = 180 * 32768;
  message.x = -131072 * 64;
  message.height = 131072 * 64 - 1;
  const auto bytes = encode_free_d(message);
  ASSERT_TRUE(bytes.has_value());
  const auto three = [&](std::size_t at) {
    return std::vector<int>{(*bytes)[at], (*bytes)[at + 1], (*bytes)[at + 2]};
  };
  EXPECT_EQ(three(2), (std::vector<int>{0xA6, 0, 0}));
  EXPECT_EQ(three(8), (std::vector<int>{0x5A, 0, 0}));
  EXPECT_EQ(three(11), (std::vector<int>{0x80, 0, 0}));
  EXPECT_EQ(three(17), (std::vector<int>{0x7F, 0xFF, 0xFF}));
}

TEST(FreeD, DecodeOfEncodeIsTheMessage) {
  std::mt19937 random(5);
  std::uniform_int_distribution<std::int32_t> value(-kFreeDMost - 1, kFreeDMost);
  std::uniform_int_distribution<std::uint32_t> count(0, kFreeDMostCount);
  for (int i = 0; i < 1000; ++i) {
    const FreeD message{static_cast<std::uint8_t>(count(random)),
                        value(random),
                        value(random),
                        value(random),
                        value(random),
                        value(random),
                        value(random),
                        count(random),
                        count(random),
                        static_cast<std::uint16_t>(count(random))};
    const auto bytes = encode_free_d(message);
    ASSERT_TRUE(bytes.has_value());
    const auto back = decode_free_d(*bytes);
    ASSERT_TRUE(back.has_value());
    ASSERT_EQ(*back, message);
  }
}

TEST(FreeD, OneWrongByteIsNoticed) {
  for (std::size_t at = 0; at < kFreeDBytes; ++at) {
    auto bytes = kByHand;
    bytes[at] ^= 0x10;
    EXPECT_FALSE(decode_free_d(bytes).has_value()) << at;
  }
}

TEST(FreeD, AnotherLengthOrTypeIsNamed) {
  const std::vector<std::uint8_t> longer(30, 0);
  EXPECT_EQ(decode_free_d(std::span(kByHand).first(28)).error().kind, base::ErrorKind::kTruncated);
  EXPECT_EQ(decode_free_d(longer).error().kind, base::ErrorKind::kLimit);
  std::array<std::uint8_t, kFreeDBytes> other{};
  other[0] = 0xD3;
  EXPECT_EQ(decode_free_d(other).error().kind, base::ErrorKind::kUnsupported);
}

TEST(FreeD, WhatDoesNotFitIsNamed) {
  FreeD message;
  message.y = kFreeDMost + 1;
  const auto bytes = encode_free_d(message);
  ASSERT_FALSE(bytes.has_value());
  EXPECT_EQ(bytes.error().where, "free-d y");
}

}  // namespace
}  // namespace touchline::codec
