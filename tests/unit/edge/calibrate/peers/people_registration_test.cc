// A head is found by people whom other cameras see, as surely as it says, and not by others.
#include "edge/calibrate/peers/people_registration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "edge/calibrate/fit/pose_fit.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// People as ellipses of shirt and shorts, on turf of which no line is seen.
class Scene {
 public:
  explicit Scene(std::uint32_t seed) : random_(seed), mount_(test_mount()) {
    pitch_ = *pitch::make_pitch(pitch::Sport::kSoccer, {});
    truth_ = camera_at(mount_, uniform(-20, 20), uniform(-16, -12), uniform(1800, 3200));
  }

  double uniform(double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random_);
  }
  double normal(double sd) { return std::normal_distribution<double>(0, sd)(random_); }

  // People spread over the turf in the picture, none before another.
  void people(int count) {
    for (int tries = 0; tries < 2000 && static_cast<int>(people_.size()) < count; ++tries) {
      const Eigen::Vector2d pixel(uniform(60, mount_.width - 60), uniform(180, mount_.height - 40));
      const auto at = pitch::intersect_turf(pitch_, geometry::position_in_world(truth_),
                                            geometry::ray_in_world(truth_, pixel));
      if (!at || std::abs(at->x()) > 52 || std::abs(at->y()) > 34) continue;
      bool apart = true;
      for (const Eigen::Vector2d& other : pixels_) {
        apart = apart &&
                (std::abs(other.x() - pixel.x()) > 70 || std::abs(other.y() - pixel.y()) > 190);
      }
      if (!apart) continue;
      pixels_.push_back(pixel);
      people_.push_back(at->head<2>());
    }
  }

  image::Frame picture() {
    PaintOptions options;
    options.paint = false;
    image::Frame frame = paint_pitch(pitch_, truth_, options);
    for (const Eigen::Vector2d& person : people_) {
      const Eigen::Vector3d ground = pitch_.on_turf(person);
      const double tall = 1.78 * std::exp(normal(0.05));
      const auto foot = geometry::project(truth_, ground);
      const auto head = geometry::project(truth_, ground + Eigen::Vector3d(0, 0, tall));
      fill(frame, *foot, *head);
    }
    return frame;
  }

  // What other cameras say of them: `share` of them, and some whom this camera does not show.
  std::vector<StandingPlace> places(double sd_m, double share = 1) {
    std::vector<StandingPlace> out;
    for (const Eigen::Vector2d& person : people_) {
      if (uniform(0, 1) > share) continue;
      out.push_back({person + Eigen::Vector2d(normal(sd_m), normal(sd_m)), sd_m});
    }
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d at(uniform(-52, 52), uniform(-34, 34));
      const auto pixel = geometry::project(truth_, pitch_.on_turf(at));
      if (pixel && truth_.model.sees(*pixel)) continue;
      out.push_back({at, sd_m});
    }
    return out;
  }

  const pitch::PitchModel& pitch() const { return pitch_; }
  const geometry::Mount& mount() const { return mount_; }
  const geometry::CameraEstimate& truth() const { return truth_; }

  geometry::CameraEstimate prior(double pan_sd_deg) {
    geometry::HeadPose pose = head_pose(mount_, truth_);
    pose.pan += normal(pan_sd_deg) / kDegrees;
    pose.tilt += normal(0.3 * pan_sd_deg) / kDegrees;
    pose.focal_px *= std::exp(normal(0.05));
    geometry::CameraEstimate out;
    out.model = geometry::camera_model(mount_, pose.focal_px);
    out.cam_from_world = geometry::cam_from_world(mount_, pose);
    out.covariance(0, 0) = std::pow(pan_sd_deg / kDegrees, 2);
    out.covariance(1, 1) = std::pow(0.3 * pan_sd_deg / kDegrees, 2);
    out.covariance(3, 3) = 0.05 * 0.05;
    out.evidence = geometry::Evidence::kLines;
    return out;
  }

 private:
  static void fill(image::Frame& frame, const Eigen::Vector2d& foot, const Eigen::Vector2d& head) {
    const image::ChromaShift shift = image::chroma_shift(frame.format);
    const double tall = foot.y() - head.y();
    for (int y = std::max(0, static_cast<int>(head.y()));
         y <= std::min(frame.height() - 1, static_cast<int>(foot.y())); ++y) {
      const double along = (foot.y() - y) / tall;
      const double half = tall * (along < 0.45 ? 0.09 : along < 0.85 ? 0.14 : 0.06);
      const double middle = foot.x() + along * (head.x() - foot.x());
      for (int x = std::max(0, static_cast<int>(middle - half));
           x <= std::min(frame.width() - 1, static_cast<int>(middle + half)); ++x) {
        frame.planes[0](x, y) = along < 0.45 ? 300 : 600;
        frame.planes[1](x >> shift.x, y >> shift.y) = 480;
        frame.planes[2](x >> shift.x, y >> shift.y) = 640;
      }
    }
  }

  std::mt19937 random_;
  pitch::PitchModel pitch_;
  geometry::Mount mount_;
  geometry::CameraEstimate truth_;
  std::vector<Eigen::Vector2d> people_;
  std::vector<Eigen::Vector2d> pixels_;
};

