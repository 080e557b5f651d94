// A head that turns from lines to bare turf and back: followed by the turf's own pattern meanwhile.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "edge/calibrate/calibrator.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr int kTurning = 20;  // frames from the lines to bare turf, and back
constexpr int kStaying = 10;  // frames there

struct Outcome {
  int by_lines_before = 0;
  int by_texture = 0;
  int by_lines_after = 0;
  int lost = 0;
  double worst_px = 0;          // of the frames by texture
  double normalised = 0;        // mean square of pan's and tilt's error over their covariance
  double least_growth = 1e300;  // of the pan's deviation in pixels over that of the first frame
};

geometry::CameraEstimate truth_at(const geometry::Mount& mount, int k) {
  const double there = std::min({1.0, static_cast<double>(k) / kTurning,
                                 static_cast<double>(2 * kTurning + kStaying - k) / kTurning});
  const double eased = there * there * (3 - 2 * there);
  const double swing = 0.1 * std::sin(0.25 * k);
  return camera_at(mount, 22.6 - 7.8 * eased + swing, -13.2 - 0.4 * eased,
                   2800 * std::exp(0.8 * eased));
}

Outcome follow(double pupil_m, int frames) {
  const pitch::PitchModel pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.3, {}});
  geometry::Mount mount = test_mount();
  mount.pupil_offset_m = pupil_m;
  Calibrator calibrator(pitch, mount, {});
  Outcome out;
  double first_sd = 0;
  int count = 0;
  for (int k = 0; k < frames; ++k) {
    const geometry::CameraEstimate truth = truth_at(mount, k);
    if (k == 0) calibrator.start_from(truth);
    image::Frame frame = paint_pitch(pitch, truth, {4, 6, true, static_cast<std::uint32_t>(k), 60});
    frame.stamp.media_time.ns = k * 40'000'000LL;
    const geometry::CameraEstimate found = calibrator.process(frame).estimate;
    const double sd = std::sqrt(found.covariance(0, 0)) * found.model.fx;
    if (k == 0) first_sd = sd;
    if (found.lost()) {
      ++out.lost;
    } else if (found.evidence == geometry::Evidence::kLines) {
      ++(k < kTurning + kStaying / 2 ? out.by_lines_before : out.by_lines_after);
    } else {
      ++out.by_texture;
      out.worst_px = std::max(out.worst_px, turf_rms_px(pitch, truth, found));
      out.least_growth = std::min(out.least_growth, sd / first_sd);
      const Eigen::Vector3d off = geometry::pan_tilt_roll(found.cam_from_world.rotation) -
                                  geometry::pan_tilt_roll(truth.cam_from_world.rotation);
      const Eigen::Matrix2d spread = found.covariance.topLeftCorner<2, 2>();
      out.normalised += off.head<2>().dot(spread.ldlt().solve(off.head<2>())) / 2;
      ++count;
    }
  }
  out.normalised /= std::max(1, count);
  return out;
}

TEST(WithoutLines, AHeadIsFollowedOverBareTurfAndSaysSo) {
  const Outcome out = follow(0, 2 * kTurning + kStaying + 1);
  EXPECT_EQ(out.lost, 0);
  EXPECT_GE(out.by_lines_before, 2);
  EXPECT_GE(out.by_texture, kStaying);
  EXPECT_GE(out.by_lines_after, 2);
  EXPECT_LT(out.worst_px, 1.5);  // 3 at 1080 lines
  EXPECT_GT(out.least_growth, 1);
  EXPECT_LT(out.normalised, 3);
}

// Near turf shows that the lens does not turn about its entrance pupil.
TEST(WithoutLines, AnEntrancePupilAheadOfTheAxesIsReckonedWith) {
  const Outcome out = follow(0.3, kTurning + kStaying);
  EXPECT_EQ(out.lost, 0);
  EXPECT_GE(out.by_texture, kStaying);
  EXPECT_LT(out.worst_px, 1.5);
}

}  // namespace
}  // namespace touchline::calibrate
