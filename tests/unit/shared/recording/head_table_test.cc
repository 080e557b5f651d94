#include "shared/recording/head_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace touchline::recording {
namespace {

TEST(HeadTable, WhatIsWrittenIsReadTheSame) {
  const std::vector<HeadRow> rows{{0, 814233, -5, 900, 1200}, {2, 814240, -9, 901, 1200}};
  const auto read = parse_head_table(head_table_text(rows), "head.csv");
  ASSERT_TRUE(read.has_value()) << base::to_string(read.error());
  EXPECT_EQ(*read, rows);
}

TEST(HeadTable, WhatIsWrongIsNamedWithItsLine) {
  const std::string header = "frame,pan_counts,tilt_counts,zoom_counts,focus_counts\n";
  for (const auto& [text, where, what] :
       {std::tuple{std::string(), "head.csv:1", "empty"},
        std::tuple{std::string("frame,pan\n"), "head.csv:1", "header"},
        std::tuple{header + "0,1,2,3\n", "head.csv:2", "4 fields"},
        std::tuple{header + "0,1,2,3,4\n0,1,2,3,4\n", "head.csv:3", "does not come after"},
        std::tuple{header + "0,1,2.5,3,4\n", "head.csv:2", "tilt_counts '2.5'"},
        std::tuple{header + "-1,1,2,3,4\n", "head.csv:2", "frame '-1'"},
        std::tuple{header + "0,999999999999999999,2,3,4\n", "head.csv:2", "pan_counts"}}) {
    const auto read = parse_head_table(text, "head.csv");
    ASSERT_FALSE(read.has_value()) << text;
    EXPECT_EQ(read.error().where, where);
    EXPECT_THAT(read.error().what, testing::HasSubstr(what));
  }
}

}  // namespace
}  // namespace touchline::recording
