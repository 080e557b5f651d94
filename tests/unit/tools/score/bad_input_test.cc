// What is damaged is refused with a file and a cure, never scored and never fatal.
#include <gtest/gtest.h>

#include <string>

#include "tests/unit/tools/score/true_exports.h"
#include "tools/score/csv.h"
#include "tools/score/people_score.h"

namespace touchline::score {
namespace {

TEST(CsvTable, NamesFileLineAndColumn) {
  const auto table = CsvTable::parse("frame,x\n0,1\n\n2,nan\n3.5,2\n", "t.csv");
  ASSERT_TRUE(table) << to_string(table.error());
  ASSERT_EQ(table->rows(), 3U);
  EXPECT_EQ(table->number(0, 1), 1);
  EXPECT_EQ(table->number(1, 1).error().where, "t.csv:4");
  EXPECT_EQ(table->frame(1, 0), 2);
  EXPECT_FALSE(table->frame(2, 0));
  EXPECT_FALSE(table->column("y"));
  EXPECT_FALSE(table->column("y").error().cure.empty());
  EXPECT_EQ(CsvTable::parse("a,b\n1\n", "t.csv").error().where, "t.csv:2");
  EXPECT_FALSE(CsvTable::parse("", "t.csv"));
}

TEST(BadInput, AMissingColumnIsNamed) {
  const TrueExports exports;
  std::filesystem::create_directories(exports.folder() / "people");
  support::write_text(exports.folder() / "people/people.csv", "frame,id,team,x,y,z\n0,a,A,1,2,3\n");
  const auto report = exports.score();
  ASSERT_FALSE(report);
  EXPECT_NE(to_string(report.error()).find("'role'"), std::string::npos);
  EXPECT_FALSE(report.error().cure.empty());
}

void cut(const std::filesystem::path& from, const std::filesystem::path& to, double share) {
  std::filesystem::create_directories(to.parent_path());
  const std::string bytes = support::read_text(from);
  const auto size = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
  support::write_text(to, std::string_view(bytes).substr(0, size));
}

TEST(BadInput, ATruncatedPictureIsNamed) {
  for (const double share : {0.0, 0.001, 0.5, 0.97}) {
    const TrueExports exports;
    cut(exports.truth().root() / "m1/matte/000003.png", exports.folder() / "mattes/m1/000003.png",
        share);
    const auto report = exports.score();
    ASSERT_FALSE(report) << share;
    EXPECT_NE(report.error().where.find("mattes/m1/000003.png"), std::string::npos);
    EXPECT_FALSE(report.error().cure.empty());
  }
}

TEST(BadInput, APictureOfAnotherSizeIsNamed) {
  const TrueExports exports;
  std::filesystem::create_directories(exports.folder() / "mattes/m1");
  std::filesystem::copy(exports.truth().root() / "virtual01/matte/000000.png",
                        exports.folder() / "mattes/m1/000000.png");
  const auto report = exports.score();
  ASSERT_FALSE(report);
  EXPECT_NE(to_string(report.error()).find("1280 x 720"), std::string::npos);
}

TEST(BadInput, ATruncatedMeshIsNamed) {
  const TrueExports exports;
  cut(exports.truth().root() / "mesh/000000.ply", exports.folder() / "hull/000000.ply", 0.7);
  const auto report = exports.score();
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, base::ErrorKind::kTruncated);
  EXPECT_NE(report.error().where.find("hull/000000.ply"), std::string::npos);
}

TEST(BadInput, AForegroundWithoutAlphaIsNamed) {
  const TrueExports exports;
  for (const char* folder : {"renders", "foreground"}) {
    const auto to = exports.folder() / folder / "virtual01";
    std::filesystem::create_directories(to);
    std::filesystem::copy(exports.truth().root() / "virtual01/clean/000000.png", to / "000000.png");
  }
  const auto report = exports.score();
  ASSERT_FALSE(report);
  EXPECT_NE(to_string(report.error()).find("--foreground"), std::string::npos);
}

TEST(ParsePly, RefusesOtherElementsAndWildVertices) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\n";
  EXPECT_TRUE(parse_ply(head + "end_header\n1 2 3\n", "a.ply"));
  EXPECT_EQ(parse_ply(head + "element edge 1\nend_header\n1 2 3\n", "a.ply").error().kind,
            base::ErrorKind::kUnsupported);
  EXPECT_FALSE(parse_ply(head + "end_header\n1 2 3e9\n", "a.ply"));
  EXPECT_FALSE(parse_ply(head, "a.ply"));
}

}  // namespace
}  // namespace touchline::score
