// The multi-view set on a made-up person of capsules.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "tests/support/capsule_scene.h"
#include "tests/support/folders.h"
#include "tools/draw/canvas.h"
#include "tools/score/sets/multiview_wd2_person.h"
#include "tools/score/sets/set_pictures.h"
#include "tools/score/sets/wd2_rig.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;

constexpr const char* kOne =
    "3\n900 -1.4 520\n0 899 384\n0 0 1\n-0.038 0.061\n1 0 0 2\n0 1 0 3\n0 0 1 4\n\n";

TEST(Wd2Calibration, ReadsEachCamera) {
  const auto read = parse_wd2_calibration(std::string(kOne) + "7" + (kOne + 1), "f");
  ASSERT_TRUE(read) << base::to_string(read.error());
  ASSERT_EQ(read->size(), 2U);
  const auto& camera = read->at(3);
  EXPECT_EQ(camera.model.fx, 900);
  EXPECT_EQ(camera.model.fy, 899);
  EXPECT_EQ(camera.model.cx, 520);
  EXPECT_EQ(camera.model.k2, 0.061);
  EXPECT_EQ(camera.cam_from_world.translation, Eigen::Vector3d(2, 3, 4));
}

TEST(Wd2Calibration, RefusesWhatIsNone) {
  EXPECT_FALSE(parse_wd2_calibration("", "f"));
  EXPECT_FALSE(parse_wd2_calibration("1\n2 3", "f"));
  EXPECT_FALSE(parse_wd2_calibration(std::string(kOne) + "word", "f"));
  std::string squashed = kOne;
  squashed.replace(squashed.find("1 0 0 2"), 7, "1 1 1 2");
  EXPECT_FALSE(parse_wd2_calibration(squashed, "f"));
  EXPECT_FALSE(read_wd2_calibration("no/such/file"));
}

// Six cameras round two capsules, in a world that is turned, moved and half as large.
class MadeUpPerson : public testing::Test {
 protected:
  void SetUp() override {
    const fs::path folder = data_ / "multiview-wd2-person";
    fs::create_directories(folder);
    const std::vector<support::Capsule> person = {{{0, 0, 0.3}, {0, 0, 1.35}, 0.3},
                                                  {{0, 0, 1}, {0.6, 0, 1.1}, 0.1}};
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(2.1, Eigen::Vector3d(1, 2, 3).normalized()));
    std::string calibration;
    for (int i = 0; i < 6; ++i) {
      const double angle = i * std::numbers::pi / 3;
      const auto camera = support::looking_at({5 * std::cos(angle), 5 * std::sin(angle), 2.5},
                                              {0, 0, 0.9}, 250, 256, 192);
      const codec::CameraView view = support::silhouettes("c", camera, person);
      const image::Image<std::uint8_t>& mask = view.matte->alpha;
      draw::Picture picture(256, 192, {30, 120, 40});
      for (std::size_t p = 0; p < mask.size(); ++p) {
        if (mask.data()[p] >= 128) picture.data()[p] = {200, 60, 70};
      }
      ASSERT_TRUE(write_rgb(folder / fmt::format("WD2_{}_00020.png", i), picture));
      ASSERT_TRUE(
          write_rgb(folder / fmt::format("WD2_{}_00020_mask.png", i), draw::from_grey(mask)));
      const auto& m = camera.model;
      const Eigen::Matrix3d r = (camera.cam_from_world.rotation * turn).toRotationMatrix();
      const Eigen::Vector3d t = 0.5 * camera.cam_from_world.translation;
      calibration += fmt::format("{}\n{} 0 {}\n0 {} {}\n0 0 1\n0 0\n", i, m.fx, m.cx, m.fy, m.cy);
      for (int row = 0; row < 3; ++row) {
        calibration += fmt::format("{:.12f} {:.12f} {:.12f} {:.12f}\n", r(row, 0), r(row, 1),
                                   r(row, 2), t[row]);
      }
    }
    support::write_text(folder / "calibParamsI.txt", calibration);
  }

  support::TempFolder data_;
};

TEST_F(MadeUpPerson, StandsInMetresOnItsFloor) {
  const auto rig = load_wd2_rig(data_ / "multiview-wd2-person", 1.65);
  ASSERT_TRUE(rig) << base::to_string(rig.error());
  ASSERT_EQ(rig->cameras.size(), 6U);
  EXPECT_NEAR(rig->metres_per_unit, 2, 0.1);
  EXPECT_NEAR(rig->camera_distance_m, 5, 0.25);
  for (const Wd2Camera& camera : rig->cameras) {
    EXPECT_NEAR(geometry::position_in_world(camera.estimate).z(), 2.5, 0.15);
  }
}

TEST_F(MadeUpPerson, IsScored) {
  SetOptions options;
  options.data = data_.path();
  options.pictures = data_ / "pictures";
  const auto report = run_multiview_wd2_person(options);
  ASSERT_TRUE(report) << base::to_string(report.error());
  ASSERT_EQ(report->rows.size(), 8U);
  for (const SetRow& row : report->rows) {
    for (const SetCell& cell : row.cells) EXPECT_EQ(cell.n, 6U) << row.label << cell.name;
  }
  // A hull that is not dilated is tighter than the product's, and close to the hull by rays.
  const double product = report->rows[0].cells[0].value;
  const double tight = report->rows[2].cells[0].value;
  const double rays = report->rows[3].cells[0].value;
  EXPECT_GT(tight, product);
  EXPECT_NEAR(tight, rays, 6);
  EXPECT_LT(report->rows[0].cells[2].value, 1);  // nothing is missing of the dilated one
}

TEST(MultiviewWd2, SaysWhatIsNotThere) {
  const support::TempFolder data;
  SetOptions options;
  options.data = data.path();
  const auto missing = run_multiview_wd2_person(options);
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().kind, base::ErrorKind::kNotFound);
}

}  // namespace
}  // namespace touchline::score
