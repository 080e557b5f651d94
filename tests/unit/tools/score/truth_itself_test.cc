// What is true scores perfectly.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/tools/score/true_exports.h"

namespace touchline::score {
namespace {

TEST(TruthAgainstItself, IsPerfectInEveryScore) {
  const TrueExports exports;
  exports.write_cameras();
  for (const char* camera : {"m1", "f2"}) exports.write_mattes(camera);
  exports.write_hulls();
  exports.write_people();
  exports.write_views();
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());

  EXPECT_EQ(figure(*report, "cameras", "frames solved"), 100);
  EXPECT_LT(figure(*report, "cameras", "rms on a 1 m grid"), 1e-6);
  for (const char* score : {"JaC@5 at 960x540", "JaC@10 at 960x540", "JaC@20 at 960x540"}) {
    EXPECT_EQ(figure(*report, "cameras", score), 100) << score;
  }
  for (const char* score :
       {"pan noise", "pan error", "tilt error", "focal error", "position error",
        "pan error over stated sd", "tilt error over stated sd", "focal error over stated sd"}) {
    EXPECT_LT(figure(*report, "cameras", score), 1e-6) << score;
  }
  for (const char* score : {"frames with a matte", "boundary F at 1 px", "IoU at 0.5",
                            "limb recall", "limb recall by person"}) {
    EXPECT_EQ(figure(*report, "mattes", score), 100) << score;
  }
  for (const char* score : {"boundary distance", "missing", "extra", "alpha error",
                            "false foreground on turf", "missing by person"}) {
    EXPECT_EQ(figure(*report, "mattes", score), 0) << score;
  }
  // The hull of true mattes holds the true surfaces; of these meshes a few vertices lie inside
  // hair and clothes that no matte tells.
  EXPECT_GE(figure(*report, "hull", "inside, all vertices"), 99.95);
  EXPECT_GE(figure(*report, "hull", "inside, least person"), 99.5);
  EXPECT_GE(figure(*report, "hull", "inside by person"), 99.95);
  EXPECT_NEAR(figure(*report, "hull", "volume over true mattes' hull"), 1, 1e-6);
  EXPECT_EQ(figure(*report, "hull", "phantoms a frame"), 0);
  for (const char* score : {"found", "ball found"}) {
    EXPECT_EQ(figure(*report, "people", score), 100) << score;
  }
  for (const char* score :
       {"extra a frame", "position error", "error over stated sd", "id changes", "ball error"}) {
    EXPECT_EQ(figure(*report, "people", score), 0) << score;
  }
  for (const char* score :
       {"PSNR of people", "PSNR aligned", "PSNR, full picture", "PSNR by person"}) {
    EXPECT_EQ(figure(*report, "views", score), 99) << score;
  }
  for (const char* score : {"SSIM of people", "SSIM, full picture"}) {
    EXPECT_NEAR(figure(*report, "views", score), 1, 1e-6) << score;
  }
  for (const char* score : {"misalignment", "missing foreground", "phantom foreground",
                            "missing by person", "flicker"}) {
    EXPECT_EQ(figure(*report, "views", score), 0) << score;
  }
  for (const char* score : {"limb recall", "limb recall by person"}) {
    EXPECT_EQ(figure(*report, "views", score), 100) << score;
  }
  ASSERT_EQ(report->not_scored.size(), 5U);  // the other cameras' mattes
  EXPECT_EQ(report->not_scored[4], "oracle of the views: switched off");

  // Every series is in the JSON with its samples, and no figure is missing.
  const auto json = nlohmann::json::parse(json_text(*report));
  EXPECT_EQ(json.at("format_version"), 1);
  EXPECT_EQ(json.at("series").size(), report->series.size());
  for (const auto& series : json.at("series")) {
    EXPECT_TRUE(series.at("summary").at("figure").is_number());
    EXPECT_TRUE(series.at("better").is_string());
    EXPECT_TRUE(series.at("oracle").is_null());
  }
  EXPECT_NE(table_text(*report).find("JaC@5"), std::string::npos);
}

TEST(TruthAgainstItself, NamesWhatIsNotThere) {
  const TrueExports exports;
  const auto report = exports.score();
  ASSERT_TRUE(report) << to_string(report.error());
  EXPECT_TRUE(report->series.empty());
  // Six cameras, six mattes, hull, people, one view.
  EXPECT_EQ(report->not_scored.size(), 15U);
}

}  // namespace
}  // namespace touchline::score
