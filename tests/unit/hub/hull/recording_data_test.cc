// The hull of a recorded match from its true cameras and mattes.
#include <gtest/gtest.h>

#include <random>

#include "hub/hull/carve.h"
#include "tests/support/folders.h"
#include "tools/score/mesh_query.h"
#include "tools/score/oracle.h"
#include "tools/score/truth.h"

namespace touchline::hull {
namespace {

class HullData : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto data = support::data_folder();
    if (!data || !std::filesystem::exists(*data / "recordings/dev-attack")) {
      GTEST_SKIP() << "no recordings/dev-attack: set TOUCHLINE_DATA";
    }
    const auto recording = recording::load_recording(*data / "recordings/dev-attack");
    ASSERT_TRUE(recording) << to_string(recording.error());
    auto truth = score::Truth::open(*recording);
    ASSERT_TRUE(truth) << to_string(truth.error());
    truth_.emplace(std::move(*truth));
    score::OracleOptions options;
    options.tiles = false;
    auto oracle = score::Oracle::open(*recording, *truth_, options);
    ASSERT_TRUE(oracle) << to_string(oracle.error());
    pitch_ = oracle->pitch();
    auto views = oracle->next();
    ASSERT_TRUE(views) << to_string(views.error());
    ASSERT_TRUE(*views);
    views_ = std::move(**views);
  }

  // Share of the vertices of people and ball, seen by two true cameras or more, inside the hull.
  double share_inside(const scene::Hull& hull, double reach_m) const {
    score::MeshQuery query;
    for (const scene::HullGroup& group : hull.groups) {
      if (!group.phantom) query.add(group.surface);
    }
    const auto mesh = truth_->mesh(0);
    if (!mesh) return 0;
    std::size_t seen = 0;
    std::size_t inside = 0;
    for (const Eigen::Vector3f& vertex : mesh->vertices) {
      const Eigen::Vector3d point = vertex.cast<double>();
      int cameras = 0;
      for (const codec::CameraView& view : views_) {
        const auto pixel = geometry::project(view.estimate, point);
        cameras += pixel && view.estimate.model.sees(*pixel);
      }
      if (cameras < 2) continue;
      ++seen;
      inside += query.inside(point) || (reach_m > 0 && query.distance(point, reach_m) < reach_m);
    }
    EXPECT_GT(seen, 1000U);
    return static_cast<double>(inside) / static_cast<double>(seen);
  }

  std::optional<score::Truth> truth_;
  pitch::PitchModel pitch_;
  std::vector<codec::CameraView> views_;
};

TEST_F(HullData, HoldsTheTrueSurfaces) {
  const HullResult result = carve(views_, pitch_, HullOptions());
  EXPECT_GE(share_inside(result.hull, 0), 0.999);
}

TEST_F(HullData, HoldsThemWithCamerasHalfAPixelOff) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0, 0.5);
  std::vector<codec::CameraView> views = views_;
  for (codec::CameraView& view : views) {
    const Eigen::Vector3d eye = geometry::position_in_world(view.estimate);
    const double pixel = 1 / view.estimate.model.fx;
    view.estimate.cam_from_world.rotation =
        Eigen::AngleAxisd(normal(random) * pixel, Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(normal(random) * pixel, Eigen::Vector3d::UnitY()) *
        view.estimate.cam_from_world.rotation;
    view.estimate.cam_from_world.translation = -(view.estimate.cam_from_world.rotation * eye);
  }
  const HullResult result = carve(views, pitch_, HullOptions());
  EXPECT_GE(share_inside(result.hull, 0.02), 0.99);
}

}  // namespace
}  // namespace touchline::hull
