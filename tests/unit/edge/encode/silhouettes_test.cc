#include "edge/encode/silhouettes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/edge/encode/scene.h"

namespace touchline::encode {
namespace {

double area(const geometry::SilhouettePolygon& polygon) {
  double sum = 0;
  for (std::size_t i = 0; i < polygon.ring.size(); ++i) {
    const Eigen::Vector2f& a = polygon.ring[i];
    const Eigen::Vector2f& b = polygon.ring[(i + 1) % polygon.ring.size()];
    sum += double{a.x()} * double{b.y()} - double{b.x()} * double{a.y()};
  }
  return sum / 2;
}

// Every vertex and the middle of every edge within `limit` of the circle.
void expect_circle(const geometry::SilhouettePolygon& polygon, double cx, double cy, double r,
                   double limit) {
  for (std::size_t i = 0; i < polygon.ring.size(); ++i) {
    const Eigen::Vector2f& a = polygon.ring[i];
    const Eigen::Vector2f& b = polygon.ring[(i + 1) % polygon.ring.size()];
    for (const Eigen::Vector2f& p : {a, Eigen::Vector2f((a + b) / 2)}) {
      EXPECT_NEAR(std::hypot(p.x() - cx, p.y() - cy), r, limit);
    }
  }
}

TEST(Silhouettes, LieOnTheHalfCoverageBoundary) {
  image::Matte matte = samples::empty_matte(120, 90);
  samples::add_disc(matte, 50.3, 40.8, 20.25);
  for (const float simplify : {0.0f, 0.3f, 0.5f}) {
    const geometry::Partial partial = trace_silhouettes(matte, simplify);
    ASSERT_EQ(partial.polygons.size(), 1u);
    EXPECT_FALSE(partial.polygons[0].hole);
    EXPECT_EQ(partial.tolerance_px, simplify);
    expect_circle(partial.polygons[0], 50.3, 40.8, 20.25, simplify + 0.12);
  }
}

TEST(Silhouettes, OutlinesRunCounterClockwiseAndHolesTheOtherWay) {
  image::Matte matte = samples::empty_matte(120, 90);
  samples::add_disc(matte, 50, 40, 25);
  samples::cut_disc(matte, 55, 42, 9);
  const geometry::Partial partial = trace_silhouettes(matte, 0.3f);
  ASSERT_EQ(partial.polygons.size(), 2u);
  EXPECT_FALSE(partial.polygons[0].hole);
  EXPECT_TRUE(partial.polygons[1].hole);
  // With y down a positive area runs clockwise as one sees it.
  EXPECT_LT(area(partial.polygons[0]), 0);
  EXPECT_GT(area(partial.polygons[1]), 0);
  expect_circle(partial.polygons[1], 55, 42, 9, 0.45);
}

TEST(Silhouettes, SimplifyingSavesVerticesAndKeepsArea) {
  image::Matte matte = samples::empty_matte(200, 200);
  samples::add_disc(matte, 100, 100, 80);
  const geometry::Partial full = trace_silhouettes(matte, 0);
  const geometry::Partial simple = trace_silhouettes(matte, 0.3f);
  EXPECT_LT(simple.polygons[0].ring.size() * 4, full.polygons[0].ring.size());
  EXPECT_NEAR(area(simple.polygons[0]) / area(full.polygons[0]), 1, 0.005);
}

TEST(Silhouettes, CountUnknownAndOccludersAsForeground) {
  image::Matte matte = samples::empty_matte(60, 60);
  for (int y = 10; y < 20; ++y) {
    for (int x = 10; x < 20; ++x) {
      matte.unknown(x, y) = 255;
      matte.occluders(x + 20, y + 20) = 255;
    }
  }
  const geometry::Partial partial = trace_silhouettes(matte, 0.3f);
  ASSERT_EQ(partial.polygons.size(), 2u);
  EXPECT_NEAR(-area(partial.polygons[0]), 100, 2);
  EXPECT_NEAR(-area(partial.polygons[1]), 100, 2);
}

TEST(Silhouettes, EndAtTheRegionThoughAPostGoesOn) {
  image::Matte matte = samples::empty_matte(60, 60);
  matte.region = {20, 20, 20, 20};
  for (int y = 0; y < 60; ++y) matte.occluders(30, y) = 255;
  for (int x = 0; x < 60; ++x) matte.unknown(x, 25) = 255;
  const geometry::Partial partial = trace_silhouettes(matte, 0.5f);
  ASSERT_FALSE(partial.polygons.empty());
  for (const geometry::SilhouettePolygon& polygon : partial.polygons) {
    for (const Eigen::Vector2f& vertex : polygon.ring) {
      EXPECT_GT(vertex.minCoeff(), 19);
      EXPECT_LT(vertex.maxCoeff(), 40);
    }
  }
}

TEST(Silhouettes, CloseHalfAPixelOutsideThePicture) {
  image::Matte matte = samples::empty_matte(16, 12);
  for (std::size_t i = 0; i < matte.alpha.size(); ++i) matte.alpha.data()[i] = 255;
  const geometry::Partial partial = trace_silhouettes(matte, 0.3f);
  ASSERT_EQ(partial.polygons.size(), 1u);
  EXPECT_NEAR(-area(partial.polygons[0]), 16 * 12, 1);
}

TEST(Silhouettes, TraceSinglePixelsAndChequersToTheEnd) {
  image::Matte matte = samples::empty_matte(16, 12);
  matte.alpha(3, 3) = 255;
  EXPECT_EQ(trace_silhouettes(matte, 0.3f).polygons.size(), 1u);
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 16; ++x) matte.alpha(x, y) = (x + y) % 2 == 0 ? 255 : 0;
  }
  const geometry::Partial partial = trace_silhouettes(matte, 0.3f);
  EXPECT_FALSE(partial.polygons.empty());
  for (const auto& polygon : partial.polygons) EXPECT_GE(polygon.ring.size(), 3u);
}

}  // namespace
}  // namespace touchline::encode
