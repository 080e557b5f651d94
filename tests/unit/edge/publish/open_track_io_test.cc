// OpenTrackIO: which way its angles turn, what a lost camera's sample says, packets by hand.
#include "edge/publish/open_track_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "tests/unit/edge/publish/tracking_scene.h"

namespace touchline::publish {
namespace {

using Json = nlohmann::json;
constexpr double kDegree = std::numbers::pi / 180;

SampleContext context() {
  const codec::EncodedView view = view_at(0, 0, 0, {0, -60, 15});
  return {view.id, view.stamp, {50, 1}, false};
}

Json sample_of(const geometry::CameraEstimate& estimate, const SampleContext& about,
               const OpenTrackIoOptions& options = {}) {
  return Json::parse(open_track_io_sample(estimate, about, options));
}

// Turned about Z, X and Y in this order, right-handed, as the documentation says.
TEST(OpenTrackIo, TheSpecificationsCameraIsOurs) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> turn(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const geometry::CameraEstimate estimate =
        estimate_at(3.1 * turn(random), 1.2 * turn(random), 0.2 * turn(random),
                    {500 * turn(random), 100 * turn(random), 50 * turn(random)});
    const Json sample = sample_of(estimate, context());
    const Json& camera = sample["transforms"][0];
    const auto angle = [&](const char* name) {
      return camera["rotation"][name].get<double>() * kDegree;
    };
    const Eigen::Matrix3d stage_from_camera =
        (Eigen::AngleAxisd(angle("pan"), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(angle("tilt"), Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(angle("roll"), Eigen::Vector3d::UnitY()))
            .toRotationMatrix();
    const Eigen::Matrix3d world_from_cam =
        estimate.cam_from_world.rotation.conjugate().toRotationMatrix();
    EXPECT_LT((stage_from_camera.col(0) - world_from_cam.col(0)).norm(), 1e-9);  // right
    EXPECT_LT((stage_from_camera.col(1) - world_from_cam.col(2)).norm(), 1e-9);  // forward
    EXPECT_LT((stage_from_camera.col(2) + world_from_cam.col(1)).norm(), 1e-9);  // up
    const Eigen::Vector3d position(camera["translation"]["x"], camera["translation"]["y"],
                                   camera["translation"]["z"]);
    EXPECT_LT((position - geometry::position_in_world(estimate)).norm(), 1e-9);
  }
}

// A receiver that projects with the lens terms as told lands on our pixel.
TEST(OpenTrackIo, ItsLensProjectsWhereOursDoes) {
  const geometry::CameraEstimate estimate = estimate_at(0, 0, 0, {0, -60, 15});
  const geometry::CameraModel& model = estimate.model;
  OpenTrackIoOptions options;
  options.sensor_width_mm = 12;
  SampleContext about = context();
  about.with_static = true;
  const Json sample = sample_of(estimate, about, options);
  const Json& lens = sample["lens"];
  const double focal = lens["pinholeFocalLength"];
  const std::vector<double> l = lens["distortion"][0]["radial"];
  ASSERT_EQ(lens["distortion"][0]["model"], "Brown-Conrady U-D");
  const double width_mm = sample["static"]["camera"]["activeSensorPhysicalDimensions"]["width"];
  for (const Eigen::Vector3d& point :
       {Eigen::Vector3d(0.2, 0.1, 1), Eigen::Vector3d(-0.3, 0.15, 1)}) {
    const Eigen::Vector2d undistorted = focal * point.head<2>();
    const double r2 = undistorted.squaredNorm();
    const double grow =
        (1 + r2 * (l[0] + r2 * (l[2] + r2 * l[4]))) / (1 + r2 * (l[1] + r2 * (l[3] + r2 * l[5])));
    const Eigen::Vector2d on_sensor =
        grow * undistorted +
        Eigen::Vector2d(lens["projectionOffset"]["x"], lens["projectionOffset"]["y"]);
    const Eigen::Vector2d pixel =
        on_sensor * (model.width / width_mm) +
        Eigen::Vector2d((model.width - 1) / 2.0, (model.height - 1) / 2.0);
    EXPECT_LT((pixel - *model.project(point)).norm(), 1e-6);
  }
}

TEST(OpenTrackIo, ALostCamerasSampleHasNoPlaceAndNoLens) {
  geometry::CameraEstimate estimate = estimate_at(0, 0, 0, {0, -60, 15});
  estimate.evidence = geometry::Evidence::kLost;
  const Json sample = sample_of(estimate, context());
  EXPECT_EQ(sample["tracker"]["status"], "lost");
  EXPECT_FALSE(sample.contains("transforms"));
  EXPECT_FALSE(sample.contains("lens"));
}

TEST(OpenTrackIo, WhatIsNoNumberIsNotTold) {
  const Json sample = sample_of(estimate_at(0, std::nan(""), 0, {0, -60, 15}), context());
  EXPECT_EQ(sample["tracker"]["status"], "lost");
  EXPECT_FALSE(sample.contains("transforms"));
}

TEST(OpenTrackIo, TimeIsTheFrames) {
  const Json sample = sample_of(estimate_at(0, 0, 0, {0, -60, 15}), context());
  const Json& timing = sample["timing"];
  EXPECT_EQ(timing["mode"], "internal");
  EXPECT_EQ(timing["sampleTimestamp"]["seconds"], 1'718'806'554);
  EXPECT_EQ(timing["sampleTimestamp"]["nanoseconds"], 500'000'000);
  EXPECT_EQ(timing["sequenceNumber"], 66'000);
  EXPECT_EQ(timing["synchronization"]["source"], "ptp");
  EXPECT_EQ(timing["timecode"]["frames"], 16);
  EXPECT_EQ(timing["timecode"]["frameRate"]["num"], 50);
  SampleContext about = context();
  about.stamp.domain = base::ClockDomain::kUnknown;
  about.stamp.media_time.ns = -1;
  about.stamp.timecode.reset();
  const Json plain = sample_of(estimate_at(0, 0, 0, {0, -60, 15}), about)["timing"];
  EXPECT_EQ(plain["mode"], "external");
  EXPECT_FALSE(plain.contains("sampleTimestamp"));
  EXPECT_FALSE(plain.contains("synchronization"));
  EXPECT_FALSE(plain.contains("timecode"));
}

TEST(OpenTrackIo, FramesAndSourcesHaveIdentitiesOfTheirOwn) {
  const geometry::CameraEstimate estimate = estimate_at(0, 0, 0, {0, -60, 15});
  SampleContext about = context();
  const Json one = sample_of(estimate, about);
  EXPECT_EQ(one, sample_of(estimate, about));
  ++about.frame.sequence;
  const Json next = sample_of(estimate, about);
  EXPECT_NE(one["sampleId"], next["sampleId"]);
  EXPECT_EQ(one["sourceId"], next["sourceId"]);
  about.frame.camera.value = "m2";
  EXPECT_NE(one["sourceId"], sample_of(estimate, about)["sourceId"]);
}

// "ab" with sequence 0x0102. First sum of O T r k 0 1 1 2 0 0 0 0 80 02 'a' 'b' modulo 256:
// 4F A3 15 80 80 81 82 84 84 84 84 84 04 06 67 C9; the second sum runs over those and ends at D8.
TEST(OpenTrackIo, APacketByHand) {
  const auto packets = open_track_io_packets("ab", 0x0102, ChecksumOrder::kSecondSumFirst);
  ASSERT_EQ(packets.size(), 1u);
  EXPECT_THAT(packets[0], testing::ElementsAre('O', 'T', 'r', 'k', 0, 1, 1, 2, 0, 0, 0, 0, 0x80, 2,
                                               0xD8, 0xC9, 'a', 'b'));
  const auto swapped = open_track_io_packets("ab", 0x0102, ChecksumOrder::kFirstSumFirst);
  EXPECT_EQ(swapped[0][14], 0xC9);
  EXPECT_EQ(swapped[0][15], 0xD8);
}

TEST(OpenTrackIo, ALongSampleIsCutAndWhole) {
  const std::string sample(2500, 'x');
  const auto packets = open_track_io_packets(sample, 7, ChecksumOrder::kSecondSumFirst, 1000);
  ASSERT_EQ(packets.size(), 3u);
  EXPECT_EQ(packets[0].size(), 1016u);
  EXPECT_EQ(packets[2].size(), 516u);
  EXPECT_EQ(packets[0][12] & 0x80, 0);
  EXPECT_EQ(packets[2][12] & 0x80, 0x80);
  EXPECT_EQ((packets[2][10] << 8) | packets[2][11], 2000);
}

}  // namespace
}  // namespace touchline::publish
