#include "edge/calibrate/fit/pose_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "edge/calibrate/fit/pose_model_internal.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

pitch::PitchModel soccer() {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.3, {}});
}

// Windows as a perfect measurement of `truth` from `predicted` would fill them, with noise; a share
// of them holds a wrong candidate as well, or instead.
std::vector<LinePoint> ideal_points(const pitch::PitchModel& pitch,
                                    const geometry::CameraEstimate& truth,
                                    const geometry::CameraEstimate& predicted, double sigma_px,
                                    double clutter, std::mt19937& random) {
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<LinePoint> points;
  for (const pitch::Marking& m : pitch.markings) {
    if (m.shape == pitch::MarkingShape::kSpot) continue;
    for (double s = 0.25; s < m.length(); s += 0.5) {
      LinePoint window;
      window.marking = m.id;
      window.point_in_world = pitch.on_turf(m.at(s));
      const auto pixel = geometry::project(predicted, window.point_in_world);
      const auto ahead = geometry::project(predicted, pitch.on_turf(m.at(s) + 0.01 * m.tangent(s)));
      if (!pixel || !ahead || !predicted.model.sees(*pixel)) continue;
      const Eigen::Vector2d along = (*ahead - *pixel).normalized();
      window.predicted = *pixel;
      window.normal = {along.y(), -along.x()};
      window.length_px = 8;
      // The true line near the window: the nearest of its points across the normal.
      double offset = 1e9, slip = 1e9;
      for (double t = std::max(0.0, s - 3); t <= std::min(m.length(), s + 3); t += 0.01) {
        const auto q = geometry::project(truth, pitch.on_turf(m.at(t)));
        if (!q) continue;
        const Eigen::Vector2d d = *q - *pixel;
        if (std::abs(d.dot(along)) < slip) {
          slip = std::abs(d.dot(along));
          offset = d.dot(window.normal);
        }
      }
      if (slip > 0.5) continue;
      window.state = WindowState::kFound;
      const bool spoilt = std::abs(unit(random)) < clutter;
      const double value = spoilt ? 12 * unit(random) : offset + sigma_px * gauss(random);
      window.candidates[0] = {value, 400, 0.95, std::max(0.1, sigma_px)};
      window.count = 1;
      if (std::abs(unit(random)) < clutter) {
        window.candidates[1] = {12 * unit(random), 300, 0.9, std::max(0.1, sigma_px)};
        window.count = 2;
      }
      points.push_back(window);
    }
  }
  return points;
}

TEST(PoseModel, DerivativesAreThoseOfTheProjection) {
  geometry::Mount mount = test_mount();
  mount.pupil_offset_m = 0.2;
  PoseVector pose;
  pose << 0.3, -0.2, 0.01, std::log(1500.0), 0.01, -0.02, 0.3, -0.2, 0.1;
  const PoseModel model(mount, pose);
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(20, 0, 0), {30, 25, -0.2}, {15, -10, 1}}) {
    const auto image = model.project(point);
    ASSERT_TRUE(image.has_value());
    for (int i = 0; i < 9; ++i) {
      const double h = 1e-6;
      PoseVector up = pose, down = pose;
      up(i) += h;
      down(i) -= h;
      const Eigen::Vector2d numeric = (PoseModel(mount, up).project(point)->pixel -
                                       PoseModel(mount, down).project(point)->pixel) /
                                      (2 * h);
      EXPECT_LT((numeric - image->by_pose.col(i)).norm(), 1e-3 * (1 + numeric.norm())) << i;
    }
  }
}

