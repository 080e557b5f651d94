#include "shared/recording/camera_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/support/folders.h"

namespace touchline::recording {
namespace {

using testing::HasSubstr;

constexpr std::string_view kHeader = "frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty,tz";

std::vector<CameraRow> random_rows(bool with_report) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<CameraRow> rows;
  for (int i = 0; i < 200; ++i) {
    CameraRow row;
    row.frame = i;
    row.model.fx = 3000 + 2000 * unit(random);
    row.model.fy = row.model.fx;
    row.model.cx = 959.5 + 10 * unit(random);
    row.model.cy = 539.5 + 10 * unit(random);
    row.model.k1 = 0.05 * unit(random);
    row.model.k2 = 1e-7 * unit(random);
    row.cam_from_world.rotation =
        Eigen::Quaterniond(unit(random), unit(random), unit(random), unit(random)).normalized();
    row.cam_from_world.translation = {100 * unit(random), 1e-12 * unit(random), 80 * unit(random)};
    if (with_report) {
      row.report = CameraRowReport{static_cast<geometry::Evidence>(i % 5), std::abs(unit(random)),
                                   std::abs(unit(random)), 1e-9, std::abs(unit(random))};
    }
    rows.push_back(row);
  }
  return rows;
}

void expect_same(const CameraRow& a, const CameraRow& b) {
  EXPECT_EQ(a.frame, b.frame);
  EXPECT_EQ(a.model.fx, b.model.fx);
  EXPECT_EQ(a.model.fy, b.model.fy);
  EXPECT_EQ(a.model.cx, b.model.cx);
  EXPECT_EQ(a.model.cy, b.model.cy);
  EXPECT_EQ(a.model.k1, b.model.k1);
  EXPECT_EQ(a.model.k2, b.model.k2);
  EXPECT_EQ(a.cam_from_world.rotation.coeffs(), b.cam_from_world.rotation.coeffs());
  EXPECT_EQ(a.cam_from_world.translation, b.cam_from_world.translation);
  EXPECT_EQ(a.report, b.report);
}

TEST(CameraTable, ReadsWhatItWritesToTheLastBit) {
  for (const bool with_report : {false, true}) {
    const auto rows = random_rows(with_report);
    const auto read = parse_camera_table(camera_table_text(rows), "cameras.csv");
    ASSERT_TRUE(read) << base::to_string(read.error());
    ASSERT_EQ(read->size(), rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) expect_same((*read)[i], rows[i]);
  }
}

TEST(CameraTable, WritesAndReadsAFile) {
  const support::TempFolder folder;
  const auto rows = random_rows(true);
  ASSERT_TRUE(write_camera_table(folder / "m1.csv", rows));
  const auto read = read_camera_table(folder / "m1.csv");
  ASSERT_TRUE(read) << base::to_string(read.error());
  ASSERT_EQ(read->size(), rows.size());
  expect_same(read->back(), rows.back());
  EXPECT_FALSE(std::filesystem::exists(folder / "m1.csv.part"));
}

TEST(CameraTable, HeaderIsThatOfTheFormat) {
  EXPECT_EQ(camera_table_text({}), std::string(kHeader) + "\n");
  const auto rows = random_rows(true);
  EXPECT_THAT(camera_table_text(rows),
              testing::StartsWith(std::string(kHeader) +
                                  ",state,rms_px,sd_pan_deg,sd_tilt_deg,sd_focal_rel\n0,"));
}

TEST(CameraTable, ColumnsAreFoundByName) {
  const auto rows = parse_camera_table(
      "tz,ty,tx,qz,qy,qx,qw,k2,k1,cy,cx,fy,fx,frame\r\n3,2,1,0,0,0,1,0.2,0.1,5,6,8,7,4\r\n", "t");
  ASSERT_TRUE(rows) << base::to_string(rows.error());
  ASSERT_EQ(rows->size(), 1U);
  EXPECT_EQ((*rows)[0].frame, 4);
  EXPECT_EQ((*rows)[0].model.fx, 7);
  EXPECT_EQ((*rows)[0].cam_from_world.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ((*rows)[0].model.width, 13);
  EXPECT_EQ((*rows)[0].model.height, 11);
  EXPECT_FALSE((*rows)[0].report);
}

TEST(CameraTable, FramesMayRepeatAndGoBack) {
  const std::string line = ",1000,1000,959.5,539.5,0,0,1,0,0,0,0,0,0\n";
  const auto rows =
      parse_camera_table(std::string(kHeader) + "\n12" + line + "12" + line + "3" + line, "t");
  ASSERT_TRUE(rows);
  EXPECT_EQ((*rows)[1].frame, 12);
  EXPECT_EQ((*rows)[2].frame, 3);
}

TEST(CameraTable, RoundedQuaternionsComeOutWithUnitLength) {
  const auto rows = parse_camera_table(
      std::string(kHeader) + "\n0,1000,1000,959.5,539.5,0,0,0.6020,0.7697,-0.1677,0.1305,0,0,0\n",
      "t");
  ASSERT_TRUE(rows);
  EXPECT_NEAR((*rows)[0].cam_from_world.rotation.norm(), 1, 1e-15);
}

TEST(CameraTable, LostRowsNeedNoCamera) {
  geometry::CameraEstimate lost;
  const std::vector<CameraRow> rows = {camera_row(5, lost)};
  const auto read = parse_camera_table(camera_table_text(rows), "t");
  ASSERT_TRUE(read) << base::to_string(read.error());
  ASSERT_TRUE((*read)[0].report);
  EXPECT_EQ((*read)[0].report->state, geometry::Evidence::kLost);
}

TEST(CameraTable, RowOfAnEstimateHasItsDeviations) {
  geometry::CameraEstimate estimate;
  estimate.evidence = geometry::Evidence::kLines;
  estimate.rms_px = 0.4;
  estimate.covariance(0, 0) = 1e-8;
  estimate.covariance(1, 1) = 4e-8;
  estimate.covariance(3, 3) = 1e-6;
  const CameraRow row = camera_row(7, estimate);
  ASSERT_TRUE(row.report);
  EXPECT_EQ(row.frame, 7);
  EXPECT_EQ(row.report->rms_px, 0.4);
  EXPECT_NEAR(row.report->sd_pan_deg, 1e-4 * 180 / M_PI, 1e-12);
  EXPECT_NEAR(row.report->sd_tilt_deg, 2e-4 * 180 / M_PI, 1e-12);
  EXPECT_NEAR(row.report->sd_focal_rel, 1e-3, 1e-12);
}

struct Defect {
  const char* name;
  const char* text;
  const char* where;
  const char* said;
};

class CameraTableDefect : public testing::TestWithParam<Defect> {};

TEST_P(CameraTableDefect, IsNamedWithItsLine) {
  const auto rows = parse_camera_table(GetParam().text, "t.csv");
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, base::ErrorKind::kFormat);
  EXPECT_EQ(rows.error().where, GetParam().where);
  EXPECT_THAT(rows.error().what, HasSubstr(GetParam().said));
}

#define HEADER "frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty,tz"
INSTANTIATE_TEST_SUITE_P(
    All, CameraTableDefect,
    testing::Values(
        Defect{"empty", "", "t.csv:1", "empty"},
        Defect{"column_missing", "frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty\n", "t.csv:1",
               "column 'tz' is missing"},
        Defect{"column_unknown", HEADER ",pan\n", "t.csv:1", "column 'pan' is not known"},
        Defect{"column_twice", HEADER ",fx\n", "t.csv:1", "column 'fx' stands twice"},
        Defect{"export_columns_cut", HEADER ",state,rms_px\n", "t.csv:1", "export"},
        Defect{"line_short", HEADER "\n0,1,1,1,1,0,0,1,0,0,0,0,0,0\n\n1,1,1\n", "t.csv:4",
               "has 3 fields, not 14"},
        Defect{"frame_real", HEADER "\n0.5,1,1,1,1,0,0,1,0,0,0,0,0,0\n", "t.csv:2", "frame '0.5'"},
        Defect{"not_a_number", HEADER "\n0,1,1,1,1,0,zero,1,0,0,0,0,0,0\n", "t.csv:2", "k2 'zero'"},
        Defect{"nan", HEADER "\n0,1,1,1,1,0,0,1,0,0,0,nan,0,0\n", "t.csv:2", "tx 'nan'"},
        Defect{"trailing_text", HEADER "\n0,1,1,1,1,0,0,1,0,0,0,0,0,0m\n", "t.csv:2", "tz '0m'"},
        Defect{"focal_zero", HEADER "\n0,0,0,1,1,0,0,1,0,0,0,0,0,0\n", "t.csv:2", "above 0"},
        Defect{"quaternion_long", HEADER "\n0,1,1,1,1,0,0,2,0,0,0,0,0,0\n", "t.csv:2", "length 2"},
        Defect{"state_unknown",
               HEADER ",state,rms_px,sd_pan_deg,sd_tilt_deg,sd_focal_rel\n"
                      "0,1,1,1,1,0,0,1,0,0,0,0,0,0,fine,0,0,0,0\n",
               "t.csv:2", "state 'fine'"}),
    [](const auto& test) { return std::string(test.param.name); });
#undef HEADER

TEST(CameraTable, FileThatIsNotThereIsNamed) {
  const auto rows = read_camera_table("/nowhere/cameras.csv");
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, base::ErrorKind::kNotFound);
  EXPECT_EQ(rows.error().where, "/nowhere/cameras.csv");
}

}  // namespace
}  // namespace touchline::recording