TEST(PeopleRegistration, FindsTheHeadByPeopleAndSaysHowSurely) {
  int found = 0;
  double chi2 = 0;
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    Scene scene(seed);
    scene.people(7);
    const auto result = register_people(scene.picture(), scene.pitch(), scene.mount(),
                                        scene.places(0.15, 0.85), scene.prior(3), {});
    if (result.estimate.lost()) continue;
    ++found;
    EXPECT_EQ(result.estimate.evidence, geometry::Evidence::kPeers);
    const geometry::HeadPose truth = head_pose(scene.mount(), scene.truth());
    const geometry::HeadPose pose = head_pose(scene.mount(), result.estimate);
    const Eigen::Vector3d off(pose.pan - truth.pan, pose.tilt - truth.tilt,
                              std::log(pose.focal_px / truth.focal_px));
    Eigen::Matrix3d spread;
    constexpr std::array<int, 3> kPlace{0, 1, 3};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k)
        spread(i, k) = result.estimate.covariance(kPlace[static_cast<std::size_t>(i)],
                                                  kPlace[static_cast<std::size_t>(k)]);
    chi2 += off.dot(spread.ldlt().solve(off)) / 3;
    EXPECT_LT(std::abs(off.x()) * truth.focal_px, 60) << "seed " << seed << ": a wrong camera";
    EXPECT_LT(std::abs(off.z()), 0.12) << "seed " << seed;
  }
  RecordProperty("found", found);
  RecordProperty("normalised_square", std::to_string(chi2 / found));
  EXPECT_GE(found, 30);
  // No more often wrong than it says.
  EXPECT_LT(chi2 / found, 1.5);
}

TEST(PeopleRegistration, WithoutAPriorNeverAWrongCamera) {
  int found = 0;
  for (std::uint32_t seed = 101; seed <= 130; ++seed) {
    Scene scene(seed);
    scene.people(9);
    const auto result = register_people(scene.picture(), scene.pitch(), scene.mount(),
                                        scene.places(0.1), std::nullopt, {});
    if (result.estimate.lost()) continue;
    ++found;
    EXPECT_LT(turf_rms_px(scene.pitch(), scene.truth(), result.estimate), 40) << "seed " << seed;
  }
  RecordProperty("found", found);
  EXPECT_GE(found, 15);
}

TEST(PeopleRegistration, OtherPeopleSayNothing) {
  for (std::uint32_t seed = 201; seed <= 230; ++seed) {
    Scene scene(seed), other(seed + 1000);
    scene.people(7);
    other.people(7);
    const auto result = register_people(scene.picture(), scene.pitch(), scene.mount(),
                                        other.places(0.15), scene.prior(3), {});
    EXPECT_TRUE(result.estimate.lost()) << "seed " << seed;
    EXPECT_FALSE(result.report.stopped_because.empty());
  }
}

TEST(PeopleRegistration, TooFewPeopleSayNothing) {
  Scene scene(7);
  scene.people(2);
  const image::Frame picture = scene.picture();
  EXPECT_TRUE(
      register_people(picture, scene.pitch(), scene.mount(), scene.places(0.1), scene.prior(3), {})
          .estimate.lost());
  EXPECT_TRUE(register_people(picture, scene.pitch(), scene.mount(), {}, scene.prior(3), {})
                  .estimate.lost());
}

}  // namespace
}  // namespace touchline::calibrate