TEST(PoseModel, DerivativesByTheMountAreThoseOfTheProjection) {
  geometry::Mount mount = test_mount();
  mount.pupil_offset_m = 0.2;
  mount.pupil_by_log_focal_m = -0.05;
  mount.lens = {{1500, 0.01, -0.02}};
  PoseVector pose = PoseVector::Zero();
  pose.head<4>() << 0.3, -0.2, 0.01, std::log(1500.0);
  const double s = (960.0 * 960.0 + 540.0 * 540.0) / 4 / (1500.0 * 1500.0);
  const Eigen::Matrix3d by_size = Eigen::Vector3d(0.5, -0.3, -0.8).asDiagonal();
  const auto pixel = [&](const Eigen::Vector3d& point, int index, double change) {
    geometry::Mount moved = mount;
    Eigen::Vector3d at = point;
    const std::array<double*, 9> field{&moved.position_in_world.x(),
                                       &moved.position_in_world.y(),
                                       &moved.position_in_world.z(),
                                       &moved.level_x,
                                       &moved.level_y,
                                       &moved.cx,
                                       &moved.cy,
                                       &moved.pupil_offset_m,
                                       &moved.pupil_by_log_focal_m};
    if (index < 9) *field[static_cast<std::size_t>(index)] += change;
    if (index >= 9 && index < 12) at += by_size.col(index - 9) * change;
    if (index == 12) moved.lens[0].k1 += change / s;
    if (index == 13) moved.lens[0].k2 += change / (s * s);
    return PoseModel(moved, pose).project(at)->pixel;
  };
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(20, 0, 0), {30, 25, -0.2}, {15, -10, 1}}) {
    const auto analytic = PoseModel(mount, pose).by_mount(point, by_size);
    ASSERT_TRUE(analytic.has_value());
    for (int i = 0; i < kMountErrors; ++i) {
      const double h = 1e-6;
      const Eigen::Vector2d numeric = (pixel(point, i, h) - pixel(point, i, -h)) / (2 * h);
      EXPECT_LT((numeric - analytic->col(i)).norm(), 1e-3 * (1 + numeric.norm())) << i;
    }
  }
}

TEST(PoseModel, AgreesWithTheMount) {
  geometry::Mount mount = test_mount();
  mount.pupil_offset_m = 0.15;
  PoseVector pose = PoseVector::Zero();
  pose.head<4>() << 0.3, -0.2, 0.01, std::log(1500.0);
  const PoseModel model(mount, pose);
  const geometry::Rigid3 expected = geometry::cam_from_world(mount, {0.3, -0.2, 0.01, 1500});
  EXPECT_LT(
      (model.cam_from_world() * Eigen::Vector3d(3, 4, 5) - expected * Eigen::Vector3d(3, 4, 5))
          .norm(),
      1e-9);
  const auto pixel = model.camera_model().project(expected * Eigen::Vector3d(20, 0, 0));
  ASSERT_TRUE(pixel.has_value());
  EXPECT_LT((model.project({20, 0, 0})->pixel - *pixel).norm(), 1e-9);
}

TEST(PoseFit, HeadPoseInvertsTheMount) {
  const geometry::Mount mount = test_mount();
  const geometry::HeadPose pose = head_pose(mount, camera_at(mount, 21, -11, 1700));
  EXPECT_NEAR(pose.pan, 21 * kRadians, 1e-12);
  EXPECT_NEAR(pose.tilt, -11 * kRadians, 1e-12);
  EXPECT_NEAR(pose.roll, 0, 1e-12);
  EXPECT_DOUBLE_EQ(pose.focal_px, 1700);
}

TEST(PoseFit, FindsThePoseThatMadeThePoints) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 12; ++i) {
    const geometry::CameraEstimate truth =
        camera_at(mount, 35 * unit(random), -14 + 2 * unit(random), 1100 + 400 * unit(random));
    const geometry::HeadPose pose = head_pose(mount, truth);
    const geometry::CameraEstimate prior = camera_at(
        mount, pose.pan / kRadians + 0.15 * unit(random), pose.tilt / kRadians + 0.1 * unit(random),
        pose.focal_px * (1 + 0.01 * unit(random)));
    // Once far, once from there: profiles are measured again at the first answer.
    const auto far = ideal_points(pitch, truth, prior, 0, 0, random);
    const PoseFit first = fit_pose(far, mount, prior, prior, {});
    const geometry::CameraEstimate start = first.result.estimate;
    const auto near = ideal_points(pitch, truth, start, 0, 0, random);
    const PoseFit fit = fit_pose(near, mount, prior, start, {});
    ASSERT_FALSE(fit.result.estimate.lost());
    EXPECT_LT(turf_rms_px(pitch, truth, fit.result.estimate), 0.02);
    EXPECT_GT(fit.confirmation.share(), 0.99);
  }
}

