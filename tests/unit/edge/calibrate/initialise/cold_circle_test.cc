#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "edge/calibrate/initialise/cold_circle_internal.h"
#include "edge/calibrate/initialise/cold_start.h"
#include "shared/geometry/camera_estimate.h"
#include "tests/unit/edge/calibrate/drawn_pitch.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

// A level camera without a lens that looks at the middle of the pitch.
geometry::CameraEstimate camera(double pan_deg, double tilt_deg, double focal_px) {
  geometry::Mount mount;
  mount.position_in_world = {-3, -70, 16};
  mount.width = 1920;
  mount.height = 1080;
  mount.cx = 959.5;
  mount.cy = 539.5;
  return camera_at(mount, pan_deg, tilt_deg, focal_px);
}

Eigen::Vector2d seen(const geometry::CameraEstimate& estimate, double x, double y) {
  return *geometry::project(estimate, {x, y, 0}) - Eigen::Vector2d(959.5, 539.5);
}

TEST(CircleProposals, HoldTheCameraThatSawTheCircle) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, 0.5);
  std::uniform_real_distribution<double> anywhere(-500, 500);
  for (const double pan : {0.0, 4.0, -3.0}) {
    const geometry::CameraEstimate truth = camera(pan, -13, 3800);
    std::vector<Eigen::Vector2d> points;
    for (int i = 0; i < 160; ++i) {
      const double angle = i * 2 * M_PI / 160;
      const Eigen::Vector2d p = seen(truth, 9.09 * std::cos(angle), 9.09 * std::sin(angle));
      if (std::abs(p.x()) < 960 && std::abs(p.y()) < 540)
        points.emplace_back(p.x() + noise(random), p.y() + noise(random));
    }
    // People.
    for (int i = 0; i < 40; ++i) points.emplace_back(anywhere(random), anywhere(random));
    const Eigen::Vector2d a = seen(truth, 0, -9);
    const Eigen::Vector2d b = seen(truth, 0, 9);
    const Eigen::Vector2d along = (b - a).normalized();
    const Eigen::Vector3d halfway(-along.y(), along.x(), along.y() * a.x() - along.x() * a.y());
    CircleSearch search;
    search.least_focal = 960;
    search.most_focal = 15000;
    const auto proposals = circle_proposals(halfway, points, search);
    double nearest = 1e9;
    for (const CircleProposal& proposal : proposals) {
      const double away = (proposal.position - Eigen::Vector3d(-3, -70, 16)).norm() / 72 +
                          std::abs(std::log(proposal.focal / 3800));
      nearest = std::min(nearest, away);
    }
    EXPECT_LT(nearest, 0.12) << pan << " of " << proposals.size();
  }
}

// A penalty arc, half of it in sight from the touchline, and the line that it stands on.
TEST(CircleProposals, HoldTheCameraThatSawAnArcBesideALine) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.4);
  geometry::Mount mount;
  mount.position_in_world = {14, -37, 2};
  mount.width = 1920;
  mount.height = 1080;
  mount.cx = 959.5;
  mount.cy = 539.5;
  const geometry::CameraEstimate truth = camera_at(mount, -27, -1.2, 9000);
  // The line lies at x = 0, the centre 5.44 m beyond it.
  const double radius = 9.09;
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 200; ++i) {
    const double angle = M_PI + (i / 199.0 - 0.5) * 2 * 0.93;
    const Eigen::Vector2d p =
        seen(truth, 5.44 + radius * std::cos(angle), radius * std::sin(angle));
    if (std::abs(p.x()) < 960 && std::abs(p.y()) < 540)
      points.emplace_back(p.x() + noise(random), p.y() + noise(random));
  }
  const Eigen::Vector2d a = seen(truth, 0, -9);
  const Eigen::Vector2d b = seen(truth, 0, 9);
  const Eigen::Vector2d along = (b - a).normalized();
  CircleSearch search;
  search.least_focal = 960;
  search.most_focal = 30000;
  search.tolerance_px = 5;
  search.offset = 5.44 / radius;
  search.least_sectors = 2;
  search.any_horizon = true;
  const auto proposals = circle_proposals(
      {-along.y(), along.x(), along.y() * a.x() - along.x() * a.y()}, points, search);
  double nearest = 1e9;
  for (const CircleProposal& proposal : proposals) {
    if (proposal.turned) continue;
    const Eigen::Vector3d from_centre = mount.position_in_world - Eigen::Vector3d(5.44, 0, 0);
    nearest = std::min(nearest, (proposal.position - from_centre).norm() / 40 +
                                    std::abs(std::log(proposal.focal / 9000)));
  }
  EXPECT_LT(nearest, 0.15) << "of " << proposals.size();
}

TEST(CircleProposals, NothingWithoutACircle) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> anywhere(-500, 500);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 200; ++i) points.emplace_back(anywhere(random), anywhere(random));
  CircleSearch search;
  search.least_focal = 960;
  search.most_focal = 15000;
  search.tolerance_px = 2;
  EXPECT_TRUE(circle_proposals({1, 0, 0}, points, search).empty());
  EXPECT_TRUE(circle_proposals({1, 0, 0}, {}, search).empty());
}

// From behind a goal all lines run across the picture, and most points are on them.
TEST(ColdStart, FindsTheCircleAmongLongLines) {
  DrawnScene scene;
  scene.pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0, {}});
  scene.side = Side::kRight;
  geometry::Mount& mount = scene.mount;
  mount.position_in_world = {75, 11.6, 12};
  mount.width = 960;
  mount.height = 540;
  mount.cx = 479.5;
  mount.cy = 269.5;
  constexpr double kDegree = M_PI / 180;
  constexpr double kFocal = 1840;
  scene.camera.model = geometry::camera_model(mount, kFocal);
  scene.camera.cam_from_world =
      geometry::cam_from_world(mount, {-97 * kDegree, -9 * kDegree, 0, kFocal});
  const LineMap map = detect_lines(draw_scene(scene), {});
  const auto found = cold_start(map, scene.pitch, scene.side, {});
  ASSERT_FALSE(found.empty());
  const Eigen::Vector3d place = geometry::origin(found.front().cam_from_world);
  EXPECT_LT((place - mount.position_in_world).norm(), 2) << place.transpose();
  EXPECT_NEAR(found.front().model.fx / kFocal, 1, 0.03);
}

}  // namespace
}  // namespace touchline::calibrate
