// People of a virtual view, against pictures that are drawn exactly.
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <vector>

#include "hub/render/renderer.h"
#include "tests/support/capsule_scene.h"
#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

using support::looking_at;

constexpr int kWidth = 200;
constexpr int kHeight = 150;
const Eigen::Vector3d kCentre(0, 0, 1);

geometry::CameraEstimate camera_at(double angle_deg, double height = 4, double focal = 1100) {
  const double a = angle_deg * 3.14159265358979 / 180;
  return looking_at({12 * std::sin(a), -12 * std::cos(a), height}, kCentre, focal, kWidth, kHeight);
}

std::vector<codec::CameraView> views_round(const std::vector<Ball>& balls) {
  std::vector<codec::CameraView> out;
  const std::pair<const char*, double> cameras[] = {
      {"c1", -40}, {"c2", 0}, {"c3", 35}, {"c4", 160}};
  for (const auto& [id, angle] : cameras) out.push_back(draw_view(id, camera_at(angle), balls));
  return out;
}

Renderer plain_renderer(RenderOptions options = {}) {
  options.find_stadium = false;
  return *Renderer::make(flat_pitch(), {}, {}, options);
}

struct Difference {
  double colour = 0;    // mean absolute, where the ball is opaque
  double coverage = 0;  // mean absolute over the picture's foreground pixels
  int pixels = 0;
};

Difference compare(const scene::Picture& picture, const std::vector<Ball>& balls,
                   const geometry::CameraEstimate& camera) {
  Difference out;
  int edge = 0;
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const Drawn truth = draw(balls, camera, x, y);
      const scene::Rgba8& p = picture(x, y);
      if (truth.coverage > 0 || p.a > 0) {
        out.coverage += std::abs(p.a / 255.0 - truth.coverage);
        ++edge;
      }
      if (truth.coverage < 0.999) continue;
      out.colour += (std::abs(p.r - truth.colour[0]) + std::abs(p.g - truth.colour[1]) +
                     std::abs(p.b - truth.colour[2])) /
                    3;
      ++out.pixels;
    }
  }
  out.colour /= std::max(1, out.pixels);
  out.coverage /= std::max(1, edge);
  return out;
}

TEST(Foreground, ACamerasOwnPoseGivesItsPicture) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  const auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.06, views);
  const Renderer renderer = plain_renderer();
  for (const codec::CameraView& view : views) {
    const auto result = renderer.render_foreground(views, hull, view.estimate, Mode::kHull);
    const Difference d = compare(result.picture, balls, view.estimate);
    EXPECT_GT(d.pixels, 5000);
    EXPECT_LT(d.colour, 1.0) << view.id.camera.value;
    EXPECT_LT(d.coverage, 0.02) << view.id.camera.value;
    EXPECT_GT(result.report.share_by_camera.at(view.id.camera),
              0.9 * result.report.foreground_share);
  }
}

TEST(Foreground, BetweenCamerasThePatternStaysInPlace) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  const auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.03, views);
  const auto camera = camera_at(15, 3);
  const auto result = plain_renderer().render_foreground(views, hull, camera, Mode::kHull);
  const Difference d = compare(result.picture, balls, camera);
  EXPECT_LT(d.colour, 6);
  EXPECT_LT(d.coverage, 0.05);
}

TEST(Foreground, AHullThatIsTooFatIsTrimmedByTheMattes) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  const auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.4, views);
  const auto camera = camera_at(2);
  const auto result = plain_renderer().render_foreground(views, hull, camera, Mode::kHull);
  EXPECT_LT(compare(result.picture, balls, camera).coverage, 0.06);
}

TEST(Foreground, NoColourComesFromACameraThatSomebodyHides) {
  // From camera a the red ball hides the blue one; the virtual camera, above a, sees blue.
  const std::vector<Ball> balls = {{{0, -2.2, 1}, 0.5, {220, 20, 20}},
                                   {{0, 0, 1}, 0.4, {20, 20, 220}}};
  std::vector<codec::CameraView> views;
  views.push_back(draw_view("a", camera_at(0, 1), balls));
  views.push_back(draw_view("b", camera_at(60, 3), balls));
  views.push_back(draw_view("c", camera_at(-70, 3), balls));
  const auto hull = hull_of(balls, 0.05, views);
  const auto camera = camera_at(0, 7);
  const auto result = plain_renderer().render_foreground(views, hull, camera, Mode::kHull);
  int blue = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Drawn truth = draw(balls, camera, x, y);
      if (truth.coverage < 0.999 || truth.colour[2] < 2 * truth.colour[0]) continue;
      const scene::Rgba8& p = result.picture(x, y);
      ++blue;
      EXPECT_LT(p.r, 60) << x << "," << y;
    }
  }
  EXPECT_GT(blue, 1500);
}