TEST(PoseFit, WrongCandidatesDoNotMoveIt) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  std::mt19937 random(6);
  for (const double pan : {-20.0, 0.0, 25.0}) {
    const geometry::CameraEstimate truth = camera_at(mount, pan, -13, 1200);
    const geometry::CameraEstimate prior = camera_at(mount, pan + 0.2, -13.1, 1210);
    const auto points = ideal_points(pitch, truth, prior, 0.1, 0.5, random);
    const PoseFit fit = fit_pose(points, mount, prior, prior, {});
    ASSERT_FALSE(fit.result.estimate.lost());
    EXPECT_LT(turf_rms_px(pitch, truth, fit.result.estimate), 0.35);
  }
}

TEST(PoseFit, ErrorsAreAsLargeAsTheCovarianceSays) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 12, -13, 1200);
  std::mt19937 random(8);
  PoseFitOptions options;
  options.point_correlation = 1;  // these points err independently
  double sum = 0;
  const int trials = 60;
  for (int i = 0; i < trials; ++i) {
    const auto points = ideal_points(pitch, truth, truth, 0.3, 0, random);
    const PoseFit fit = fit_pose(points, mount, truth, truth, options);
    const geometry::HeadPose a = head_pose(mount, truth);
    const geometry::HeadPose b = head_pose(mount, fit.result.estimate);
    const Eigen::Vector4d off(b.pan - a.pan, b.tilt - a.tilt, b.roll - a.roll,
                              std::log(b.focal_px / a.focal_px));
    const Eigen::Matrix4d spread = fit.result.estimate.covariance.topLeftCorner<4, 4>();
    sum += off.dot(spread.ldlt().solve(off));
  }
  // Four degrees of freedom, of which the prior holds roll: between half and twice 3.
  EXPECT_GT(sum / trials, 1.5);
  EXPECT_LT(sum / trials, 6.0);
}

// Cameras whose mount is not what the survey says: the survey errs as it says, and so must frames.
TEST(PoseFit, TheMountsErrorsAreInTheCovariance) {
  const pitch::PitchModel pitch = soccer();
  geometry::Mount mount = test_mount();
  mount.lens = {{1200, -0.03, 0.02}};
  Eigen::VectorXd sd(geometry::Mount::kShared + 2);
  sd << 0.03, 0.04, 0.02, 4e-4, 3e-4, 1.5, 2.0, 0.02, 0.01, 0, 0, 0, 2e-4, 1e-4;
  mount.covariance = sd.cwiseAbs2().asDiagonal();
  std::mt19937 random(12);
  std::normal_distribution<double> gauss;
  PoseFitOptions options;
  options.point_correlation = 1;
  double sum = 0;
  double alone = 0;
  const int trials = 40;
  for (int i = 0; i < trials; ++i) {
    geometry::Mount real = mount;
    for (int k = 0; k < 3; ++k) real.position_in_world(k) += sd(k) * gauss(random);
    real.level_x += sd(3) * gauss(random);
    real.level_y += sd(4) * gauss(random);
    real.cx += sd(5) * gauss(random);
    real.cy += sd(6) * gauss(random);
    real.pupil_offset_m += sd(7) * gauss(random);
    real.pupil_by_log_focal_m += sd(8) * gauss(random);
    const double s = (960.0 * 960.0 + 540.0 * 540.0) / 4 / (1200.0 * 1200.0);
    real.lens[0].k1 += sd(12) * gauss(random) / s;
    real.lens[0].k2 += sd(13) * gauss(random) / (s * s);
    const geometry::CameraEstimate truth = camera_at(real, 12 - i, -13, 1200);
    const geometry::CameraEstimate start = camera_at(mount, 12 - i, -13, 1200);
    geometry::CameraEstimate near = start;
    for (int look = 0; look < 2; ++look)
      near = fit_pose(ideal_points(pitch, truth, near, 0.1, 0, random), mount, start, near, options)
                 .result.estimate;
    const PoseFit fit =
        fit_pose(ideal_points(pitch, truth, near, 0.1, 0, random), mount, start, near, options);
    const geometry::CameraEstimate& found = fit.result.estimate;
    const Eigen::Vector3d turned = geometry::pan_tilt_roll(found.cam_from_world.rotation) -
                                   geometry::pan_tilt_roll(truth.cam_from_world.rotation);
    Eigen::Matrix<double, 6, 1> off;
    off << turned.x(), turned.y(), std::log(found.model.fx / truth.model.fx),
        geometry::position_in_world(found) - geometry::position_in_world(truth);
    const std::array<int, 6> rows{0, 1, 3, 6, 7, 8};
    Eigen::Matrix<double, 6, 6> spread;
    for (std::size_t r = 0; r < 6; ++r)
      for (std::size_t c = 0; c < 6; ++c)
        spread(static_cast<int>(r), static_cast<int>(c)) = found.covariance(rows[r], rows[c]);
    sum += off.dot(spread.ldlt().solve(off)) / 6;
    alone += turned.y() * turned.y() / fit.frame_covariance(1, 1);
  }
  // The 90 % band of chi-square with 240 degrees of freedom, over them, is 0.85 to 1.15.
  EXPECT_GT(sum / trials, 0.85);
  EXPECT_LT(sum / trials, 1.15);
  EXPECT_GT(alone / trials, 20);  // a frame's own noise is not the half of it
}

