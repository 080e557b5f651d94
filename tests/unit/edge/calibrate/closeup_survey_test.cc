#include "edge/calibrate/closeup_survey.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "tests/unit/edge/calibrate/drawn_pitch.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// A camera at the touchline, not quite level, that follows play past a penalty arc.
struct Take {
  pitch::PitchModel pitch;
  geometry::Mount mount;
  std::vector<image::FramePtr> frames;
  std::vector<geometry::CameraEstimate> truth;
};

Take take(double sweep_deg, int count) {
  Take out;
  out.pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {105, 68, {}, 0.25, {}});
  out.mount.width = 960;
  out.mount.height = 540;
  out.mount.cx = 479.5;
  out.mount.cy = 269.5;
  out.mount.position_in_world = {47, -37.5, 2.2};
  out.mount.level_x = 0.1 * kDegree;
  out.mount.level_y = -0.15 * kDegree;
  const Eigen::Vector3d d = Eigen::Vector3d(31, -2, 0.7) - out.mount.position_in_world;
  DrawnScene scene;
  scene.pitch = out.pitch;
  scene.mount = out.mount;
  scene.people = 3;
  scene.noise = 4;
  for (int i = 0; i < count; ++i) {
    const double u = count > 1 ? i / (count - 1.0) - 0.5 : 0;
    const double focal = 2600 * std::exp(0.05 * u);
    geometry::CameraEstimate& camera = scene.camera;
    camera.model = geometry::camera_model(out.mount, focal);
    camera.cam_from_world =
        geometry::cam_from_world(out.mount, {std::atan2(d.x(), d.y()) + sweep_deg * kDegree * u,
                                             std::asin(d.z() / d.norm()), 0, focal});
    camera.evidence = geometry::Evidence::kLines;
    scene.seed = static_cast<std::uint32_t>(i + 1);
    image::Frame frame = draw_scene(scene);
    frame.stamp.media_time.ns = i * 40'000'000LL;
    out.frames.push_back(std::make_shared<const image::Frame>(std::move(frame)));
    out.truth.push_back(camera);
  }
  return out;
}

TEST(CloseupSurvey, FindsAMountThatSawOneLineAndAnArc) {
  const Take seen = take(9, 16);
  const auto found = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  ASSERT_TRUE(found) << base::to_string(found.error());
  EXPECT_LT((found->take.mount.position_in_world - seen.mount.position_in_world).norm(), 0.15);
  EXPECT_EQ(found->solved, seen.frames.size());
  ASSERT_FALSE(found->first.lost());
  EXPECT_LT(turf_rms_px(seen.pitch, seen.truth.front(), found->first), 1.5);
}

TEST(CloseupSurvey, TheSameFramesSayTheSame) {
  const Take seen = take(9, 6);
  const auto once = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  const auto again = survey_closeup(seen.frames, seen.pitch, Side::kMain, {});
  ASSERT_EQ(once.has_value(), again.has_value());
  if (!once) return;
  EXPECT_EQ(once->take.mount.position_in_world, again->take.mount.position_in_world);
}

TEST(CloseupSurvey, DoesNotStandOnOneView) {
  const Take seen = take(0, 2);
  EXPECT_FALSE(survey_closeup(seen.frames, seen.pitch, Side::kMain, {}));
}

// Lines alone never tell the side.
TEST(CloseupSurvey, FromTheOtherSideThePlaceIsTurned) {
  const Take seen = take(9, 4);
  const auto found = survey_closeup(seen.frames, seen.pitch, Side::kReverse, {});
  ASSERT_TRUE(found) << base::to_string(found.error());
  const Eigen::Vector3d& p = seen.mount.position_in_world;
  EXPECT_LT((found->take.mount.position_in_world - Eigen::Vector3d(-p.x(), -p.y(), p.z())).norm(),
            0.2);
}

TEST(CloseupSurvey, RefusesNoFramesAndBadOptions) {
  const auto pitch = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  EXPECT_FALSE(survey_closeup({}, pitch, Side::kMain, {}));
  CloseupSurveyOptions options;
  options.pictures = 1;
  EXPECT_FALSE(options.validate());
  options = {};
  EXPECT_TRUE(options.validate());
}

}  // namespace
}  // namespace touchline::calibrate