TEST(Foreground, PhantomsAreNeverShown) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  const auto views = views_round(balls);
  auto hull = hull_of(balls, 0.05, views);
  hull.groups[0].phantom = true;
  const Renderer renderer = plain_renderer();
  for (const Mode mode : {Mode::kHull, Mode::kRefined, Mode::kBillboard}) {
    const auto result = renderer.render_foreground(views, hull, camera_at(3), mode);
    for (const scene::Rgba8& p : std::span(result.picture.data(), result.picture.size())) {
      ASSERT_EQ(p, scene::Rgba8{});
    }
    ASSERT_EQ(result.report.groups.size(), 1U);
    EXPECT_EQ(result.report.groups[0].rendition, scene::Rendition::kAbsent);
  }
}

TEST(Foreground, NothingLiesOutsideThePeople) {
  const std::vector<Ball> balls = {{kCentre, 0.3, {200, 60, 40}}};
  const auto views = views_round(balls);
  const auto camera = camera_at(20, 3);
  const auto result =
      plain_renderer().render_foreground(views, hull_of(balls, 0.05, views), camera, Mode::kHull);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      double near = 0;
      for (int dy = -3; dy <= 3; dy += 3) {
        for (int dx = -3; dx <= 3; dx += 3) {
          near += draw(balls, camera, x + dx, y + dy).coverage;
        }
      }
      if (near == 0) {
        EXPECT_EQ(result.picture(x, y).a, 0) << x << "," << y;
      }
    }
  }
}

TEST(Foreground, UnknownIsNoStatement) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.02, views);
  const auto camera = camera_at(1);
  // The nearest camera knows nothing: the others shape the ball.
  views[1].matte->alpha = image::Image<std::uint8_t>(kWidth, kHeight, 0);
  views[1].matte->unknown = image::Image<std::uint8_t>(kWidth, kHeight, 255);
  const Renderer renderer = plain_renderer();
  EXPECT_LT(
      compare(renderer.render_foreground(views, hull, camera, Mode::kHull).picture, balls, camera)
          .coverage,
      0.1);
  // It claims background: nothing is left.
  views[1].matte->unknown = image::Image<std::uint8_t>(kWidth, kHeight, 0);
  EXPECT_LT(renderer.render_foreground(views, hull, camera, Mode::kHull).report.foreground_share,
            1e-6);
}

TEST(Foreground, BillboardAtItsCamerasPoseIsItsPicture) {
  const std::vector<Ball> balls = {{kCentre, 0.5, {200, 60, 40}}};
  const auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.05, views);
  const auto result =
      plain_renderer().render_foreground(views, hull, views[2].estimate, Mode::kBillboard);
  const Difference d = compare(result.picture, balls, views[2].estimate);
  EXPECT_LT(d.colour, 1.5);
  EXPECT_LT(d.coverage, 0.03);
  ASSERT_EQ(result.report.groups.size(), 1U);
  EXPECT_EQ(result.report.groups[0].rendition, scene::Rendition::kBillboard);
}

TEST(Foreground, WhatOneCameraSeesStandsAsABillboard) {
  const std::vector<Ball> balls = {{{0, 0, 0.5}, 0.5, {200, 60, 40}}};
  const std::vector<codec::CameraView> views = {draw_view("c1", camera_at(0), balls)};
  scene::Hull hull;
  hull.billboards.push_back({7, {"c1"}, {0, 0, kWidth, kHeight}, {0, 0, 0}, 1});
  const auto result =
      plain_renderer().render_foreground(views, hull, views[0].estimate, Mode::kHull);
  EXPECT_LT(compare(result.picture, balls, views[0].estimate).coverage, 0.05);
  ASSERT_EQ(result.report.groups.size(), 1U);
  EXPECT_EQ(result.report.groups[0].id, 7U);
  EXPECT_EQ(result.report.groups[0].rendition, scene::Rendition::kBillboard);
}

TEST(Foreground, SameBytesAtAnyThreadCount) {
  const std::vector<Ball> balls = {{{0, -0.8, 1}, 0.4, {220, 20, 20}},
                                   {{0.4, 0.5, 1}, 0.5, {20, 20, 220}}};
  const auto views = views_round(balls);
  const auto hull = hull_of(balls, 0.05, views);
  const Renderer renderer = plain_renderer();
  const auto render = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return renderer.render(views, hull, camera_at(10, 3), Mode::kHull);
  };
  const auto one = render(1);
  const auto two = render(2);
  EXPECT_EQ(one.picture, two.picture);
  EXPECT_EQ(one.report.share_by_camera, two.report.share_by_camera);
}

}  // namespace
}  // namespace touchline::render
