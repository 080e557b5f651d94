// A camera fitted to clicks is the camera that they were made with.
#include "tools/score/sets/clicked_camera.h"

#include <gtest/gtest.h>

#include "tests/unit/tools/score/sets/set_cameras.h"

namespace touchline::score {
namespace {

const pitch::PitchModel& soccer() {
  static const pitch::PitchModel kPitch = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  return kPitch;
}

std::vector<ClickTarget> all_lines() {
  std::vector<ClickTarget> targets;
  for (const pitch::Marking& marking : soccer().markings)
    if (marking.shape != pitch::MarkingShape::kSpot)
      targets.push_back(target_of(soccer(), marking, 1.0));
  return targets;
}

// Every `step`-th vertex of what the camera sees.
std::vector<Click> clicks_of(const geometry::CameraEstimate& camera,
                             const std::vector<ClickTarget>& targets, std::size_t first,
                             std::size_t step) {
  std::vector<Click> clicks;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    for (std::size_t k = first; k < targets[i].vertices.size(); k += step) {
      const auto pixel = project(camera, targets[i].vertices[k]);
      if (pixel && camera.model.sees(*pixel)) clicks.push_back({i, *pixel});
    }
  }
  return clicks;
}

TEST(ClickedCamera, IsFoundFromNoStart) {
  const auto targets = all_lines();
  for (const double x : {-40.0, 0.0, 44.0}) {
    const geometry::CameraEstimate truth = main_camera(x, 5, 1500);
    const auto found = fit_clicks(targets, clicks_of(truth, targets, 0, 8), soccer(), {});
    ASSERT_TRUE(found) << x;
    for (const Click& held : clicks_of(truth, targets, 4, 8)) {
      const auto distance = click_distance(*found, targets[held.target], held.pixel);
      ASSERT_TRUE(distance);
      EXPECT_LT(*distance, 1.0) << targets[held.target].name << " at " << x;
    }
  }
}

TEST(ClickedCamera, NeedsFiveClicks) {
  const auto targets = all_lines();
  auto clicks = clicks_of(main_camera(40, 0, 1500), targets, 0, 8);
  clicks.resize(4);
  EXPECT_FALSE(fit_clicks(targets, clicks, soccer(), {}));
}

TEST(ClickedCamera, OwnClicksLieOnItsLines) {
  const auto targets = all_lines();
  const geometry::CameraEstimate camera = main_camera(40, 0, 1500);
  const auto clicks = clicks_of(camera, targets, 0, 1);
  for (const Click& click : clicks)
    EXPECT_NEAR(click_distance(camera, targets[click.target], click.pixel).value_or(99), 0, 1e-6);
  EXPECT_EQ(jaccard(camera, targets, clicks, {}, 5), 1);
  EXPECT_EQ(jaccard(std::nullopt, targets, clicks, {}, 5), 0);
}

TEST(ClickedCamera, JaccardFallsWithTheShift) {
  const auto targets = all_lines();
  const geometry::CameraEstimate camera = main_camera(40, 0, 1500);
  const auto clicks = clicks_of(camera, targets, 0, 1);
  geometry::CameraEstimate off = camera;
  off.model.cx += 9;
  off.model.cy += 9;
  EXPECT_LT(jaccard(off, targets, clicks, {}, 5), 0.2);
  EXPECT_EQ(jaccard(off, targets, clicks, {}, 20), 1);
}

TEST(ClickedCamera, TargetsClickedElsewhereAreLeftOut) {
  const auto targets = all_lines();
  const geometry::CameraEstimate camera = main_camera(40, 0, 1500);
  auto clicks = clicks_of(camera, targets, 0, 1);
  const std::size_t first = clicks.front().target;
  std::vector<Click> without, others;
  for (const Click& click : clicks) (click.target == first ? others : without).push_back(click);
  EXPECT_LT(jaccard(camera, targets, without, {}, 5), 1);
  EXPECT_EQ(jaccard(camera, targets, without, others, 5), 1);
}

}  // namespace
}  // namespace touchline::score
