// The key on painted pitches.
#include "edge/key/key.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "edge/plate/plate_builder.h"
#include "tests/unit/edge/key/key_scene.h"

namespace touchline::key {
namespace {

using plate::Disc;
using plate::test_camera;
using plate::test_pitch;

class Key : public KeyScene {
 protected:
  image::Matte matte(const std::vector<Disc>& discs, const KeyOptions& options = {}) const {
    return key(scene_->frame(discs, 3), camera_, *plate_, pitch_, options).matte;
  }
};

TEST_F(Key, TheBoundaryOfADiscIsWithinAPixel) {
  for (const double radius : {3.0, 6.0, 14.0}) {
    const Disc disc{{240.3, 180.7}, radius};
    const auto alpha = matte({disc}).alpha;
    for (int y = 0; y < alpha.height(); ++y)
      for (int x = 0; x < alpha.width(); ++x) {
        const double away = (Eigen::Vector2d(x, y) - disc.centre).norm();
        if (away < radius - 1) {
          EXPECT_GE(alpha(x, y), 128) << radius << ": " << x << ' ' << y;
        }
        if (away > radius + 1) {
          EXPECT_LT(alpha(x, y), 128) << radius << ": " << x << ' ' << y;
        }
      }
  }
}

TEST_F(Key, CoverageOfTheEdgeIsSoft) {
  const Disc disc{{240, 180}, 14};
  const auto alpha = matte({disc}).alpha;
  double sum = 0;
  for (int y = 150; y < 210; ++y)
    for (int x = 210; x < 270; ++x) sum += alpha(x, y) / 255.0;
  EXPECT_NEAR(sum, 3.14159 * 14 * 14, 0.04 * 3.14159 * 14 * 14);
}

TEST_F(Key, AnEmptyPitchHasNoForeground) {
  const auto alpha = matte({}).alpha;
  EXPECT_EQ(std::count_if(alpha.data(), alpha.data() + alpha.size(),
                          [](std::uint8_t a) { return a != 0; }),
            0);
}

TEST_F(Key, ALegThreePixelsWideIsKept) {
  std::vector<Disc> leg;
  for (int k = 0; k < 24; ++k) leg.push_back({{200.0 + 0.3 * k, 170.0 + k}, 1.5});
  const auto alpha = matte(leg).alpha;
  for (int k = 1; k < 23; ++k)
    EXPECT_GE(alpha(static_cast<int>(std::lround(200.0 + 0.3 * k)), 170 + k), 128) << k;
}

TEST_F(Key, ShadowOnTurfIsBackground) {
  auto frame = scene_->frame({}, 4);
  for (int y = 170; y < 190; ++y)
    for (int x = 180; x < 260; ++x) {
      frame.planes[0](x, y) = static_cast<std::uint16_t>(64 + 0.5 * (frame.planes[0](x, y) - 64));
      for (std::size_t c = 1; c < 3; ++c)
        frame.planes[c](x, y) =
            static_cast<std::uint16_t>(512 + 0.62 * (frame.planes[c](x, y) - 512));
    }
  const auto alpha = key(frame, camera_, *plate_, pitch_).matte.alpha;
  EXPECT_EQ(*std::max_element(alpha.data(), alpha.data() + alpha.size()), 0);
}

// A forearm four pixels wide, from a bright shirt at its upper end.
std::vector<Disc> arm(const Eigen::Vector2d& from, const Eigen::Vector2d& step,
                      const std::array<float, 3>& colour) {
  std::vector<Disc> discs{{from, 8, {400, 440, 760}}};
  for (int k = 0; k < 30; ++k) discs.push_back({from + k * step, 2, colour});
  return discs;
}

int kept(const image::Matte& matte, const std::vector<Disc>& discs) {
  int n = 0;
  for (const Disc& d : discs)
    n += matte.alpha(static_cast<int>(std::lround(d.centre.x())),
                     static_cast<int>(std::lround(d.centre.y()))) >= 128;
  return n;
}

TEST_F(Key, DarkLimbsOverTurfAreKept) {
  for (const auto& colour :
       {std::array<float, 3>{150, 500, 540}, std::array<float, 3>{110, 505, 520},
        std::array<float, 3>{80, 512, 512}}) {
    const auto discs = arm({240, 170}, {0.6, 0.8}, colour);
    EXPECT_GE(kept(matte(discs), discs), static_cast<int>(discs.size()) - 1) << colour[0];
  }
}

// A frame with this share of its light.
image::Frame in_the_shade(image::Frame frame, double share) {
  for (std::size_t c = 0; c < 3; ++c) {
    const double none = c == 0 ? 64 : 512;
    for (std::size_t i = 0; i < frame.planes[c].size(); ++i) {
      std::uint16_t& v = frame.planes[c].data()[i];
      v = static_cast<std::uint16_t>(std::lround(none + share * (v - none)));
    }
  }
  return frame;
}

TEST_F(Key, DarkLimbsInDeepShadeAreKept) {
  constexpr double kShare = 0.3;
  constexpr double kNoise = 2 / kShare;  // as much as in the light
  plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500);
  for (unsigned k = 0; k < 6; ++k)
    builder.add(in_the_shade(scene_->frame({}, 50 + k, kNoise), kShare), camera_);
  plate_ = builder.snapshot(true);
  for (const auto& colour :
       {std::array<float, 3>{150, 500, 540}, std::array<float, 3>{110, 505, 520},
        std::array<float, 3>{200, 490, 580}}) {
    const auto discs = arm({240, 170}, {0.6, 0.8}, colour);
    const auto frame = in_the_shade(scene_->frame(discs, 3, kNoise), kShare);
    EXPECT_GE(kept(key(frame, camera_, *plate_, pitch_).matte, discs),
              static_cast<int>(discs.size()) - 2)
        << colour[0];
  }
}

TEST_F(Key, NoiseIsNobodyHoweverMuchThereIs) {
  for (const double noise : {1.0, 4.0, 7.0}) {
    plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500);
    for (unsigned k = 0; k < 9; ++k) builder.add(scene_->frame({}, 50 + k, noise), camera_);
    const auto alpha =
        key(scene_->frame({}, 4, noise), camera_, *builder.snapshot(true), pitch_).matte.alpha;
    EXPECT_EQ(std::count_if(alpha.data(), alpha.data() + alpha.size(),
                            [](std::uint8_t a) { return a != 0; }),
              0)
        << noise;
  }
}

