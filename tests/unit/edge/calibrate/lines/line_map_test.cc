#include "edge/calibrate/lines/line_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge/calibrate/lines/line_check.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

pitch::PitchModel soccer() {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.3, {}});
}

// Distance of a picture point from the nearest painted centre line, pixels.
double off_lines(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                 const Eigen::Vector2d& pixel) {
  double least = 1e9;
  for (const pitch::Marking& marking : pitch.markings) {
    Eigen::Vector2d last(1e9, 1e9);
    bool joined = false;
    for (double at = 0; at <= marking.length(); at += 0.25) {
      const auto image = geometry::project(camera, pitch.on_turf(marking.at(at)));
      if (!image) {
        joined = false;
        continue;
      }
      if (joined) {
        const Eigen::Vector2d d = *image - last;
        const double t = std::clamp((pixel - last).dot(d) / d.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (last + t * d - pixel).norm());
      }
      last = *image;
      joined = true;
    }
  }
  return least;
}

TEST(LineMap, RidgePointsLieOnPaintedLines) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  for (const double pan : {-25.0, 5.0, 30.0}) {
    const geometry::CameraEstimate camera = camera_at(mount, pan, -12, 1400);
    const LineMap map = detect_lines(paint_pitch(pitch, camera, {6, 0, true, 3}), {});
    ASSERT_GT(map.points.size(), 300U);
    int near = 0;
    double squares = 0;
    for (const RidgePoint& point : map.points) {
      EXPECT_NEAR(point.normal.norm(), 1, 1e-4);
      const double off = off_lines(pitch, camera, point.position.cast<double>());
      if (off > 1.5) continue;
      ++near;
      squares += off * off;
    }
    EXPECT_GT(near, 0.95 * static_cast<double>(map.points.size()));
    EXPECT_LT(std::sqrt(squares / near), 0.3);
  }
}

TEST(LineMap, StraightLinesRunAlongTheirPoints) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 25, -12, 1400);
  const LineMap map = detect_lines(paint_pitch(pitch, camera, {6, 0, true, 3}), {});
  ASSERT_GE(map.lines.size(), 4U);
  for (std::size_t i = 0; i < map.lines.size(); ++i) {
    const LineHypothesis& line = map.lines[i];
    EXPECT_NEAR(line.normal.norm(), 1, 1e-9);
    EXPECT_NEAR(line.normal.dot(line.start), line.offset, 1e-6);
    EXPECT_NEAR(line.normal.dot(line.end), line.offset, 1e-6);
    if (i > 0) {
      EXPECT_LE(line.points, map.lines[i - 1].points);
    }
  }
}

TEST(LineMap, TheNearestPointIsNearest) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 25, -12, 1400);
  const LineMap map = detect_lines(paint_pitch(pitch, camera, {6, 0, true, 3}), {});
  for (int y = 2; y < map.height; y += 37) {
    for (int x = 2; x < map.width; x += 41) {
      const Eigen::Vector2f pixel(static_cast<float>(x), static_cast<float>(y));
      float least = 1e9F;
      for (const RidgePoint& point : map.points)
        least = std::min(least, (point.position - pixel).norm());
      const int at = map.nearest_to(pixel.cast<double>());
      if (at >= 0) {
        EXPECT_LE((map.points[static_cast<std::size_t>(at)].position - pixel).norm(),
                  least + 1.5F * LineMap::kMapStep);
      } else {
        EXPECT_GT(least, map.reach_px - LineMap::kMapStep);
      }
    }
  }
  const double nan = std::nan("");
  EXPECT_EQ(map.nearest_to({nan, 5}), -1);
  EXPECT_EQ(map.nearest_to({1e300, 5}), -1);
  EXPECT_FALSE(map.on_turf({-1, 5}));
}

TEST(LineMap, TurfAloneHasNoLinesAndGreyHasNoTurf) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 10, -14, 1400);
  const LineMap bare = detect_lines(paint_pitch(pitch, camera, {6, 0, false, 2}), {});
  EXPECT_GT(bare.turf_share, 0.4);
  EXPECT_LT(bare.points.size(), 60U);
  EXPECT_TRUE(bare.lines.empty());

  image::Frame grey;
  grey.planes[0] = image::Image<std::uint16_t>(640, 360, 500);
  grey.planes[1] = image::Image<std::uint16_t>(320, 360, 512);
  grey.planes[2] = image::Image<std::uint16_t>(320, 360, 512);
  const LineMap none = detect_lines(grey, {});
  EXPECT_EQ(none.turf_share, 0);
  EXPECT_TRUE(none.points.empty());
  EXPECT_TRUE(detect_lines(image::Frame{}, {}).points.empty());
}

TEST(LineMap, PeopleAddLittle) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 20, -13, 1400);
  const LineMap map = detect_lines(paint_pitch(pitch, camera, {6, 40, true, 5}), {});
  EXPECT_GT(explain_lines(map, pitch, camera, 2).share(), 0.85);
}

TEST(LineMap, IsDeterministic) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 20, -13, 1400);
  const image::Frame frame = paint_pitch(pitch, camera, {6, 20, true, 5});
  const LineMap a = detect_lines(frame, {});
  const LineMap b = detect_lines(frame, {});
  ASSERT_EQ(a.points.size(), b.points.size());
  for (std::size_t i = 0; i < a.points.size(); ++i)
    EXPECT_EQ(a.points[i].position, b.points[i].position);
  EXPECT_EQ(a.nearest, b.nearest);
}

TEST(LineMapOptions, NamesTheFieldThatIsWrong) {
  LineMapOptions options;
  EXPECT_TRUE(options.validate());
  options.turf_hue_deg = 500;
  const base::Status status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "turf_hue_deg");
}

}  // namespace
}  // namespace touchline::calibrate
