// A page of the embedded sample: every file it names is there, its elements close, and it asks for
// nothing outside its folder.
#include "tools/score/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "hub/output/ply.h"
#include "hub/output/png.h"
#include "shared/recording/camera_table.h"
#include "tests/support/folders.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// What is not closed, or closed without being open, in order of appearance.
std::vector<std::string> unbalanced(std::string html) {
  html = std::regex_replace(html, std::regex("<script>[^]*?</script>"), "");
  html = std::regex_replace(html, std::regex("<style>[^]*?</style>"), "");
  static const std::set<std::string> kVoid = {"meta", "img", "br", "link", "!DOCTYPE"};
  std::vector<std::string> open;
  std::vector<std::string> wrong;
  const std::regex tag(R"(<(/?)([A-Za-z!][A-Za-z0-9]*)((?:[^<>"]|"[^"]*")*?)(/?)>)");
  for (std::sregex_iterator it(html.begin(), html.end(), tag), end; it != end; ++it) {
    const std::string name = (*it)[2];
    if (kVoid.count(name) || (*it)[4].length() > 0) continue;
    if ((*it)[1].length() == 0) {
      open.push_back(name);
    } else if (!open.empty() && open.back() == name) {
      open.pop_back();
    } else {
      wrong.push_back("/" + name);
    }
  }
  wrong.insert(wrong.end(), open.begin(), open.end());
  return wrong;
}

std::vector<std::string> values_of(const std::string& html, const std::string& attribute) {
  std::vector<std::string> out;
  const std::regex pattern(attribute + "=\"([^\"]*)\"");
  for (std::sregex_iterator it(html.begin(), html.end(), pattern), end; it != end; ++it) {
    out.push_back((*it)[1]);
  }
  return out;
}

TEST(Unbalanced, FindsWhatIsNotClosed) {
  EXPECT_THAT(unbalanced("<p><img src=\"a>b\"><b>x</b></p><line x=\"1\"/>"), IsEmpty());
  EXPECT_THAT(unbalanced("<p><b>x</p></b>"), Not(IsEmpty()));
  EXPECT_THAT(unbalanced("<p>"), testing::ElementsAre("p"));
}

// Exports of frame 0 as a session would leave them, each wrong by a little.
class PageOfSample : public testing::Test {
 protected:
  void SetUp() override {
    auto loaded = recording::load_recording("tests/data/sample");
    ASSERT_TRUE(loaded) << base::to_string(loaded.error());
    recording_ = std::move(*loaded);
    auto truth = Truth::open(recording_);
    ASSERT_TRUE(truth) << base::to_string(truth.error());
    truth_.emplace(std::move(*truth));
    const base::CameraId m1{"m1"};
    auto camera = *truth_->camera(m1, 0);
    camera.model.cx += 2;
    fs::create_directories(exports() / "cameras");
    const std::vector rows = {recording::camera_row(0, camera)};
    ASSERT_TRUE(recording::write_camera_table(exports() / "cameras" / "m1.csv", rows));
    auto matte = *truth_->matte(m1, 0);
    for (int y = 300; y < 600; ++y) std::fill_n(matte.row(y) + 800, 200, std::uint8_t{0});
    fs::create_directories(exports() / "mattes" / "m1");
    ASSERT_TRUE(output::write_png(exports() / "mattes" / "m1" / "000000.png", matte));
    fs::create_directories(exports() / "hull");
    geometry::Mesh mesh = *truth_->mesh(0);
    for (auto& v : mesh.vertices) v.z() += 0.1F;
    ASSERT_TRUE(output::write_ply(exports() / "hull" / "000000.ply", mesh));
    const base::CameraId view{"virtual01"};
    auto picture = *truth_->clean(view, 0);
    for (int y = 200; y < 400; ++y) std::fill_n(picture.row(y) + 300, 300, image::Rgb8{9, 9, 9});
    fs::create_directories(exports() / "renders" / "virtual01");
    ASSERT_TRUE(output::write_png(exports() / "renders" / "virtual01" / "000000.png", picture));
    fs::create_directories(exports() / "people");
    support::write_text(exports() / "people" / "people.csv",
                        "frame,id,team,role,x,y,z,sd_x,sd_y\n0,p<1>,A,player,1,2,0,0.1,0.1\n");
    person_ = truth_->people(0).front().id;
  }

  fs::path exports() const { return folder_ / "exports"; }
  fs::path page() const { return folder_ / "page"; }

