// A small simulated recording: it loads, and its truth lies on what its videos show.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"
#include "tests/support/folders.h"
#include "tools/score/truth.h"
#include "tools/sim/output/match.h"
#include "tools/sim/output/recording_run.h"
#include "tools/sim/scene/scene.h"

namespace touchline {
namespace {

constexpr const char* kScene = R"(format_version = 1
name = "overlay"
seed = 3
frames = 3
size = [640, 360]
[pitch]
length_m = 104.4
width_m = 67.2
crown_m = 0.3
[turf]
mowing = "none"
wear = 0
[lines]
wear = 0
[[person]]
id = "a9"
way = [-2, 30, -6,  0, 36, -3,  4, 44, 0]
[ball]
at = [41, 2]
[[camera]]
id = "m1"
position = [20, -55, 14]
level_deg = [0.6, -0.4]
roll_deg = 0.5
sway_m = 0.01
survey_stills = 4
motion = { follow = "a9", view_m = 22, jitter_deg = 0.01 }
lens = { wide_mm = 9, tele_mm = 60, corner_wide = -0.05, corner_tele = 0.02, centre_px = [3, -4], pupil_wide_m = 0.2 }
sensor = { read_noise = 0.0005, shot_noise = 0.001 }
video = { codec = "ffv1" }
[[camera]]
id = "f1"
role = "fixed"
position = [74, 20, 11]
motion = { aim = [44, 0, 0], view_m = 26 }
lens = { wide_mm = 9, tele_mm = 60, corner_wide = -0.04 }
sensor = { detail = { level = 0.3 } }
)";

class SimRecording : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new support::TempFolder;
    const auto scene = sim::scene::parse_scene(kScene, "overlay.toml", "/");
    ASSERT_TRUE(scene) << base::to_string(scene.error());
    const auto match = sim::output::simulated_match(*scene, TOUCHLINE_SIM_ASSETS);
    ASSERT_TRUE(match) << base::to_string(match.error());
    pitch_ = (*match)->pitch();
    const auto report = sim::output::record(*scene, **match, *folder_ / "r", {});
    ASSERT_TRUE(report) << base::to_string(report.error());
  }
  static void TearDownTestSuite() { delete folder_; }

  static support::TempFolder* folder_;
  static pitch::PitchModel pitch_;
};
support::TempFolder* SimRecording::folder_ = nullptr;
pitch::PitchModel SimRecording::pitch_;

double sample(const image::ImageView<const std::uint16_t>& luma, const Eigen::Vector2d& p) {
  const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
  const double u = p.x() - x, v = p.y() - y;
  return (1 - v) * ((1 - u) * luma(x, y) + u * luma(x + 1, y)) +
         v * ((1 - u) * luma(x, y + 1) + u * luma(x + 1, y + 1));
}

// How far the bright line lies from `middle` along `normal`; none where there is no clear line.
std::optional<double> line_offset(const image::ImageView<const std::uint16_t>& luma,
                                  const Eigen::Vector2d& middle, const Eigen::Vector2d& normal,
                                  double width_px) {
  const double reach = 1.5 * width_px + 2.5;
  const Eigen::Vector2d far = reach * normal;
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(middle + far), Eigen::Vector2d(middle - far)}) {
    if (p.x() < 1 || p.y() < 1 || p.x() > luma.width - 3 || p.y() > luma.height - 3) return {};
  }
  constexpr double kStep = 0.1;
  const int n = static_cast<int>(reach / kStep);
  const double left = (sample(luma, middle - far) + sample(luma, middle - far + 0.7 * normal)) / 2;
  const double right = (sample(luma, middle + far) + sample(luma, middle + far - 0.7 * normal)) / 2;
  double sum = 0, moment = 0, most = 0;
  for (int i = -n; i <= n; ++i) {
    const double t = i * kStep;
    const double ground = left + (right - left) * (t / reach + 1) / 2;
    const double excess = sample(luma, middle + t * normal) - ground;
    sum += excess;
    moment += excess * t;
    most = std::max(most, excess);
  }
  if (most < 80 || std::abs(left - right) > 0.15 * most) return {};
  return moment / sum;
}

