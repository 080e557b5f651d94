#include "hub/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/capsule_scene.h"
#include "tests/unit/hub/render/textured_scene.h"

namespace touchline::render {
namespace {

using support::looking_at;

TEST(Renderer, OptionsNameTheFieldThatIsOut) {
  RenderOptions options;
  options.step_m = 0;
  const auto renderer = Renderer::make(flat_pitch(), {}, {}, options);
  ASSERT_FALSE(renderer);
  EXPECT_EQ(renderer.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_NE(renderer.error().where.find("step_m"), std::string::npos);
  EXPECT_TRUE(RenderOptions{}.validate());
}

TEST(Renderer, ModesHaveTheNamesOfTheFormat) {
  for (const Mode mode : {Mode::kRefined, Mode::kHull, Mode::kBillboard}) {
    EXPECT_EQ(*parse_mode(std::string(name(mode))), mode);
  }
  EXPECT_FALSE(parse_mode("best"));
}

TEST(Renderer, UnusableViewsAreLeftOutAndNamed) {
  const std::vector<Ball> balls = {{{0, 0, 1}, 0.5, {200, 60, 40}}};
  const auto camera = looking_at({0, -10, 3}, {0, 0, 1}, 500, 120, 90);
  std::vector<codec::CameraView> views(4, draw_view("good", camera, balls));
  views[1].id.camera.value = "lost";
  views[1].estimate.evidence = geometry::Evidence::kLost;
  views[2].id.camera.value = "bare";
  views[2].matte.reset();
  views[3].id.camera.value = "small";
  views[3].matte->alpha = image::Image<std::uint8_t>(3, 3);
  RenderOptions options;
  options.find_stadium = false;
  const auto renderer = Renderer::make(flat_pitch(), {}, {}, options);
  const auto result = renderer->render(views, hull_of(balls, 0.05, views), camera, Mode::kRefined);
  for (const char* word : {"lost", "bare", "small", "refined"}) {
    EXPECT_TRUE(
        std::any_of(result.report.warnings.begin(), result.report.warnings.end(),
                    [&](const std::string& w) { return w.find(word) != std::string::npos; }))
        << word;
  }
  EXPECT_EQ(result.report.share_by_camera.count({"lost"}), 0U);
  EXPECT_GT(result.report.share_by_camera.at({"good"}), 0.05);
  ASSERT_EQ(result.report.groups.size(), 1U);
  EXPECT_EQ(result.report.groups[0].rendition, scene::Rendition::kHull);
}

TEST(Renderer, PeopleStandOverTheGround) {
  const std::vector<Ball> balls = {{{0, 0, 1}, 0.5, {200, 60, 40}}};
  const auto camera = looking_at({0, -10, 3}, {0, 0, 1}, 500, 160, 120);
  const std::vector<codec::CameraView> views = {draw_view("a", camera, balls)};
  std::map<base::CameraId, image::PlateSnapshot> plates;
  plates[{"a"}] = draw_plate({0, -10, 3}, 1.0 / 500, 7);
  RenderOptions options;
  options.find_stadium = false;
  const auto renderer = Renderer::make(flat_pitch(), plates, {}, options);
  const auto result = renderer->render(views, hull_of(balls, 0.05, views), camera, Mode::kHull);
  double error = 0;
  int n = 0;
  for (int y = 30; y < 120; ++y) {
    for (int x = 40; x < 120; ++x) {
      const Drawn truth = draw(balls, camera, x, y);
      if (truth.coverage > 0 && truth.coverage < 1) continue;
      error += std::abs(result.picture(x, y).r - truth.colour[0]);
      ++n;
    }
  }
  EXPECT_LT(error / n, 3);
}

}  // namespace
}  // namespace touchline::render
