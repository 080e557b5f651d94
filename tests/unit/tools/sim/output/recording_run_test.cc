// Recordings of a match made of flat colours: files, tables, faults and endings, without a
// renderer.
#include "tools/sim/output/recording_run.h"

#include <gtest/gtest.h>

#include <map>

#include "shared/recording/recording.h"
#include "shared/recording/timing_table.h"
#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"
#include "tools/score/truth.h"

namespace touchline::sim::output {
namespace {

namespace fs = std::filesystem;

// Grey that brightens with time; a person walks along x, with a square of matte.
class GreyMatch final : public Match {
 public:
  const pitch::PitchModel& pitch() const override { return pitch_; }
  render::Picture picture(const render::Exposure& exposure, const render::RenderOptions&,
                          bool with_people) const override {
    const auto& model = exposure.open.model;
    const auto light = static_cast<float>(0.1 + 0.1 * (exposure.open_s + exposure.close_s) / 2);
    render::Picture made{{model.width, model.height, {light, light, light}},
                         {model.width, model.height}};
    if (with_people) made.matte(10, 12) = 200;
    return made;
  }
  std::vector<PersonTruth> people(double time_s) const override {
    return {{"a1", "home", "player", {time_s, 2, 0}, {{"head", {time_s, 2, 1.7}}}},
            {"ball", "", "ball", {0, 0, 0.11}, {}}};
  }
  geometry::Mesh mesh(double) const override {
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  }
  Eigen::Vector3d target(const std::string&, double time_s) const override {
    return {time_s, 0, 0};
  }

 private:
  pitch::PitchModel pitch_ = *pitch::make_pitch(pitch::Sport::kSoccer, {});
};

scene::Scene small() {
  auto scene = scene::parse_scene(R"(format_version = 1
frames = 6
size = [128, 64]
[[person]]
id = "a1"
[ball]
[[camera]]
id = "m1"
position = [0, -60, 15]
survey_stills = 3
head = { }
[[camera]]
id = "f1"
role = "fixed"
position = [0, 60, 15]
drop = [2]
repeat = [4]
offset_ms = 3
[[camera]]
id = "i1"
role = "fixed"
scan = "tff"
position = [70, 0, 15]
[[virtual]]
[truth]
mesh_every = 3
)",
                                  "test.toml", "/");
  EXPECT_TRUE(scene) << (scene ? "" : base::to_string(scene.error()));
  return scene ? *scene : scene::Scene{};
}

std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) {
      files[fs::relative(entry.path(), folder)] = support::read_text(entry.path());
    }
  }
  return files;
}

TEST(Record, MakesARecordingWithItsTruth) {
  const support::TempFolder folder;
  const auto report = record(small(), GreyMatch(), folder / "r", {});
  ASSERT_TRUE(report) << base::to_string(report.error());
  EXPECT_EQ(report->video_frames, 6 + 5 + 6);
  const auto recording = recording::load_recording(folder / "r");
  ASSERT_TRUE(recording) << base::to_string(recording.error());
  ASSERT_EQ(recording->cameras.size(), 3U);
  EXPECT_EQ(recording->cameras[1].offset_ns, 3'000'000);
  EXPECT_EQ(recording->cameras[2].scan, image::Scan::kTopFirst);
  EXPECT_FALSE(recording->cameras[0].head.empty());
  const auto stills = recording::survey_stills(recording->cameras[0]);
  ASSERT_TRUE(stills);
  EXPECT_EQ(stills->size(), 3U);
  const auto truth = score::Truth::open(*recording);
  ASSERT_TRUE(truth) << base::to_string(truth.error());
  EXPECT_EQ(truth->camera_rows({"m1"}), 6U);
  EXPECT_EQ(truth->camera_rows({"f1"}), 5U);  // of its video
  EXPECT_TRUE(truth->matte({"f1"}, 3));       // of the copy
  EXPECT_EQ(truth->people(3).size(), 2U);
  EXPECT_EQ(truth->joints(3).size(), 1U);
  EXPECT_EQ(truth->mesh_frames(), (std::vector<std::int64_t>{0, 3}));
  ASSERT_EQ(truth->virtual_cameras().size(), 1U);
  EXPECT_EQ(truth->clean_frames({"virtual01"}), (std::vector<std::int64_t>{0, 2, 4}));
  const auto matte = truth->matte({"m1"}, 5);
  ASSERT_TRUE(matte);
  EXPECT_EQ((*matte)(10, 12), 200);
  EXPECT_EQ((*matte)(11, 12), 0);
}

TEST(Record, DropsAndRepeatsAreInVideoAndTable) {
  const support::TempFolder folder;
  ASSERT_TRUE(record(small(), GreyMatch(), folder / "r", {}));
  const auto recording = recording::load_recording(folder / "r");
  ASSERT_TRUE(recording);
  const auto& camera = recording->cameras[1];
  const auto rows = recording::read_timing_table(camera.timing);
  ASSERT_TRUE(rows) << base::to_string(rows.error());
  ASSERT_EQ(rows->size(), 5U);
  EXPECT_EQ((*rows)[2].media_time.ns, 123'000'000);
  EXPECT_EQ((*rows)[3].media_time.ns, 123'000'000);
  auto reader = recording::VideoReader::open(camera, *recording, 0);
  ASSERT_TRUE(reader);
  std::vector<image::Frame> frames;
  for (auto frame = reader->next(); frame && *frame; frame = reader->next()) {
    frames.push_back(std::move(**frame));
  }
  ASSERT_EQ(frames.size(), 5U);
  EXPECT_EQ(frames[2].planes[0], frames[3].planes[0]);
  EXPECT_NE(frames[1].planes[0], frames[2].planes[0]);
  EXPECT_EQ(frames[4].stamp.media_time.ns, 203'000'000);
}

TEST(Record, IsTheSameAtAnyNumberOfThreads) {
  const support::TempFolder folder;
  RunOptions one, four;
  one.threads = 1;
  four.threads = 4;
  ASSERT_TRUE(record(small(), GreyMatch(), folder / "a", one));
  ASSERT_TRUE(record(small(), GreyMatch(), folder / "b", four));
  const auto a = files_of(folder / "a"), b = files_of(folder / "b");
  ASSERT_EQ(a.size(), b.size());
  for (const auto& [name, text] : a) EXPECT_TRUE(b.contains(name) && b.at(name) == text) << name;
}

TEST(Record, AStoppedRunLeavesNothing) {
  const support::TempFolder folder;
  std::stop_source source;
  RunOptions options;
  options.stop = source.get_token();
  options.progress = [&](std::int64_t done, std::int64_t) {
    if (done == 5) source.request_stop();
  };
  const auto report = record(small(), GreyMatch(), folder / "r", options);
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, base::ErrorKind::kCancelled);
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(Record, ReplacesARecordingOnlyWhenAskedAndNothingElseEver) {
  const support::TempFolder folder;
  ASSERT_TRUE(record(small(), GreyMatch(), folder / "r", {}));
  const auto again = record(small(), GreyMatch(), folder / "r", {});
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, base::ErrorKind::kArgument);
  RunOptions force;
  force.force = true;
  EXPECT_TRUE(record(small(), GreyMatch(), folder / "r", force));
  fs::create_directories(folder / "precious");
  support::write_text(folder / "precious" / "letter.txt", "dear");
  EXPECT_FALSE(record(small(), GreyMatch(), folder / "precious", force));
  EXPECT_TRUE(fs::exists(folder / "precious" / "letter.txt"));
}

}  // namespace
}  // namespace touchline::sim::output
