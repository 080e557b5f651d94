#include "edge/calibrate/initialise/hough_initialiser.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

pitch::PitchModel soccer(double length = 105, double width = 68) {
  return *pitch::make_pitch(pitch::Sport::kSoccer, {length, width, {}, 0.3, {}});
}

// Every pose that is found is the right one; most are found.
TEST(Initialiser, FindsRandomPosesAndNoWrongOnes) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const Initialiser initialiser(pitch, mount, {});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> pan(-38, 38), tilt(-17, -10), zoom(0, 1);
  constexpr int kPoses = 16;
  int found = 0;
  for (int i = 0; i < kPoses; ++i) {
    const geometry::CameraEstimate truth =
        camera_at(mount, pan(random), tilt(random), 1000 * std::pow(3.0, zoom(random)));
    const LineMap map = detect_lines(paint_pitch(pitch, truth, {6, 12, true, 11}), {});
    const auto estimate = initialiser.find(map);
    if (!estimate) continue;
    ++found;
    EXPECT_EQ(estimate->evidence, geometry::Evidence::kLines);
    EXPECT_LT(turf_rms_px(pitch, truth, *estimate), 4) << "pose " << i;
  }
  EXPECT_GE(found, kPoses * 3 / 4);
}

TEST(Initialiser, SaysNothingAboutTurfAlone) {
  const pitch::PitchModel pitch = soccer();
  const geometry::CameraEstimate camera = camera_at(test_mount(), 10, -14, 1400);
  const Initialiser initialiser(pitch, test_mount(), {});
  InitialiseReport report;
  EXPECT_FALSE(
      initialiser.find(detect_lines(paint_pitch(pitch, camera, {6, 10, false, 2}), {}), report));
  EXPECT_FALSE(report.stopped_because.empty());
  EXPECT_FALSE(initialiser.find(LineMap{}, report));
  EXPECT_EQ(report.stopped_because, "no turf");
}

// One long line fits a pitch in many places.
TEST(Initialiser, SaysNothingAboutASingleLine) {
  pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  pitch::PitchModel one_line = pitch;
  std::erase_if(one_line.markings, [](const pitch::Marking& marking) {
    return marking.id != pitch::MarkingId::kHalfwayLine;
  });
  const geometry::CameraEstimate camera = camera_at(mount, 2, -16, 2600);
  const LineMap map = detect_lines(paint_pitch(one_line, camera, {6, 0, true, 2}), {});
  EXPECT_FALSE(Initialiser(pitch, mount, {}).find(map));
}

TEST(Initialiser, DoesNotLockOntoAPitchOfAnotherSize) {
  const geometry::Mount mount = test_mount();
  const pitch::PitchModel stated = soccer(120, 90);
  const Initialiser initialiser(stated, mount, {});
  for (const double pan : {-30.0, 0.0, 28.0}) {
    const geometry::CameraEstimate truth = camera_at(mount, pan, -11, 1000);
    const LineMap map = detect_lines(paint_pitch(soccer(), truth, {6, 0, true, 4}), {});
    EXPECT_FALSE(initialiser.find(map)) << pan;
  }
}

TEST(Initialiser, FindsRugby) {
  const pitch::PitchModel pitch =
      *pitch::make_pitch(pitch::Sport::kRugbyUnion, {100, 70, 10, 0.2, {}});
  const geometry::Mount mount = test_mount();
  const Initialiser initialiser(pitch, mount, {});
  int found = 0;
  for (const double pan : {-30.0, -12.0, 3.0, 25.0}) {
    const geometry::CameraEstimate truth = camera_at(mount, pan, -12, 1300);
    const auto estimate =
        initialiser.find(detect_lines(paint_pitch(pitch, truth, {6, 0, true, 4}), {}));
    if (!estimate) continue;
    ++found;
    EXPECT_LT(turf_rms_px(pitch, truth, *estimate), 4) << pan;
  }
  EXPECT_GE(found, 2);
}

TEST(Initialiser, IsDeterministic) {
  const pitch::PitchModel pitch = soccer();
  const geometry::Mount mount = test_mount();
  const LineMap map =
      detect_lines(paint_pitch(pitch, camera_at(mount, 24, -12, 1300), {6, 12, true, 4}), {});
  const auto a = Initialiser(pitch, mount, {}).find(map);
  const auto b = Initialiser(pitch, mount, {}).find(map);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->model, b->model);
  EXPECT_EQ(a->cam_from_world.rotation.coeffs(), b->cam_from_world.rotation.coeffs());
}

TEST(InitialiseOptions, NamesTheFieldThatIsWrong) {
  InitialiseOptions options;
  EXPECT_TRUE(options.validate());
  options.focal_step = 0;
  const base::Status status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "focal_step");
}

}  // namespace
}  // namespace touchline::calibrate
