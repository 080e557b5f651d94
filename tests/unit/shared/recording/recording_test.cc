#include "shared/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/folders.h"

namespace touchline::recording {
namespace {

using testing::HasSubstr;

// Line 1 is format_version; camera[0] begins at line 13, camera[1] at line 21.
const std::string kWhole = R"(format_version = 1
name = "cup \"final\""
sport = "soccer"
frame_rate = "25/1"
start_timecode = "10:00:00:00"
start_tai_ns = 1700000000000000000

[pitch]
length_m = 105.0
width_m = 68
crown_m = 0.3

[[camera]]
id = "m1"
role = "match"
side = "main"
video = "m1/video.mkv"
width = 1920
height = 1080
survey = "m1/survey"
[[camera]]
id = "f1"
role = "fixed"
side = "reverse"
video = "f1/video.mkv"
width = 1280
height = 720
frame_rate = "50/1"
scan = "tff"
offset_ns = -20000000
)";

std::string with(std::string_view from, std::string_view to) {
  std::string text = kWhole;
  const auto place = text.find(from);
  EXPECT_NE(place, std::string::npos) << from;
  return text.replace(place, from.size(), to);
}

TEST(Recording, GivesWhatTheFileSays) {
  const auto recording = parse_recording(kWhole, "/data/cup", "recording.toml");
  ASSERT_TRUE(recording) << base::to_string(recording.error());
  EXPECT_EQ(recording->name, "cup \"final\"");
  EXPECT_EQ(recording->sport, pitch::Sport::kSoccer);
  EXPECT_EQ(recording->rate, (base::FrameRate{25, 1}));
  EXPECT_EQ(recording->start_timecode, (base::Timecode{10, 0, 0, 0, false}));
  EXPECT_EQ(recording->start.ns, 1'700'000'000'000'000'000);
  EXPECT_EQ(recording->sizes.length_m, 105.0);
  EXPECT_EQ(recording->sizes.width_m, 68.0);
  EXPECT_EQ(recording->sizes.crown_m, 0.3);
  EXPECT_EQ(recording->sizes.line_m, std::nullopt);
  ASSERT_EQ(recording->cameras.size(), 2U);
  const CameraEntry& m1 = recording->cameras[0];
  EXPECT_EQ(m1.id.value, "m1");
  EXPECT_EQ(m1.role, Role::kMatch);
  EXPECT_EQ(m1.side, Side::kMain);
  EXPECT_EQ(m1.video, "/data/cup/m1/video.mkv");
  EXPECT_EQ(m1.survey, "/data/cup/m1/survey");
  EXPECT_EQ(m1.width, 1920);
  EXPECT_EQ(m1.height, 1080);
  EXPECT_EQ(m1.rate, recording->rate);
  EXPECT_EQ(m1.scan, image::Scan::kProgressive);
  const CameraEntry& f1 = recording->cameras[1];
  EXPECT_EQ(f1.role, Role::kFixed);
  EXPECT_EQ(f1.side, Side::kReverse);
  EXPECT_TRUE(f1.survey.empty());
  EXPECT_EQ(f1.rate, (base::FrameRate{50, 1}));
  EXPECT_EQ(f1.scan, image::Scan::kTopFirst);
  EXPECT_EQ(f1.offset_ns, -20'000'000);
  EXPECT_EQ(recording->find({"f1"}), &f1);
  EXPECT_EQ(recording->find({"x"}), nullptr);
}

TEST(Recording, ReadsWhatItWrites) {
  const auto first = parse_recording(kWhole, "/data/cup", "recording.toml");
  ASSERT_TRUE(first);
  const std::string text = recording_text(*first);
  const auto second = parse_recording(text, "/data/cup", "written");
  ASSERT_TRUE(second) << base::to_string(second.error()) << "\n" << text;
  EXPECT_EQ(recording_text(*second), text);
  EXPECT_EQ(second->name, first->name);
  EXPECT_EQ(second->cameras[1].offset_ns, first->cameras[1].offset_ns);
  EXPECT_EQ(second->cameras[0].survey, first->cameras[0].survey);
}

TEST(Recording, WrittenNamesKeepEveryCharacter) {
  auto recording = parse_recording(kWhole, "/data/cup", "recording.toml");
  ASSERT_TRUE(recording);
  recording->name = "a\"b\\c\td\ne é \x7f";
  const auto again = parse_recording(recording_text(*recording), "/data/cup", "written");
  ASSERT_TRUE(again) << base::to_string(again.error());
  EXPECT_EQ(again->name, recording->name);
}

TEST(Recording, OptionalKeysMayBeMissing) {
  const auto recording = parse_recording(R"(format_version = 1
name = "x"
sport = "rugby"
frame_rate = "30000/1001"
[[camera]]
id = "m1"
role = "closeup"
side = "left"
video = "m1.mp4"
width = 640
height = 480
)",
                                         "/data", "recording.toml");
  ASSERT_TRUE(recording) << base::to_string(recording.error());
  EXPECT_EQ(recording->sport, pitch::Sport::kRugbyUnion);
  EXPECT_EQ(recording->start.ns, 0);
  EXPECT_EQ(recording->sizes.length_m, std::nullopt);
}

