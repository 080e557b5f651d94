#include "hub/output/people_csv.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

#include "tests/support/folders.h"

namespace touchline::output {
namespace {

TEST(PeopleCsv, HasTheColumnsOfTheFormat) {
  const support::TempFolder folder;
  PeopleRow row;
  row.frame = 12;
  row.person.id = std::string("p07");
  row.person.team = std::string("A");
  row.person.position_in_world = {-3.25, 10.0004, -0.0125};
  row.person.sd_x_m = 0.05;
  row.person.sd_y_m = 0.0715;
  ASSERT_TRUE(write_people_csv(folder / "people.csv", std::array{row}));
  std::ifstream file(folder / "people.csv");
  std::string header, line, more;
  std::getline(file, header);
  std::getline(file, line);
  EXPECT_EQ(header, "frame,id,team,role,x,y,z,sd_x,sd_y");
  EXPECT_EQ(line, "12,p07,A,,-3.250,10.000,-0.013,0.050,0.071");
  EXPECT_FALSE(std::getline(file, more));
}

TEST(PeopleCsv, FieldsThatWouldBreakTheTableAreRefused) {
  const support::TempFolder folder;
  PeopleRow row;
  row.person.id = std::string("p,1");
  EXPECT_FALSE(write_people_csv(folder / "people.csv", std::array{row}));
  EXPECT_FALSE(std::filesystem::exists(folder / "people.csv"));
}

}  // namespace
}  // namespace touchline::output
