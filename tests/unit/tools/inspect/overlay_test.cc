#include "tools/inspect/overlay.h"

#include <gtest/gtest.h>

namespace touchline::inspect {
namespace {

constexpr image::Rgb8 kGrey{100, 100, 100};

int changed(const Picture& a, const Picture& b, const image::Rect& where) {
  int count = 0;
  for (int y = where.y; y < where.y + where.height; ++y)
    for (int x = where.x; x < where.x + where.width; ++x) count += a(x, y) == b(x, y) ? 0 : 1;
  return count;
}

geometry::CameraEstimate above_the_centre_spot() {
  geometry::CameraEstimate camera;
  camera.model = {400, 300, 100, 100, 199.5, 149.5, 0, 0};
  camera.cam_from_world.rotation = Eigen::Quaterniond(0, 1, 0, 0);  // looks down, Y is up
  camera.cam_from_world.translation = {0, 0, 20};
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

TEST(LinesOverlay, DrawsTheMarkingsWhereTheCameraPutsThem) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  const Picture frame(400, 300, kGrey);
  const Picture out = lines_overlay(frame, above_the_centre_spot(), *pitch);
  EXPECT_FALSE(out(199, 250) == kGrey);  // halfway line
  EXPECT_EQ(out(120, 250), kGrey);       // turf
  // The centre circle, 9.15 m at 5 px a metre.
  EXPECT_GT(changed(frame, out, {243, 147, 5, 5}), 0);
}

TEST(LinesOverlay, ALostCameraHasItsLabelAlone) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  geometry::CameraEstimate lost = above_the_centre_spot();
  lost.evidence = geometry::Evidence::kLost;
  const Picture frame(400, 300, kGrey);
  const Picture out = lines_overlay(frame, lost, *pitch);
  EXPECT_GT(changed(frame, out, {0, 0, 400, 40}), 0);
  EXPECT_EQ(changed(frame, out, {0, 40, 400, 260}), 0);
}

TEST(KeyOverlay, PeopleKeepTheirColoursAndWhatIsUnknownIsTinted) {
  const image::Rgb8 red{200, 30, 30};
  const Picture frame(60, 40, red);
  image::Matte matte;
  matte.region = {0, 0, 60, 40};
  matte.alpha = image::Image<std::uint8_t>(60, 40, 0);
  matte.unknown = matte.alpha;
  matte.occluders = matte.alpha;
  for (int y = 10; y < 30; ++y)
    for (int x = 10; x < 25; ++x) matte.alpha(x, y) = 255;
  for (int y = 10; y < 30; ++y)
    for (int x = 30; x < 40; ++x) matte.unknown(x, y) = 255;
  for (int y = 10; y < 30; ++y)
    for (int x = 45; x < 55; ++x) matte.occluders(x, y) = matte.unknown(x, y) = 255;
  const Picture out = key_overlay(frame, matte);
  EXPECT_EQ(out(17, 20), red);
  EXPECT_FALSE(out(5, 20) == red);
  EXPECT_GT(out(35, 20).b, out(5, 20).b);   // unknown: blue
  EXPECT_GT(out(50, 20).g, out(35, 20).g);  // an occluder: yellow, not blue
  EXPECT_LT(out(50, 20).b, out(35, 20).b);
}

TEST(SitePlan, HoldsEveryHeadAndThePitch) {
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  std::vector<PlacedHead> heads(2);
  heads[0].camera = base::CameraId{"m1"};
  heads[0].survey.mount.position_in_world = {0, -75, 20};
  heads[1].camera = base::CameraId{"m2"};
  heads[1].survey.mount.position_in_world = {90, 0, 12};
  const Picture plan = site_plan(heads, *pitch);
  EXPECT_EQ(plan.width(), 2 * (90 + 12) * 10);
  EXPECT_EQ(plan.height(), 2 * (75 + 12) * 10);
  // The main camera side is below.
  EXPECT_EQ(plan(plan.width() / 2, plan.height() - 12 * 10), draw::kFound);
}

}  // namespace
}  // namespace touchline::inspect
