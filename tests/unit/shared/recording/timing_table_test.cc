#include "shared/recording/timing_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/folders.h"

namespace touchline::recording {
namespace {

using testing::HasSubstr;

TEST(TimingTable, ReadsWhatItWrites) {
  const std::vector<TimingRow> rows = {
      {0, {1'700'000'000'000'000'000}, base::Timecode{10, 0, 0, 0, false}},
      {1, {1'700'000'000'040'000'001}, std::nullopt},
      {5, {1'700'000'000'040'000'001}, base::Timecode{23, 59, 59, 29, true}}};
  const auto read = parse_timing_table(timing_table_text(rows), "timing.csv");
  ASSERT_TRUE(read) << base::to_string(read.error());
  EXPECT_EQ(*read, rows);
}

TEST(TimingTable, TimecodeColumnMayBeMissing) {
  const auto read = parse_timing_table("frame,media_time_ns\n0,-5\n", "timing.csv");
  ASSERT_TRUE(read);
  EXPECT_THAT(*read, testing::ElementsAre(TimingRow{0, {-5}, std::nullopt}));
}

struct Defect {
  const char* name;
  const char* text;
  const char* where;
  const char* said;
};

class TimingTableDefect : public testing::TestWithParam<Defect> {};

TEST_P(TimingTableDefect, IsNamedWithItsLine) {
  const auto rows = parse_timing_table(GetParam().text, "timing.csv");
  ASSERT_FALSE(rows);
  EXPECT_EQ(rows.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(rows.error().where, GetParam().where);
  EXPECT_THAT(rows.error().what, HasSubstr(GetParam().said));
}

INSTANTIATE_TEST_SUITE_P(
    All, TimingTableDefect,
    testing::Values(
        Defect{"empty", "", "timing.csv:1", "empty"},
        Defect{"header_other", "frame,time\n", "timing.csv:1", "header"},
        Defect{"fields_missing", "frame,media_time_ns,timecode\n0,0\n", "timing.csv:2", "2 fields"},
        Defect{"frame_negative", "frame,media_time_ns\n-1,0\n", "timing.csv:2", "frame '-1'"},
        Defect{"time_real", "frame,media_time_ns\n0,0.5\n", "timing.csv:2", "media_time_ns '0.5'"},
        Defect{"time_too_large", "frame,media_time_ns\n0,99999999999999999999\n", "timing.csv:2",
               "media_time_ns"},
        Defect{"timecode_bad", "frame,media_time_ns,timecode\n0,0,x\n", "timing.csv:2", "'x'"},
        Defect{"frame_repeats", "frame,media_time_ns\n0,0\n0,1\n", "timing.csv:3", "after 0"},
        Defect{"time_falls", "frame,media_time_ns\n0,9\n1,8\n", "timing.csv:3", "before 9"}),
    [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace touchline::recording