TEST(PoseFit, FindsPositionAndLensWhereAsked) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  geometry::Mount wrong = mount;
  wrong.position_in_world += Eigen::Vector3d(0.3, -0.2, 0.15);
  for (geometry::LensKnot& knot : wrong.lens) knot.k1 += 0.02;
  const geometry::CameraEstimate truth = camera_at(mount, 18, -14, 1000);
  geometry::CameraEstimate prior = camera_at(wrong, 18, -14, 1000);
  std::mt19937 random(9);
  PoseFitOptions held;
  const double before = turf_rms_px(
      pitch, truth,
      fit_pose(ideal_points(pitch, truth, prior, 0, 0, random), wrong, prior, prior, held)
          .result.estimate);
  PoseFitOptions free = held;
  free.position_sd_m = 2;
  free.lens_sd = 0.02;
  geometry::CameraEstimate start = prior;
  for (int i = 0; i < 3; ++i)
    start = fit_pose(ideal_points(pitch, truth, start, 0, 0, random), wrong, prior, start, free)
                .result.estimate;
  EXPECT_LT(turf_rms_px(pitch, truth, start), 0.1);
  EXPECT_LT(turf_rms_px(pitch, truth, start), before / 4);
  EXPECT_LT((geometry::position_in_world(start) - mount.position_in_world).norm(), 0.2);
}

TEST(PoseFit, OneLineLeavesDirectionsToThePriorAndSaysSo) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 0, -14, 3000);
  std::mt19937 random(10);
  std::vector<LinePoint> halfway;
  const auto points = ideal_points(pitch, truth, truth, 0.1, 0, random);
  const PoseFit whole = fit_pose(points, mount, truth, truth, {});
  for (const LinePoint& point : points)
    if (point.marking == pitch::MarkingId::kHalfwayLine) halfway.push_back(point);
  ASSERT_GT(halfway.size(), 10U);
  const PoseFit fit = fit_pose(halfway, mount, truth, truth, {});
  EXPECT_GT(fit.lines_sd_tilt, 0.1 * kRadians);
  EXPECT_GT(fit.lines_sd_tilt, 20 * std::sqrt(whole.result.estimate.covariance(1, 1)));
  EXPECT_EQ(fit.markings, 1);
}

TEST(PoseFit, NothingMeasuredIsLost) {
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate prior = camera_at(mount, 0, -14, 1500);
  EXPECT_TRUE(fit_pose({}, mount, prior, prior, {}).result.estimate.lost());
}

TEST(PoseFit, IsDeterministic) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const geometry::CameraEstimate truth = camera_at(mount, 12, -13, 1200);
  std::mt19937 random(11);
  const auto points =
      ideal_points(pitch, truth, camera_at(mount, 12.2, -13, 1200), 0.2, 0.3, random);
  const auto a = fit_pose(points, mount, truth, truth, {}).result.estimate;
  const auto b = fit_pose(points, mount, truth, truth, {}).result.estimate;
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.cam_from_world.rotation.coeffs(), b.cam_from_world.rotation.coeffs());
}

TEST(PoseFitOptions, NamesTheFieldThatIsWrong) {
  PoseFitOptions options;
  EXPECT_TRUE(options.validate().has_value());
  options.cauchy_px = 0;
  ASSERT_FALSE(options.validate().has_value());
  EXPECT_NE(options.validate().error().where.find("cauchy_px"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