TEST_F(Key, ADarkArmBesideABrightShirtIsNoMixOfThatAndTurf) {
  std::vector<Disc> discs{{{240, 150}, 14, {880, 512, 512}}};
  for (int k = 0; k < 30; ++k) discs.push_back({{256.0, 140.0 + k}, 3.5, {215, 500, 540}});
  const auto alpha = matte(discs).alpha;
  for (int k = 0; k < 30; ++k) EXPECT_GE(alpha(256, 140 + k), 192) << k;
}

// The pixel of the picture nearest to its middle that shows a painted line.
std::optional<Eigen::Vector2d> painted_pixel(const geometry::CameraEstimate& camera,
                                             const pitch::PitchModel& pitch) {
  std::optional<Eigen::Vector2d> best;
  for (int y = 120; y < 220; ++y)
    for (int x = 120; x < 360; ++x) {
      const Eigen::Vector2d p(x, y);
      if (plate::background_at(camera, pitch, p)[0] < 700) continue;
      if (!best ||
          (p - Eigen::Vector2d(240, 170)).norm() < (*best - Eigen::Vector2d(240, 170)).norm())
        best = p;
    }
  return best;
}

TEST_F(Key, DarkLimbsOverAPaintedLineAreKept) {
  const auto line = painted_pixel(camera_, pitch_);
  ASSERT_TRUE(line);
  for (const auto& colour :
       {std::array<float, 3>{110, 505, 520}, std::array<float, 3>{130, 480, 650}}) {
    const auto discs = arm(*line - Eigen::Vector2d(15 * 0.6, 15 * 0.8), {0.6, 0.8}, colour);
    EXPECT_GE(kept(matte(discs), discs), static_cast<int>(discs.size()) - 1) << colour[0];
  }
}

TEST_F(Key, WhoPassedWhileThePlateWasLearntHidesNobodyElse) {
  plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500);
  for (unsigned k = 0; k < 9; ++k) {
    std::vector<Disc> passing;
    if (k % 4 == 1) passing.push_back({{250, 185}, 12, {800, 512, 512}});
    builder.add(scene_->frame(passing, 70 + k), camera_);
  }
  plate_ = builder.snapshot(true);
  const auto discs = arm({240, 170}, {0.6, 0.8}, {150, 500, 540});
  EXPECT_GE(kept(matte(discs), discs), static_cast<int>(discs.size()) - 1);
}

