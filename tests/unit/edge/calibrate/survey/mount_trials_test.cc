#include "tests/unit/edge/calibrate/survey/mount_trials.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>

namespace touchline::calibrate {
namespace {

// TOUCHLINE_MOUNT_TRIALS asks for more cameras of each kind; seeds go on from 1.
int trials(int usual) {
  const char* const asked = std::getenv("TOUCHLINE_MOUNT_TRIALS");
  return asked != nullptr ? std::max(1, std::atoi(asked)) : usual;
}

// Sums of squared errors over their covariance, a degree of freedom.
struct Honesty {
  int solved = 0;
  double position = 0;  // of the surveyed mount
  double frame = 0;     // pan, tilt and focal length of a frame on it
  double between = 0;   // the same between two pictures from one pose
};

double normalised(const Eigen::Vector3d& off, const Eigen::Matrix3d& covariance) {
  return off.dot(covariance.ldlt().solve(off)) / 3;
}

void try_mounts(const MountTrialKind& kind, int count, Honesty& out) {
  for (int i = 0; i < count; ++i) {
    const auto trial = try_mount(kind, static_cast<std::uint32_t>(i + 1));
    if (!trial) continue;
    ++out.solved;
    out.position += normalised(trial->position_off, trial->position_covariance);
    out.frame += normalised(trial->frame_off, trial->frame_covariance);
    out.between += normalised(trial->between_off, trial->between_covariance);
  }
}

// Ends of the middle 90 % of chi-square with `count` degrees of freedom, over them (Wilson and
// Hilferty 1931).
double band_end(int count, double sigmas) {
  const double v = 2.0 / (9.0 * count);
  return std::pow(1 - v + sigmas * std::sqrt(v), 3);
}

void expect_honest(bool fixed, int count) {
  Honesty honesty;
  for (const pitch::Sport sport : {pitch::Sport::kSoccer, pitch::Sport::kRugbyUnion})
    try_mounts({sport, fixed, false}, count, honesty);
  ASSERT_GE(honesty.solved, count);
  const double low = band_end(3 * honesty.solved, -1.6449);
  const double high = band_end(3 * honesty.solved, 1.6449);
  const double position = honesty.position / honesty.solved;
  const double frame = honesty.frame / honesty.solved;
  const double between = honesty.between / honesty.solved;
  std::cout << fmt::format(
      "{} solved: position {:.2f}, frame {:.2f}, between frames {:.2f}; band {:.2f} .. {:.2f}\n",
      honesty.solved, position, frame, between, low, high);
  EXPECT_GT(position, low);
  EXPECT_LT(position, high);
  EXPECT_GT(frame, low);
  EXPECT_LT(frame, high);
  EXPECT_LT(between, high);  // what frames share does not move them
}

TEST(MountTrials, HeadsErrAsTheirCovariancesSay) { expect_honest(false, trials(10)); }

TEST(MountTrials, FixedCamerasErrAsTheirCovariancesSay) { expect_honest(true, trials(40)); }

}  // namespace
}  // namespace touchline::calibrate
