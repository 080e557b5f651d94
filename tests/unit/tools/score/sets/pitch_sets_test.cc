// The sets of clicked lines and keypoints, on small made-up ones whose cameras are known.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "shared/pitch/pitch_model.h"
#include "tests/support/folders.h"
#include "tests/unit/tools/score/sets/set_cameras.h"
#include "tools/score/sets/pitch_keypoints.h"
#include "tools/score/sets/pitch_lines.h"

namespace touchline::score {
namespace {

double cell(const SetRow& row, const std::string& name) {
  for (const SetCell& c : row.cells)
    if (c.name == name) return c.value;
  ADD_FAILURE() << row.label << " has no " << name;
  return 0;
}

// A frame's clicks on straight lines, JSON; four to a line inside the picture.
std::string clicked(const geometry::CameraEstimate& camera) {
  const pitch::PitchModel model = *pitch::make_pitch(pitch::Sport::kSoccer, {});
  const std::vector<std::pair<const char*, pitch::MarkingId>> lines{
      {"Side line top", pitch::MarkingId::kFarTouchline},
      {"Side line right", pitch::MarkingId::kRightGoalLine},
      {"Big rect. right main", pitch::MarkingId::kRightPenaltyFront},
      {"Big rect. right top", pitch::MarkingId::kRightPenaltyFar},
      {"Big rect. right bottom", pitch::MarkingId::kRightPenaltyNear},
      {"Small rect. right main", pitch::MarkingId::kRightGoalAreaFront},
      {"Circle right", pitch::MarkingId::kRightPenaltyArc}};
  std::string text;
  for (const auto& [name, id] : lines) {
    const pitch::Marking& marking = *model.find(id);
    std::string points;
    for (int k = 0; k <= 40; ++k) {
      const auto pixel = project(camera, model.on_turf(marking.at(marking.length() * k / 40)));
      if (!pixel || !camera.model.sees(*pixel) || pixel->minCoeff() < 0) continue;
      points += fmt::format("{}{{\"x\": {}, \"y\": {}}}", points.empty() ? "" : ", ",
                            pixel->x() / 959, pixel->y() / 539);
    }
    if (!points.empty())
      text += fmt::format("{}\"{}\": [{}]", text.empty() ? "" : ", ", name, points);
  }
  return "{" + text + "}";
}

TEST(PitchLines, PublishedFrameIsTurnedAndOursIsFound) {
  const support::TempFolder folder;
  std::filesystem::create_directories(folder.path() / "pitch-lines");
  std::ofstream lines(folder.path() / "pitch-lines" / "broadcast_lines_gt.json");
  std::ofstream cameras(folder.path() / "pitch-lines" / "broadcast_cameras_pnlcalib.json");
  const auto camera = main_camera(38, 4, 1500);
  const Eigen::Matrix3d r = camera.cam_from_world.rotation.toRotationMatrix();
  const Eigen::Vector3d p = position_in_world(camera);
  lines << "{\"1\": " << clicked(camera) << ", \"2\": " << clicked(camera) << "}";
  cameras << fmt::format(
      "{{\"1\": {{\"x_focal_length\": 1500, \"y_focal_length\": 1500, \"principal_point\": [479.5, "
      "269.5], \"position_meters\": [{}, {}, {}], \"rotation_matrix\": [[{}, {}, {}], [{}, {}, "
      "{}], [{}, {}, {}]]}}}}",
      p.x(), -p.y(), -p.z(), r(0, 0), -r(0, 1), -r(0, 2), r(1, 0), -r(1, 1), -r(1, 2), r(2, 0),
      -r(2, 1), -r(2, 2));
  lines.close();
  cameras.close();
  SetOptions options;
  options.data = folder.path();
  options.pictures = folder.path() / "pictures";
  const auto report = run_pitch_lines(options);
  ASSERT_TRUE(report) << base::to_string(report.error());
  ASSERT_EQ(report->rows.size(), 3U);
  EXPECT_EQ(cell(report->rows[0], "solved"), 100);
  EXPECT_LT(cell(report->rows[0], "median"), 0.3);
  EXPECT_LT(cell(report->rows[1], "median"), 0.3);
  EXPECT_EQ(cell(report->rows[2], "solved"), 50);
  EXPECT_LT(cell(report->rows[2], "95th"), 0.15);
  EXPECT_FALSE(std::filesystem::is_empty(options.pictures));
}

TEST(PitchKeypoints, OnePositionIsFoundOverManyViews) {
  const support::TempFolder folder;
  const auto labels = folder.path() / "pitch-keypoints" / "labels";
  std::filesystem::create_directories(labels);
  // The left and right ends' points in the labels' order; lines' middles.
  const double c = std::sqrt(9.09 * 9.09 - 5.44 * 5.44);
  std::vector<Eigen::Vector2d> points{
      {-52.44, 33.94},  {-52.44, 20.1}, {-52.44, 9.1},  {-52.44, -9.1}, {-52.44, -20.1},
      {-52.44, -33.94}, {-47.06, 9.1},  {-47.06, -9.1}, {-41.5, 0},     {-36.06, 20.1},
      {-36.06, c},      {-36.06, -c},   {-36.06, -20.1}};
  for (const double y : {33.94, 9.09, -9.09, -33.94}) points.emplace_back(0, y);
  for (const std::size_t i : {9U, 10U, 11U, 12U, 8U, 6U, 7U, 0U, 1U, 2U, 3U, 4U, 5U})
    points.emplace_back(-points[i].x(), points[i].y());
  points.emplace_back(-9.09, 0);
  points.emplace_back(9.09, 0);
  for (int view = 0; view < 9; ++view) {
    const auto camera = main_camera(-32 + 8 * view, 2, 700);
    std::ofstream out(labels / fmt::format("train_game_{}_1.txt", view));
    out << "0 0.5 0.5 1 1";
    for (const Eigen::Vector2d& point : points) {
      const auto pixel = project(camera, {point.x(), point.y(), 0});
      if (pixel && camera.model.sees(*pixel)) {
        out << fmt::format(" {} {} 2", (pixel->x() + 0.5) / 960, (pixel->y() + 0.5) / 540);
      } else {
        out << " 0 0 0";
      }
    }
  }
  SetOptions options;
  options.data = folder.path();
  const auto report = run_pitch_keypoints(options);
  ASSERT_TRUE(report) << base::to_string(report.error());
  ASSERT_EQ(report->rows.size(), 2U);
  const SetRow& common = report->rows[1];
  EXPECT_LT(cell(common, "95th"), 0.5);
  EXPECT_LT(cell(common, "scatter"), 0.05);
  EXPECT_NEAR(cell(common, "x"), 3, 0.1);
  EXPECT_NEAR(cell(common, "y"), -72, 0.2);
  EXPECT_NEAR(cell(common, "z"), 17, 0.1);
}

TEST(PitchSets, AbsentDataIsNamed) {
  const support::TempFolder folder;
  SetOptions options;
  options.data = folder.path();
  for (const auto& report : {run_pitch_lines(options), run_pitch_keypoints(options)}) {
    ASSERT_FALSE(report);
    EXPECT_EQ(report.error().kind, base::ErrorKind::kNotFound);
    EXPECT_NE(report.error().where.find(folder.path().string()), std::string::npos);
  }
}

}  // namespace
}  // namespace touchline::score
