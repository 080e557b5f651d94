// What is drawn on a clip's frames, against a camera and a key that are known.
#include "tools/score/sets/clip_notes.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/folders.h"
#include "tests/unit/tools/score/sets/set_cameras.h"

namespace touchline::score {
namespace {

const pitch::PitchModel& soccer() {
  static const pitch::PitchModel kPitch = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  return kPitch;
}

Eigen::Vector2d image_of(const geometry::CameraEstimate& camera, double x, double y) {
  return project(camera, soccer().on_turf({x, y})).value_or(Eigen::Vector2d::Constant(-1e6));
}

TEST(ClipNotes, LineAcrossThePitchLiesOnItsImage) {
  const auto camera = main_camera(20, 0, 1200);
  const Segment segment{image_of(camera, 20, -15), image_of(camera, 20, 25)};
  EXPECT_NEAR(across_distance(camera, soccer(), segment).value_or(99), 0, 1e-6);
  const Segment skew{image_of(camera, 19.5, -15), image_of(camera, 20.5, 25)};
  EXPECT_GT(across_distance(camera, soccer(), skew).value_or(0), 2);
  const Segment sky{Eigen::Vector2d(100, -4000), Eigen::Vector2d(120, -3000)};
  EXPECT_FALSE(across_distance(camera, soccer(), sky));
}

TEST(ClipNotes, OutlineOfTurfIsTheHoardingsOnly) {
  const auto camera = main_camera(0, 10, 1100);
  NotedFrame frame;
  frame.turf = {image_of(camera, -20, 37), image_of(camera, 20, 37), {959, 539}, {0, 539}};
  frame.turf[0].x() = 0;
  frame.turf[1].x() = 959;
  const auto points = turf_edges(camera, soccer(), frame);
  ASSERT_FALSE(points.empty());
  for (const EdgePoint& point : points) {
    EXPECT_EQ(point.axis, 0);
    EXPECT_NEAR(point.on_turf.y(), 37, 2);
    EXPECT_LT(edge_distance(camera, soccer(), point, point.on_turf.y()).value_or(99), 1e-6);
  }
}

TEST(ClipNotes, PersonIsHeldByEnoughForeground) {
  image::Image<std::uint8_t> matte(100, 100);
  const NotedBox box{{20, 20}, {39, 79}};
  EXPECT_FALSE(is_held(matte.view(), box));
  for (int y = 20; y < 80; ++y)
    for (int x = 26; x < 32; ++x) matte(x, y) = 255;
  EXPECT_TRUE(is_held(matte.view(), box));
  for (int y = 20; y < 40; ++y)  // no head and shoulders
    for (int x = 26; x < 32; ++x) matte(x, y) = 0;
  EXPECT_FALSE(is_held(matte.view(), box));
  EXPECT_FALSE(is_held(matte.view(), {{200, 200}, {300, 300}}));
}

TEST(ClipNotes, TurfAwayFromPeopleIsCounted) {
  image::Image<std::uint8_t> matte(100, 100);
  NotedFrame frame;
  frame.turf = {{0, 50}, {100, 50}, {100, 100}, {0, 100}};
  frame.people = {{{10, 60}, {20, 80}}};
  for (int y = 60; y < 81; ++y)
    for (int x = 8; x < 23; ++x) matte(x, y) = 255;  // a person and a rim of turf
  for (int x = 0; x < 100; ++x) matte(x, 20) = 255;  // the stands
  EXPECT_EQ(foreground_on_turf(matte.view(), frame).value_or(1), 0);
  for (int y = 50; y < 100; ++y)
    for (int x = 80; x < 100; ++x) matte(x, y) = 255;
  EXPECT_NEAR(foreground_on_turf(matte.view(), frame).value_or(0), 0.22, 0.03);
  EXPECT_FALSE(foreground_on_turf(matte.view(), {}));
}

TEST(ClipNotes, AreReadAndBrokenOnesRefused) {
  const support::TempFolder folder;
  const auto path = folder.path() / "clip.json";
  const auto read = [&](const char* text) {
    std::ofstream(path) << text;
    return read_clip_notes(path);
  };
  const auto notes = read(
      R"({"frame_width": 1920, "frame_height": 1080, "frames": [{"frame": 10, "field": [[0, 1], [2, 3], [4, 5]],
          "players": [{"type": 1, "team": 1, "position": [[9, 8], [5, 6]]}], "vanishing_point": [[[1, 2], [3, 4]]]}]})");
  ASSERT_TRUE(notes);
  const NotedFrame& frame = notes->frames.at(9);
  EXPECT_EQ(frame.turf.size(), 3U);
  ASSERT_EQ(frame.people.size(), 1U);
  EXPECT_EQ(frame.people[0].low, Eigen::Vector2d(5, 6));
  EXPECT_EQ(frame.across.size(), 1U);
  for (const char* broken :
       {"", "[]", "{}", R"({"frame_width": 0, "frame_height": 1080, "frames": []})",
        R"({"frame_width": 1920, "frame_height": 1080, "frames": 3})",
        R"({"frame_width": 1920, "frame_height": 1080, "frames": [{"frame": 0}]})",
        R"({"frame_width": 1920, "frame_height": 1080, "frames": ["x"]})"})
    EXPECT_FALSE(read(broken)) << broken;
}

}  // namespace
}  // namespace touchline::score