// A person in the colour of the stand, his legs over the turf.
// 1500 frames of 25 a second, of which the plate takes every fifth.
TEST_F(Key, WhoStandsForAMinuteFromTheFirstFrameOnStaysKeyed) {
  for (const auto& shirt :
       {std::array<float, 3>{400, 440, 760}, std::array<float, 3>{100, 514, 510}}) {
    std::vector<Disc> person;
    for (int k = 0; k < 10; ++k) person.push_back({{240, 170.0 + k}, 4, shirt});
    std::vector<image::Frame> frames;
    for (unsigned k = 0; k < 6; ++k) frames.push_back(scene_->frame(person, 20 + k));
    plate::PlateOptions options;
    options.update_every = 1;
    plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500, options);
    for (int k = 0; k < 300; ++k) {
      builder.add(frames[static_cast<std::size_t>(k % 6)], camera_);
      if (k != 20 && k != 299) continue;
      const auto plate = builder.snapshot(true);
      const auto result = key(frames[0], camera_, *plate, pitch_).matte;
      EXPECT_EQ(kept(result, person), 10) << "frame " << k << " luma " << shirt[0];
    }
  }
}

TEST_F(Key, WhatLooksLikeThePlateNearAPersonIsUnknown) {
  camera_ = test_camera(0, -0.15);
  SetUp();
  // The lowest row that shows the stand, in the middle column: turf has green's chroma.
  int foot = 0;
  for (int y = 0; y < 270; ++y) {
    const auto c = plate::background_at(camera_, pitch_, {240.0, static_cast<double>(y)});
    if (c[1] > 470) foot = y;
    if (c[1] < 450 && c[2] < 450) break;
  }
  ASSERT_GT(foot, 12);
  const auto stand = plate::background_at(camera_, pitch_, {240.0, foot - 4.0});
  std::vector<Disc> discs;
  for (int k = -8; k < 12; ++k) discs.push_back({{240, foot + k + 0.0}, 3, stand});
  const auto m = matte(discs);
  EXPECT_GE(m.alpha(240, foot + 8), 128);
  int hidden = 0;
  for (int y = foot - 6; y < foot; ++y)
    hidden += m.unknown(240, y) == 255 || m.alpha(240, y) >= 128;
  EXPECT_GE(hidden, 5);
  EXPECT_EQ(m.unknown(150, foot - 4), 0);
  EXPECT_EQ(m.unknown(240, foot + 40), 0);
}

TEST_F(Key, HalfAPixelOfCalibrationErrorMakesNoPeopleOfLines) {
  auto off = camera_;
  off.cam_from_world.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(0.5 / 500, Eigen::Vector3d::UnitX())) *
      off.cam_from_world.rotation;
  off.cam_from_world.translation =
      -(off.cam_from_world.rotation * geometry::position_in_world(camera_));
  const auto alpha = key(scene_->frame({}, 5), off, *plate_, pitch_).matte.alpha;
  const auto lit = std::count_if(alpha.data(), alpha.data() + alpha.size(),
                                 [](std::uint8_t a) { return a >= 128; });
  EXPECT_LT(lit, alpha.width() * alpha.height() / 2000);
}

// Lettering that runs along a board behind the far touchline.
TEST_F(Key, LetteringThatMovesAlongABoardIsNobody) {
  const auto above = geometry::project(camera_, Eigen::Vector3d(0, pitch_.width_m / 2 + 4.5, 1.0));
  ASSERT_TRUE(above);
  const auto lettering = [&](int shift) {
    std::vector<Disc> letters;
    for (int x = 40 + shift % 14; x < 440; x += 14)
      letters.push_back({{static_cast<double>(x), above->y()}, 3, {800, 512, 512}});
    return letters;
  };
  plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500);
  for (int k = 0; k < 14; ++k)
    builder.add(scene_->frame(lettering(3 * k), static_cast<unsigned>(50 + k)), camera_);
  const auto plate = builder.snapshot(true);
  auto discs = lettering(10);
  std::vector<Disc> person;
  for (int k = 0; k < 10; ++k) person.push_back({{240, 170.0 + k}, 4, {400, 440, 760}});
  discs.insert(discs.end(), person.begin(), person.end());
  const auto found = key(scene_->frame(discs, 3), camera_, *plate, pitch_).matte;
  // Most of it: the median of few samples misses some of the change.
  EXPECT_LE(kept(found, lettering(10)), static_cast<int>(lettering(10).size()) / 3);
  EXPECT_EQ(kept(found, person), 10);
}

