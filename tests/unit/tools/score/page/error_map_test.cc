// The pictures of errors show what is wrong, where it is wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/capsule_scene.h"
#include "tools/score/page/camera_map.h"
#include "tools/score/page/hull_map.h"
#include "tools/score/page/matte_map.h"
#include "tools/score/page/view_map.h"

namespace touchline::score::page {

using namespace draw;  // NOLINT: this file looks at drawings

namespace {

pitch::PitchModel soccer() { return *pitch::make_pitch(pitch::Sport::kSoccer, {}); }

geometry::CameraEstimate camera() {
  return support::looking_at({0, -60, 15}, {0, 0, 0}, 900, 960, 540);
}

TEST(CameraMap, TellsTheLongestError) {
  const Picture frame(960, 540, {60, 120, 60});
  geometry::CameraEstimate moved = camera();
  moved.model.cx += 3;
  const CameraMap map = camera_map(frame, camera(), moved, soccer());
  EXPECT_NEAR(map.worst_px, 3, 1e-6);
  EXPECT_GE(map.exaggeration, 10);
  EXPECT_EQ(map.whole.width(), 960);
  EXPECT_FALSE(map.zoom.empty());
  EXPECT_EQ(camera_map(frame, camera(), camera(), soccer()).worst_px, 0);
}

TEST(CameraMap, OfALostCameraShowsTheTruthAlone) {
  const Picture frame(960, 540, {60, 120, 60});
  const CameraMap none = camera_map(frame, camera(), std::nullopt, soccer());
  EXPECT_TRUE(none.zoom.empty());
  EXPECT_EQ(none.whole.width(), 960);
}

TEST(MaskErrors, AreRedWhereMissingAndBlueWhereExtra) {
  const Picture frame(4, 1, {100, 100, 100});
  Mask truth(4, 1), found(4, 1);
  truth(0, 0) = truth(1, 0) = 255;
  found(1, 0) = found(2, 0) = 255;
  const Picture errors = mask_errors(frame, truth, found);
  EXPECT_EQ(errors(0, 0), kMissing);
  EXPECT_EQ(errors(1, 0), (image::Rgb8{100, 100, 100}));
  EXPECT_EQ(errors(2, 0), kExtra);
  EXPECT_NE(errors(3, 0), kExtra);
}

geometry::Mesh box(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  geometry::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) ? high.x() : low.x(), (i & 2) ? high.y() : low.y(),
                               (i & 4) ? high.z() : low.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

TEST(Silhouette, HasTheSizeOfTheProjection) {
  const auto c = support::looking_at({0, -10, 1}, {0, 0, 1}, 500, 400, 300);
  const Mask mask = silhouette(box({-1, -0.01F, 0}, {1, 0.01F, 2}), c, {0, 0, 400, 300}, 1);
  int set = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) set += mask.data()[i] != 0;
  EXPECT_NEAR(set, 100 * 100, 0.03 * 100 * 100);
  const Mask twice = silhouette(box({-1, -0.01F, 0}, {1, 0.01F, 2}), c, {150, 50, 100, 100}, 2);
  EXPECT_EQ(twice.width(), 200);
}

TEST(FindFaults, NamesWhatIsOutsideAndWhatIsAPhantom) {
  geometry::Mesh hull = box({-1, -1, 0}, {1, 1, 1});
  const geometry::Mesh other = box({5, 5, 0}, {6, 6, 1});
  const auto first = static_cast<std::uint32_t>(hull.vertices.size());
  hull.vertices.insert(hull.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& t : other.triangles) {
    hull.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const geometry::Mesh truth = box({-0.5F, -0.5F, 0.2F}, {0.5F, 0.5F, 1.5F});
  const HullFaults faults = find_faults(hull, truth, 0.02);
  EXPECT_EQ(faults.outside.size(), 4U);
  ASSERT_EQ(faults.phantoms.size(), 1U);
  EXPECT_GT(faults.phantoms[0].vertices[0].x(), 4);
}

TEST(WindowRound, IsEmptyWhereTheCameraSeesTooLittle) {
  const auto c = support::looking_at({0, -10, 1}, {0, 0, 1}, 500, 400, 300);
  EXPECT_FALSE(window_round(c, {{0, 0, 0}, {0, 0, 1.8F}}).empty());
  EXPECT_TRUE(window_round(c, {{0, -30, 0}, {0, -30, 1.8F}}).empty());
  EXPECT_TRUE(window_round(c, {}).empty());
}

TEST(ViewMap, IsBlackWherePicturesAgree) {
  const Picture clean(200, 160, {90, 90, 90});
  Picture ours = clean;
  ours(120, 80) = {200, 90, 90};
  const ViewMap map = view_map(clean, ours, std::nullopt);
  EXPECT_EQ(map.difference(20, 20), image::Rgb8{});
  EXPECT_EQ(map.difference(120, 80), (image::Rgb8{255, 255, 255}));
  EXPECT_GT(map.zoom.width(), map.zoom.height());
}

}  // namespace
}  // namespace touchline::score::page
