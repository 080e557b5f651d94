#include <gtest/gtest.h>

#include <cmath>

#include "shared/geometry/mount.h"
#include "tools/score/camera_score.h"
#include "tools/score/hull_score.h"
#include "tools/score/matte_score.h"
#include "tools/score/series.h"
#include "tools/score/view_score.h"

namespace touchline::score {
namespace {

geometry::CameraEstimate wide_camera(double pan, double tilt = -0.2) {
  geometry::CameraEstimate camera;
  camera.model = {1920, 1080, 1800, 1800, 959.5, 539.5, 0, 0};
  camera.cam_from_world.rotation = geometry::cam_from_reference(pan, tilt, 0);
  camera.cam_from_world.translation =
      -(camera.cam_from_world.rotation * Eigen::Vector3d(0, -70, 15));
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

TEST(Quantile, InterpolatesBetweenValues) {
  EXPECT_EQ(quantile({}, 0.5), 0);
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_DOUBLE_EQ(quantile({0, 1}, 0.25), 0.25);
}

TEST(GridRms, IsThePanErrorInPixels) {
  const pitch::PitchModel pitch;
  const auto none = grid_rms_px(wide_camera(0), wide_camera(0), pitch);
  ASSERT_TRUE(none);
  EXPECT_EQ(*none, 0);
  const double angle = 1e-3;
  const auto some = grid_rms_px(wide_camera(0), wide_camera(angle), pitch);
  ASSERT_TRUE(some);
  EXPECT_NEAR(*some, 1800 * angle, 0.1 * 1800 * angle);
  EXPECT_FALSE(grid_rms_px(wide_camera(0, 1.2), wide_camera(0, 1.2), pitch));
}

image::Image<std::uint8_t> box_matte(int x0, int x1) {
  image::Image<std::uint8_t> matte(60, 40);
  for (int y = 10; y < 30; ++y) {
    for (int x = x0; x < x1; ++x) matte(x, y) = 255;
  }
  return matte;
}

TEST(MatteScore, OfEqualMattesIsPerfect) {
  MatteScore score;
  add_matte(score, box_matte(10, 30), box_matte(10, 30));
  EXPECT_EQ(score.iou(), 1);
  EXPECT_EQ(score.mean_boundary_px(), 0);
  EXPECT_EQ(score.missing_share(), 0);
  EXPECT_EQ(score.extra_share(), 0);
}

TEST(MatteScore, OfAShiftCountsBothSides) {
  MatteScore score;
  add_matte(score, box_matte(10, 30), box_matte(12, 32));
  EXPECT_DOUBLE_EQ(score.iou(), 18.0 / 22);
  EXPECT_DOUBLE_EQ(score.missing_share(), 0.1);
  EXPECT_DOUBLE_EQ(score.extra_share(), 0.1);
  EXPECT_GT(score.mean_boundary_px(), 0.5);
  EXPECT_LT(score.mean_boundary_px(), 2);
}

geometry::Mesh tetrahedron(const Eigen::Vector3f& at, float size) {
  geometry::Mesh mesh;
  mesh.vertices = {at, at + Eigen::Vector3f(size, 0, 0), at + Eigen::Vector3f(0, size, 0),
                   at + Eigen::Vector3f(0, 0, size)};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

TEST(HullScore, CountsVerticesInsideAndPhantoms) {
  geometry::Mesh hull = tetrahedron({0, 0, 0}, 3);
  const geometry::Mesh elsewhere = tetrahedron({10, 0, 0}, 1);
  const auto first = static_cast<std::uint32_t>(hull.vertices.size());
  hull.vertices.insert(hull.vertices.end(), elsewhere.vertices.begin(), elsewhere.vertices.end());
  for (const auto& t : elsewhere.triangles) {
    hull.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  EXPECT_EQ(split_components(hull).size(), 2U);
  geometry::Mesh truth;
  for (int i = 0; i < 300; ++i) truth.vertices.emplace_back(0.5F, 0.5F, 0.2F + 0.002F * float(i));
  for (int i = 0; i < 100; ++i) truth.vertices.emplace_back(0.5F, 0.5F, 2.5F);
  const std::vector<TruePerson> people = {{"A1", "A", "player", {0.5, 0.5, 0}}};
  const std::vector<geometry::CameraEstimate> cameras = {wide_camera(0), wide_camera(0.02)};
  const HullScore score = score_hull(hull, truth, people, cameras, 0.02);
  ASSERT_EQ(score.people.size(), 1U);
  EXPECT_DOUBLE_EQ(score.people[0].share, 0.75);
  EXPECT_EQ(score.components, 2U);
  EXPECT_EQ(score.phantoms, 1U);
  EXPECT_NEAR(score.volume_m3, 27.0 / 6 + 1.0 / 6, 1e-5);
}

TEST(ViewScore, FindsAShift) {
  image::Image<image::Rgb8> clean(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 0; x < 80; ++x) {
      const auto value =
          static_cast<std::uint8_t>(128 + 60 * std::sin(0.7 * x) * std::cos(0.5 * y));
      clean(x, y) = {value, value, value};
    }
  }
  image::Image<image::Rgb8> shifted(80, 60);
  for (int y = 0; y < 60; ++y) {
    for (int x = 2; x < 80; ++x) shifted(x, y) = clean(x - 2, y);
  }
  const Mask everywhere(80, 60, 255);
  EXPECT_EQ(psnr_db(clean, clean, everywhere), 99);
  EXPECT_NEAR(ssim(clean, clean, everywhere).full, 1, 1e-6);
  Mask matte(80, 60);
  for (int y = 25; y < 35; ++y) {
    for (int x = 35; x < 45; ++x) matte(x, y) = 255;
  }
  const Mask people = grown_foreground(matte);
  const Alignment aligned = align(clean, shifted, people);
  ASSERT_EQ(aligned.pieces.size(), 1U);
  EXPECT_EQ(aligned.pieces[0].shift_px, Eigen::Vector2d(2, 0));
  EXPECT_EQ(aligned.psnr_db, 99);
  EXPECT_LT(psnr_db(clean, shifted, people), 20);
}

}  // namespace
}  // namespace touchline::score