TEST_F(Key, TheSkyAndTheUpperStandsAreNobodysPlace) {
  camera_ = test_camera(0, 0.05);
  SetUp();
  const auto result = key(scene_->frame({Disc{{240, 20}, 10}}, 6), camera_, *plate_, pitch_);
  EXPECT_EQ(result.matte.alpha(240, 20), 0);
  EXPECT_EQ(result.matte.unknown(240, 20), 0);
  EXPECT_FALSE(result.matte.region.contains(240, 20));
}

TEST_F(Key, GoalFramesAreOccludersAndUnknown) {
  camera_ = test_camera(0.75, -0.2, 900);
  SetUp();
  const auto result = key(scene_->frame({}, 7), camera_, *plate_, pitch_);
  ASSERT_FALSE(pitch_.bars.empty());
  int seen = 0;
  for (const auto& bar : pitch_.bars) {
    const auto p = geometry::project(camera_, 0.5 * (bar.start + bar.end));
    if (!p || p->x() < 1 || p->y() < 1 || p->x() > 478 || p->y() > 268) continue;
    const int x = static_cast<int>(std::lround(p->x()));
    const int y = static_cast<int>(std::lround(p->y()));
    EXPECT_EQ(result.matte.occluders(x, y), 255);
    EXPECT_EQ(result.matte.unknown(x, y), 255);
    ++seen;
  }
  EXPECT_GT(seen, 0);
}

// The posts of rugby reach far above people.
TEST_F(Key, NothingIsSetOutsideTheRegion) {
  pitch_ = *pitch::make_pitch(pitch::Sport::kRugbyUnion, {});
  camera_ = test_camera(0.75, -0.1, 500);
  SetUp();
  const image::Matte m =
      key(scene_->frame({Disc{{240, 190}, 8}}, 7), camera_, *plate_, pitch_).matte;
  int above = 0;
  for (const auto& bar : pitch_.bars) {
    const auto top = geometry::project(camera_, bar.start.z() > bar.end.z() ? bar.start : bar.end);
    above += top && m.alpha.contains(static_cast<int>(top->x()), static_cast<int>(top->y())) &&
             top->y() < m.region.y - 1;
  }
  EXPECT_GT(above, 0);
  for (int y = 0; y < m.alpha.height(); ++y)
    for (int x = 0; x < m.alpha.width(); ++x) {
      if (m.region.contains(x, y)) continue;
      EXPECT_EQ(m.alpha(x, y) + m.unknown(x, y) + m.occluders(x, y), 0) << x << ' ' << y;
    }
}

TEST_F(Key, WithoutAPlateTurfIsKeyedByColourAndTheRestIsUnknown) {
  image::PlateSnapshot none;
  none.centre_in_world = plate_->centre_in_world;
  none.radians_per_px = plate_->radians_per_px;
  const auto result = key(scene_->frame({Disc{{240, 190}, 10}}, 8), camera_, none, pitch_);
  EXPECT_GE(result.matte.alpha(240, 190), 128);
  EXPECT_EQ(result.matte.alpha(150, 190), 0);
  EXPECT_GT(result.report.no_plate_share, 0.5);
}

TEST_F(Key, EveryImageHasTheFramesSize) {
  const auto m = matte({});
  for (const auto* image : {&m.alpha, &m.unknown, &m.occluders}) {
    EXPECT_EQ(image->width(), 480);
    EXPECT_EQ(image->height(), 270);
  }
  EXPECT_EQ(m.plate_version, plate_->version);
}

TEST_F(Key, ALostCameraKnowsNothing) {
  auto lost = camera_;
  lost.evidence = geometry::Evidence::kLost;
  const auto result = key(scene_->frame({}, 9), lost, *plate_, pitch_);
  EXPECT_EQ(result.matte.alpha.width(), 480);
  EXPECT_EQ(result.report.unknown_share, 1);
  EXPECT_EQ(result.matte.unknown(100, 100), 255);
  EXPECT_EQ(result.matte.alpha(100, 100), 0);
}

TEST_F(Key, TheSameFrameGivesTheSameMatte) {
  const std::vector<Disc> discs{{{120, 200}, 7}, {{300, 160}, 4}};
  EXPECT_EQ(matte(discs), matte(discs));
}

TEST(KeyOptions, ValidateNamesFieldValueAndBound) {
  EXPECT_TRUE(KeyOptions{}.validate());
  KeyOptions options;
  options.tallest_m = 9;
  const auto status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "tallest_m");
  EXPECT_NE(status.error().what.find('9'), std::string::npos);
}

}  // namespace
}  // namespace touchline::key
