// Pitch and stadium of a virtual view, against what was put into the plates.
#include <gtest/gtest.h>

#include <cmath>

#include "hub/render/renderer.h"
#include "tests/support/capsule_scene.h"
#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

using support::looking_at;

RenderResult render_empty(const std::map<base::CameraId, image::PlateSnapshot>& plates,
                          const geometry::CameraEstimate& camera) {
  RenderOptions options;
  options.find_stadium = false;
  const auto renderer = Renderer::make(flat_pitch(), plates, {}, options);
  return renderer->render({}, {}, camera, Mode::kHull);
}

double turf_error(const scene::Picture& picture, const geometry::CameraEstimate& camera) {
  double sum = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Drawn truth = draw({}, camera, x, y);
      const scene::Rgba8& p = picture(x, y);
      sum += (std::abs(p.r - truth.colour[0]) + std::abs(p.g - truth.colour[1]) +
              std::abs(p.b - truth.colour[2])) /
             3;
    }
  }
  return sum / static_cast<double>(picture.size());
}

TEST(Background, TurfOfANewViewIsThatOfThePlates) {
  std::map<base::CameraId, image::PlateSnapshot> plates;
  plates[{"a"}] = draw_plate({-6, -18, 9}, 1.0 / 900, 13);
  plates[{"b"}] = draw_plate({7, -16, 8}, 1.0 / 700, 13);
  const auto camera = looking_at({1, -9, 3}, {0, 0, 0}, 400, 240, 136);
  const auto result = render_empty(plates, camera);
  EXPECT_LT(turf_error(result.picture, camera), 1.5);
  EXPECT_LT(result.report.unseen_share, 0.01);
  for (const scene::Rgba8& p : std::span(result.picture.data(), result.picture.size())) {
    ASSERT_EQ(p.a, 255);
  }
  double share = 0;
  for (const auto& [id, s] : result.report.share_by_camera) share += s;
  EXPECT_NEAR(share + result.report.unseen_share, 1, 1e-6);
}

TEST(Background, APlateThatLooksAgainstTheTurnServesAsWell) {
  std::map<base::CameraId, image::PlateSnapshot> plates;
  plates[{"reverse"}] = draw_plate({0.3, 17, 9}, 1.0 / 800, 8);
  const auto camera = looking_at({0, 10, 5}, {0, 0, 0}, 400, 240, 136);
  EXPECT_LT(turf_error(render_empty(plates, camera).picture, camera), 1.5);
}

TEST(Background, WhatNoPlateShowsIsFilledAndCounted) {
  const auto camera = looking_at({1, -9, 3}, {0, 0, 1}, 200, 240, 136);
  const auto result = render_empty({}, camera);
  EXPECT_NEAR(result.report.unseen_share, 1, 1e-6);
  for (const scene::Rgba8& p : std::span(result.picture.data(), result.picture.size())) {
    ASSERT_EQ(p.a, 255);
    ASSERT_GT(p.r + p.g + p.b, 60);
  }
}

}  // namespace
}  // namespace touchline::render