TEST_F(SimRecording, TruthLiesOnTheMarkingsWithinATenthOfAPixel) {
  const auto recording = recording::load_recording(*folder_ / "r");
  ASSERT_TRUE(recording) << base::to_string(recording.error());
  const auto truth = score::Truth::open(*recording);
  ASSERT_TRUE(truth) << base::to_string(truth.error());
  for (const auto& camera : recording->cameras) {
    auto reader = recording::VideoReader::open(camera, *recording, 0);
    ASSERT_TRUE(reader);
    int lines = 0;
    for (std::int64_t f = 0;; ++f) {
      auto frame = reader->next();
      ASSERT_TRUE(frame);
      if (!*frame) {
        EXPECT_EQ(f, 3);
        break;
      }
      const auto estimate = truth->camera(camera.id, f);
      const auto matte = truth->matte(camera.id, f);
      ASSERT_TRUE(estimate && matte);
      for (const pitch::Marking& marking : pitch_.markings) {
        if (marking.shape == pitch::MarkingShape::kSpot) continue;
        std::vector<double> offsets;
        for (double s = 0.5; s < marking.length() - 0.5; s += 0.25) {
          const Eigen::Vector2d at = marking.at(s), along = marking.tangent(s);
          const Eigen::Vector2d across(-along.y(), along.x());
          const auto project = [&](const Eigen::Vector2d& p) {
            return geometry::project(*estimate, pitch_.on_turf(p));
          };
          const auto middle = project(at), ahead = project(at + 0.1 * along);
          const auto a = project(at + 0.5 * marking.width * across);
          const auto b = project(at - 0.5 * marking.width * across);
          if (!middle || !ahead || !a || !b || !estimate->model.sees(*middle)) continue;
          const Eigen::Vector2d tangent = (*ahead - *middle).normalized();
          const Eigen::Vector2d normal(-tangent.y(), tangent.x());
          const double width = std::abs((*a - *b).dot(normal));
          if (width < 1.0 || width > 12) continue;
          const auto offset = line_offset((*frame)->luma(), *middle, normal, width);
          if (offset) offsets.push_back(*offset);
        }
        if (offsets.size() < 12) continue;
        ++lines;
        std::nth_element(offsets.begin(),
                         offsets.begin() + static_cast<std::ptrdiff_t>(offsets.size() / 2),
                         offsets.end());
        EXPECT_LT(std::abs(offsets[offsets.size() / 2]), 0.1)
            << camera.id.value << " frame " << f << " " << pitch::name(marking.id) << " over "
            << offsets.size() << " points";
      }
    }
    EXPECT_GE(lines, 9) << camera.id.value;
  }
}

TEST_F(SimRecording, MattesHoldTheTrueMeshes) {
  const auto recording = recording::load_recording(*folder_ / "r");
  ASSERT_TRUE(recording);
  const auto truth = score::Truth::open(*recording);
  ASSERT_TRUE(truth);
  const auto mesh = truth->mesh(0);
  ASSERT_TRUE(mesh) << base::to_string(mesh.error());
  EXPECT_GT(mesh->vertices.size(), 1000U);
  for (const auto& camera : recording->cameras) {
    const auto estimate = truth->camera(camera.id, 0);
    const auto matte = truth->matte(camera.id, 0);
    ASSERT_TRUE(estimate && matte);
    int seen = 0, inside = 0;
    for (const Eigen::Vector3f& vertex : mesh->vertices) {
      const auto pixel = geometry::project(*estimate, vertex.cast<double>());
      if (!pixel || pixel->x() < 2 || pixel->y() < 2 || pixel->x() > matte->width() - 3 ||
          pixel->y() > matte->height() - 3) {
        continue;
      }
      ++seen;
      bool covered = false;
      const int x = static_cast<int>(std::lround(pixel->x()));
      const int y = static_cast<int>(std::lround(pixel->y()));
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) covered = covered || (*matte)(x + dx, y + dy) > 0;
      }
      inside += covered ? 1 : 0;
    }
    ASSERT_GT(seen, 500) << camera.id.value;
    EXPECT_GT(inside, 0.98 * seen) << camera.id.value;
  }
}

}  // namespace
}  // namespace touchline