  static Series series(const ScoreKind& kind, const std::string& subject,
                       std::vector<Sample> samples) {
    Series s;
    s.kind = kind;
    s.subject = subject;
    s.samples = std::move(samples);
    s.summary = summarise(s.samples, kind.statistic);
    return s;
  }

  ScoreReport report() const {
    ScoreReport out;
    out.recording = recording_.name + " <&>";
    const ScoreKind rms{"cameras", "rms", "px"};
    const ScoreKind iou{"mattes", "IoU", "%", Better::kHigher};
    const ScoreKind inside{"hull", "inside", "%", Better::kHigher};
    const ScoreKind found{"people", "found", "%", Better::kHigher};
    const ScoreKind psnr{"views", "PSNR", "dB", Better::kHigher};
    out.series = {series(rms, "all", {{0, 2, 1}, {1, 1, 1}}),
                  series(rms, "m1", {{0, 2, 1}, {1, 1, 1}}),
                  series(rms, "m9", {{0, 1, 1}}),  // no such camera
                  series(iou, "m1", {{0, 71, 1}, {1, 80, 1}}),
                  series(inside, person_, {{0, 50, 1}}),
                  series(inside, "frame", {{0, 60, 1}}),
                  series(found, "all", {{0, 10, 1}, {1, 20, 1}}),
                  series(psnr, "virtual01", {{0, 17, 1}})};
    out.series.back().oracle = out.series.back().summary;
    out.not_scored = {"c1: no <file>"};
    out.notes = {"a note & more"};
    return out;
  }

  support::TempFolder folder_;
  recording::Recording recording_;
  std::optional<Truth> truth_;
  std::string person_;
};

TEST_F(PageOfSample, IsWholeAndAsksForNothingElsewhere) {
  PageOptions options;
  options.folder = page();
  options.exports = exports();
  const auto written = write_page(report(), recording_, *truth_, options);
  ASSERT_TRUE(written) << base::to_string(written.error());
  const std::string html = support::read_text(page() / "index.html");
  EXPECT_THAT(unbalanced(html), IsEmpty());
  for (const char* forbidden : {"http:", "https:", "//cdn", "@import", "url("}) {
    EXPECT_THAT(html, Not(HasSubstr(forbidden)));
  }
  const auto ids = values_of(html, " id");
  std::size_t pictures = 0;
  for (const char* attribute : {"href", "src"}) {
    for (const std::string& target : values_of(html, attribute)) {
      if (target.rfind('#', 0) == 0) {
        EXPECT_THAT(ids, testing::Contains(target.substr(1)));
        continue;
      }
      EXPECT_THAT(target, Not(HasSubstr("..")));
      EXPECT_TRUE(fs::is_regular_file(page() / target)) << target;
      ++pictures;
    }
  }
  // Camera, matte, person and frame of the hull, view: two or more each.
  EXPECT_GE(pictures, 10U);
  // Nothing lies about that the page does not show.
  for (const auto& entry : fs::directory_iterator(page() / "pictures")) {
    EXPECT_THAT(html, HasSubstr("pictures/" + entry.path().filename().string()));
  }
  EXPECT_THAT(html, HasSubstr("No picture: m9"));
  EXPECT_THAT(html, HasSubstr("&lt;&amp;&gt;"));
  EXPECT_THAT(html, HasSubstr("class=\"plan\""));
}

TEST_F(PageOfSample, OfNothingIsAPage) {
  PageOptions options;
  options.folder = page();
  options.exports = exports() / "none";
  ASSERT_TRUE(write_page({}, recording_, *truth_, options));
  EXPECT_THAT(unbalanced(support::read_text(page() / "index.html")), IsEmpty());
  // Exports that are gone: the page says so.
  ASSERT_TRUE(write_page(report(), recording_, *truth_, options));
  EXPECT_THAT(support::read_text(page() / "index.html"), HasSubstr("No picture"));
}

TEST_F(PageOfSample, FailsByNameWhereItCannotBeWritten) {
  PageOptions options;
  options.exports = exports();
  options.folder = folder_ / "file";
  support::write_text(options.folder, "not a folder");
  const auto written = write_page(report(), recording_, *truth_, options);
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().where, HasSubstr("file"));
  options.folder = page();
  options.worst_of_each = 21;
  EXPECT_FALSE(write_page(report(), recording_, *truth_, options));
}

}  // namespace
}  // namespace touchline::score