struct Defect {
  const char* name;
  const char* from;
  const char* to;
  const char* where;
  const char* said;
};

class RecordingDefect : public testing::TestWithParam<Defect> {};

TEST_P(RecordingDefect, IsNamedWithItsLine) {
  const auto recording =
      parse_recording(with(GetParam().from, GetParam().to), "/data", "recording.toml");
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(recording.error().where, GetParam().where);
  EXPECT_THAT(recording.error().what + " (" + recording.error().cure + ")",
              HasSubstr(GetParam().said));
}

INSTANTIATE_TEST_SUITE_P(
    All, RecordingDefect,
    testing::Values(
        Defect{"version_2", "format_version = 1", "format_version = 2", "recording.toml:1",
               "format_version: 2 is not known (this version reads format 1)"},
        Defect{"version_missing", "format_version = 1", "", "recording.toml",
               "format_version: missing"},
        Defect{"name_missing", "name = \"cup \\\"final\\\"\"", "", "recording.toml",
               "name: missing"},
        Defect{"sport_unknown", "\"soccer\"", "\"hockey\"", "recording.toml:3",
               "sport: 'hockey' is not known (one of: soccer, rugby)"},
        Defect{"rate_not_a_rate", "\"25/1\"", "\"fast\"", "recording.toml:4", "frame_rate: 'fast'"},
        Defect{"rate_too_high", "\"25/1\"", "\"2500/1\"", "recording.toml:4", "1000"},
        Defect{"timecode_not_one", "\"10:00:00:00\"", "\"10h\"", "recording.toml:5",
               "start_timecode: '10h'"},
        Defect{"timecode_beyond_rate", "\"10:00:00:00\"", "\"10:00:00:25\"", "recording.toml:5",
               "no such frame at 25/1"},
        Defect{"timecode_drop_frame", "\"10:00:00:00\"", "\"10:00:00;00\"", "recording.toml:5",
               "drop-frame"},
        Defect{"start_not_whole", "1700000000000000000", "1.5", "recording.toml:6",
               "start_tai_ns: is a number, not an integer"},
        Defect{"pitch_too_long", "length_m = 105.0", "length_m = 1050", "recording.toml:9",
               "length_m"},
        Defect{"pitch_key_unknown", "crown_m = 0.3", "crown = 0.3", "recording.toml:11",
               "pitch.crown: unknown key"},
        Defect{"pitch_in_goal_of_soccer", "crown_m = 0.3", "in_goal_m = 10", "recording.toml:11",
               "in_goal_m"},
        Defect{"camera_key_unknown", "survey =", "surwey =", "recording.toml:20",
               "camera[0].surwey: unknown key"},
        Defect{"id_missing", "id = \"m1\"", "", "recording.toml:13", "camera[0].id: missing"},
        Defect{"id_bad", "id = \"m1\"", "id = \"m 1\"", "recording.toml:14",
               "camera[0].id: 'm 1' is not a camera id"},
        Defect{"id_duplicate", "id = \"f1\"", "id = \"m1\"", "recording.toml:22",
               "camera[1].id: 'm1' is already the id of camera[0]"},
        Defect{"role_unknown", "\"match\"", "\"main\"", "recording.toml:15",
               "camera[0].role: 'main' is not known (one of: match, fixed, closeup)"},
        Defect{"side_unknown", "\"reverse\"", "\"north\"", "recording.toml:24",
               "camera[1].side: 'north' is not known (one of: main, reverse, left, right)"},
        Defect{"video_missing", "video = \"m1/video.mkv\"", "", "recording.toml:13",
               "camera[0].video: missing"},
        Defect{"video_empty", "\"m1/video.mkv\"", "\"\"", "recording.toml:17",
               "camera[0].video: is not a path"},
        Defect{"width_negative", "width = 1920", "width = -1920", "recording.toml:18",
               "camera[0].width: -1920 is out of bounds"},
        Defect{"height_text", "height = 1080", "height = \"1080\"", "recording.toml:19",
               "camera[0].height: is a text, not an integer"},
        Defect{"scan_unknown", "\"tff\"", "\"interlaced\"", "recording.toml:29", "camera[1].scan"},
        Defect{"camera_rate_bad", "\"50/1\"", "\"50/0\"", "recording.toml:28",
               "camera[1].frame_rate"},
        Defect{"offset_an_hour", "-20000000", "3600000000000", "recording.toml:30",
               "camera[1].offset_ns"},
        Defect{"camera_is_table", "[[camera]]\nid = \"m1\"", "[other]\nid = \"m1\"",
               "recording.toml:13", "other: unknown key"},
        Defect{"syntax", "[pitch]", "[pitch", "recording.toml:8", "table"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(Recording, WithoutCamerasIsRefused) {
  const auto recording =
      parse_recording(kWhole.substr(0, kWhole.find("[[camera]]")), "/data", "recording.toml");
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().what, HasSubstr("there is no camera"));
}

class RecordingFolder : public testing::Test {
 protected:
  void SetUp() override {
    support::write_text(folder_ / "recording.toml", kWhole);
    support::write_text(folder_ / "m1/video.mkv", "x");
    support::write_text(folder_ / "f1/video.mkv", "x");
    support::write_text(folder_ / "m1/survey/00.jpg", "x");
  }
  support::TempFolder folder_;
};

TEST_F(RecordingFolder, IsLoadedWithAbsolutePaths) {
  support::write_text(folder_ / "f1/timing.csv", "frame,media_time_ns,timecode\n");
  support::write_text(folder_ / "m1/head.csv", "frame,pan_counts\n");
  for (const auto& given : {folder_.path(), folder_ / "recording.toml"}) {
    const auto recording = load_recording(given);
    ASSERT_TRUE(recording) << base::to_string(recording.error());
    EXPECT_EQ(recording->root, folder_.path());
    EXPECT_EQ(recording->cameras[0].video, folder_ / "m1/video.mkv");
    EXPECT_TRUE(recording->cameras[0].timing.empty());
    EXPECT_EQ(recording->cameras[0].head, folder_ / "m1/head.csv");
    EXPECT_EQ(recording->cameras[1].timing, folder_ / "f1/timing.csv");
  }
}

TEST_F(RecordingFolder, MissingVideoIsNamedWithLineAndCamera) {
  std::filesystem::remove(folder_ / "f1/video.mkv");
  const auto recording = load_recording(folder_.path());
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(recording.error().where, (folder_ / "recording.toml:25").string());
  EXPECT_THAT(recording.error().what, HasSubstr("f1/video.mkv"));
  EXPECT_THAT(recording.error().cure, HasSubstr("'f1'"));
}

TEST_F(RecordingFolder, MissingSurveyIsNamed) {
  std::filesystem::remove_all(folder_ / "m1/survey");
  const auto recording = load_recording(folder_.path());
  ASSERT_FALSE(recording);
  EXPECT_THAT(recording.error().what, HasSubstr("camera[0].survey"));
}

TEST_F(RecordingFolder, FolderWithoutRecordingIsNamed) {
  const auto recording = load_recording(folder_ / "m1");
  ASSERT_FALSE(recording);
  EXPECT_EQ(recording.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(recording.error().where, (folder_ / "m1").string());
}

TEST_F(RecordingFolder, IsSavedAsItWasLoaded) {
  const auto recording = load_recording(folder_.path());
  ASSERT_TRUE(recording);
  ASSERT_TRUE(save_recording(*recording));
  const auto again = load_recording(folder_.path());
  ASSERT_TRUE(again) << base::to_string(again.error());
  EXPECT_EQ(recording_text(*again), recording_text(*recording));
}

TEST_F(RecordingFolder, SavingWhereNobodyCanWriteIsAnError) {
  auto recording = load_recording(folder_.path());
  ASSERT_TRUE(recording);
  recording->root = folder_ / "not/there";
  const auto status = save_recording(*recording);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().kind, base::ErrorKind::kIo);
}

TEST_F(RecordingFolder, StillsComeByName) {
  for (const char* name : {"10.jpg", "02.JPG", "03.png", "notes.txt"}) {
    support::write_text(folder_ / "m1/survey" / name, "x");
  }
  const auto recording = load_recording(folder_.path());
  ASSERT_TRUE(recording);
  const auto stills = survey_stills(recording->cameras[0]);
  ASSERT_TRUE(stills);
  std::vector<std::string> names;
  for (const auto& still : *stills) names.push_back(still.filename().string());
  EXPECT_THAT(names, testing::ElementsAre("00.jpg", "02.JPG", "03.png", "10.jpg"));
  EXPECT_TRUE(survey_stills(recording->cameras[1])->empty());
}

}  // namespace
}  // namespace touchline::recording
