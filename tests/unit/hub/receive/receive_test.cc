// What a unit published comes back as it was; what no unit would send is refused and never trips
// the hub.
#include "hub/receive/receive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "edge/publish/publish.h"

namespace touchline::receive {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

codec::EncodedView random_view(std::mt19937& random) {
  std::uniform_real_distribution<double> real(-1, 1);
  const auto below = [&](std::uint64_t bound) { return random() % bound; };
  codec::EncodedView view;
  view.id = {{"m1"}, static_cast<std::uint32_t>(below(9)), below(100'000)};
  view.stamp.media_time.ns = static_cast<std::int64_t>(below(1u << 30)) * 1000;
  view.stamp.domain = static_cast<base::ClockDomain>(below(5));
  view.stamp.uncertainty_ns = static_cast<std::int64_t>(below(1000));
  if (below(2) == 0) {
    view.stamp.timecode =
        base::Timecode{static_cast<int>(below(24)), static_cast<int>(below(60)),
                       static_cast<int>(below(60)), static_cast<int>(below(50)), below(2) == 0};
  }
  geometry::CameraEstimate& estimate = view.estimate;
  estimate.model = {1920, 1080, 3000 + 100 * real(random), 3000,
                    960,  540,  0.1 * real(random),        0.01 * real(random)};
  estimate.cam_from_world.rotation =
      Eigen::Quaterniond(real(random), real(random), real(random), real(random)).normalized();
  estimate.cam_from_world.translation = {50 * real(random), 50 * real(random), 50 * real(random)};
  Eigen::Matrix<double, 9, 9> root;
  for (int i = 0; i < 81; ++i) root(i / 9, i % 9) = 0.01 * real(random);
  estimate.covariance = root * root.transpose();
  estimate.covariance =
      (0.5 * (estimate.covariance + estimate.covariance.transpose().eval())).eval();
  estimate.evidence = static_cast<geometry::Evidence>(1 + below(4));
  estimate.rms_px = std::abs(real(random));
  for (const codec::PartKind kind :
       {codec::PartKind::kMatte, codec::PartKind::kPartial, codec::PartKind::kTiles}) {
    if (below(3) > 0) {
      view.parts.push_back(
          {kind, static_cast<std::uint16_t>(below(4)), std::vector<std::uint8_t>(below(500), 7)});
    }
  }
  return view;
}

TEST(Receive, WhatWasPublishedComesBack) {
  std::mt19937 random(5);
  for (int i = 0; i < 300; ++i) {
    const codec::EncodedView view = random_view(random);
    const auto back = to_view(publish::to_message(view));
    ASSERT_TRUE(back) << base::to_string(back.error());
    EXPECT_EQ(back->id, view.id);
    EXPECT_EQ(back->stamp, view.stamp);
    EXPECT_EQ(back->estimate.model, view.estimate.model);
    EXPECT_TRUE(back->estimate.cam_from_world.rotation.coeffs().isApprox(
        view.estimate.cam_from_world.rotation.coeffs(), 1e-15));
    EXPECT_EQ(back->estimate.cam_from_world.translation, view.estimate.cam_from_world.translation);
    EXPECT_EQ(back->estimate.covariance, view.estimate.covariance);
    EXPECT_EQ(back->estimate.evidence, view.estimate.evidence);
    EXPECT_EQ(back->estimate.rms_px, view.estimate.rms_px);
    EXPECT_EQ(back->parts, view.parts);
  }
}

TEST(Receive, APlateTileComesBack) {
  codec::EncodedPlateTile tile;
  tile.camera = {"m1"};
  tile.epoch = 2;
  tile.plate_version = 3;
  tile.key = {-4, 17};
  tile.radians_per_px = 3e-4;
  tile.centre_in_world = {1, -60, 12};
  tile.format_version = 1;
  tile.bytes = {9, 8, 7};
  const auto back = to_plate_tile(publish::to_message(tile, 2));
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, tile);
}

TEST(Receive, AStatusComesBackWithoutControlCharacters) {
  publish::UnitStatus status;
  status.camera = {"m1"};
  status.epoch = 2;
  status.state = publish::UnitState::kRunning;
  status.stages = {{"key", 50, 7.5}};
  status.drops = {{"late", 3}};
  status.frames_read = 10;
  status.frames_sent = 9;
  status.calibration = geometry::Evidence::kLines;
  status.text = "all\nwell\x1b[2J";
  const auto back = to_status(publish::to_message(status));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->state, UnitState::kRunning);
  EXPECT_EQ(back->stages.at(0).stage, "key");
  EXPECT_EQ(back->drops.at("late"), 3u);
  EXPECT_EQ(back->frames_sent, 9u);
  EXPECT_EQ(back->calibration, geometry::Evidence::kLines);
  EXPECT_EQ(back->text, "all well [2J");
}

wire::FrameMessage good_frame() {
  std::mt19937 random(8);
  codec::EncodedView view = random_view(random);
  view.parts = {{codec::PartKind::kMatte, 1, {1, 2, 3}}};
  return publish::to_message(view);
}

TEST(Receive, EachHostileFieldIsNamed) {
  struct Case {
    std::string name;
    std::function<void(wire::FrameMessage&)> spoil;
    std::string says;
  };
  const std::vector<Case> cases = {
      {"camera", [](auto& m) { m.camera = "../m1"; }, "id"},
      {"no camera", [](auto& m) { m.camera.clear(); }, "id"},
      {"time", [](auto& m) { m.stamp.media_time_ns = std::numeric_limits<std::int64_t>::min(); },
       "media time"},
      {"uncertainty", [](auto& m) { m.stamp.uncertainty_ns = -1; }, "uncertainty"},
      {"domain", [](auto& m) { m.stamp.domain = 200; }, "clock domain"},
      {"timecode",
       [](auto& m) {
         m.stamp.has_timecode = true;
         m.stamp.hours = 24;
       },
       "hours"},
      {"width", [](auto& m) { m.estimate.model[0] = 1e9; }, "width"},
      {"half a pixel", [](auto& m) { m.estimate.model[1] = 10.5; }, "height"},
      {"no width", [](auto& m) { m.estimate.model[0] = kNan; }, "width"},
      {"focal", [](auto& m) { m.estimate.model[2] = 0; }, "fx"},
      {"focal infinite", [](auto& m) { m.estimate.model[3] = kInfinity; }, "fy"},
      {"principal point", [](auto& m) { m.estimate.model[4] = kNan; }, "cx"},
      {"distortion", [](auto& m) { m.estimate.model[6] = -kInfinity; }, "k1"},
      {"quaternion", [](auto& m) { m.estimate.pose = {0, 0, 0, 0, 0, 0, 0}; }, "quaternion"},
      {"quaternion nan", [](auto& m) { m.estimate.pose[1] = kNan; }, "quaternion"},
      {"far away", [](auto& m) { m.estimate.pose[4] = 1e30; }, "distance"},
      {"position nan", [](auto& m) { m.estimate.pose[6] = kNan; }, "quaternion"},
      {"variance", [](auto& m) { m.estimate.covariance[0] = -1; }, "variance"},
      {"covariance nan", [](auto& m) { m.estimate.covariance[1] = kNan; }, "covariance"},
      {"not symmetric", [](auto& m) { m.estimate.covariance[10 * 2 + 1] += 1; }, "covariance"},
      {"evidence", [](auto& m) { m.estimate.evidence = 77; }, "evidence"},
      {"rms", [](auto& m) { m.estimate.rms_px = kNan; }, "rms_px"},
      {"part kind", [](auto& m) { m.parts[0].kind = 99; }, "kind 99"},
      {"plate as a part", [](auto& m) { m.parts[0].kind = 4; }, "kind 4"},
      {"part twice", [](auto& m) { m.parts.push_back(m.parts[0]); }, "twice"},
      {"many parts", [](auto& m) { m.parts.resize(100); }, "parts"},
      {"large part", [](auto& m) { m.parts[0].bytes.resize((16u << 20) + 1); }, "size"},
  };
  ASSERT_TRUE(to_view(good_frame()));
  for (const Case& each : cases) {
    wire::FrameMessage message = good_frame();
    each.spoil(message);
    const auto result = to_view(message);
    ASSERT_FALSE(result) << each.name;
    EXPECT_NE(result.error().what.find(each.says), std::string::npos)
        << each.name << ": " << result.error().what;
  }
}

TEST(Receive, ALostEstimateNeedsNoPose) {
  wire::FrameMessage message = good_frame();
  message.estimate.evidence = 0;
  for (std::size_t i = 2; i < 8; ++i) message.estimate.model[i] = kNan;
  message.estimate.pose.fill(kNan);
  message.estimate.covariance.fill(kInfinity);
  message.estimate.rms_px = kNan;
  const auto view = to_view(message);
  ASSERT_TRUE(view) << base::to_string(view.error());
  EXPECT_TRUE(view->estimate.lost());
  EXPECT_EQ(view->estimate.model.width, 1920);
  EXPECT_TRUE(view->estimate.cam_from_world.translation.allFinite());
  EXPECT_TRUE(view->estimate.covariance.allFinite());
  EXPECT_EQ(view->estimate.rms_px, 0);
}

// Whatever numbers come, what is accepted is sound.
TEST(Receive, RandomBitsNeverGiveAnUnsoundView) {
  std::mt19937 random(13);
  int accepted = 0;
  for (int run = 0; run < 5000; ++run) {
    wire::FrameMessage message = good_frame();
    auto* bytes = reinterpret_cast<unsigned char*>(&message.estimate);
    for (int k = 0; k < 3; ++k) {
      bytes[random() % sizeof(message.estimate)] = static_cast<unsigned char>(random());
    }
    const auto view = to_view(message);
    if (!view) continue;
    ++accepted;
    const geometry::CameraEstimate& estimate = view->estimate;
    EXPECT_NEAR(estimate.cam_from_world.rotation.norm(), 1, 1e-12);
    EXPECT_TRUE(estimate.cam_from_world.translation.allFinite());
    EXPECT_TRUE(estimate.covariance.allFinite());
    EXPECT_GE(estimate.covariance.diagonal().minCoeff(), 0);
    EXPECT_GT(estimate.model.width, 0);
    EXPECT_TRUE(std::isfinite(estimate.rms_px));
    EXPECT_TRUE(estimate.lost() || estimate.model.fx >= 1);
  }
  EXPECT_GT(accepted, 0);
}

TEST(Receive, HostilePlateTilesAreRefused) {
  wire::PlateMessage good;
  good.camera = "m1";
  good.radians_per_px = 3e-4;
  ASSERT_TRUE(to_plate_tile(good));
  const std::vector<std::function<void(wire::PlateMessage&)>> spoilers = {
      [](auto& m) { m.camera = "a/b"; },
      [](auto& m) { m.column = std::numeric_limits<std::int32_t>::min(); },
      [](auto& m) { m.row = std::numeric_limits<std::int32_t>::max(); },
      [](auto& m) { m.radians_per_px = 0; },
      [](auto& m) { m.radians_per_px = kNan; },
      [](auto& m) { m.centre_in_world[1] = kInfinity; },
      [](auto& m) { m.bytes.resize((4u << 20) + 1); },
  };
  for (const auto& spoil : spoilers) {
    wire::PlateMessage message = good;
    spoil(message);
    EXPECT_FALSE(to_plate_tile(message));
  }
}

TEST(Receive, HostileStatusesAreRefused) {
  wire::StatusMessage good;
  good.camera = "m1";
  ASSERT_TRUE(to_status(good));
  const std::vector<std::function<void(wire::StatusMessage&)>> spoilers = {
      [](auto& m) { m.camera = ""; },
      [](auto& m) { m.state = static_cast<wire::UnitState>(9); },
      [](auto& m) { m.calibration = "excellent"; },
      [](auto& m) {
        m.stages = {{"key", kNan, 1}};
      },
      [](auto& m) {
        m.stages = {{"key", 1, -1}};
      },
      [](auto& m) { m.stages.resize(1000); },
      [](auto& m) { m.text.resize(100'000); },
  };
  for (const auto& spoil : spoilers) {
    wire::StatusMessage message = good;
    spoil(message);
    EXPECT_FALSE(to_status(message));
  }
}

}  // namespace
}  // namespace touchline::receive
