#include "hub/session_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "hub/output/png.h"
#include "hub/session/session_writer.h"
#include "shared/codec/view_codec.h"
#include "tests/support/capsule_scene.h"
#include "tests/support/folders.h"

namespace touchline::hub {
namespace {

// Two people seen by three cameras over three frames, the second camera silent in frame 1.
class ExportTest : public testing::Test {
 protected:
  static constexpr int kFrames = 3;

  void SetUp() override {
    session::SessionInfo info;
    info.name = "test";
    info.start = base::MediaTime{1'000};
    info.sizes.length_m = 105;
    info.sizes.width_m = 68;
    info.sizes.crown_m = 0;
    for (const char* id : {"a", "b", "c"})
      info.cameras.push_back({base::CameraId{id}, {}, {}, 320, 180});
    auto writer = session::SessionWriter::create(folder_ / "s", info);
    ASSERT_TRUE(writer.has_value()) << base::to_string(writer.error());
    const Eigen::Vector3d positions[] = {{0, -60, 15}, {55, -30, 12}, {-50, 40, 15}};
    for (int k = 0; k < kFrames; ++k) {
      for (int c = 0; c < 3; ++c) {
        if (c == 1 && k == 1) continue;
        const auto camera = support::looking_at(positions[c], {0, 0, 1}, 1500, 320, 180);
        auto view = support::silhouettes(info.cameras[static_cast<std::size_t>(c)].id.value, camera,
                                         {support::standing(-1, 0), support::standing(1.5, 0.5)});
        view.id.sequence = static_cast<std::uint64_t>(k);
        view.stamp.media_time = base::frame_time(*info.start, info.rate, k);
        const auto encoded = codec::encode(view);
        ASSERT_TRUE(encoded.has_value()) << base::to_string(encoded.error());
        ASSERT_TRUE(writer->append(*encoded).has_value());
        if (k == 0 && c == 0) first_ = std::move(view);
      }
    }
    ASSERT_TRUE(writer->finish().has_value());
    ShotOptions options;
    options.hull.voxel_m = 0.04;
    auto shot = Shot::open(folder_ / "s", options);
    ASSERT_TRUE(shot.has_value()) << base::to_string(shot.error());
    shot_.emplace(std::move(*shot));
  }

  std::size_t files(const std::filesystem::path& folder) const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                  std::filesystem::directory_iterator()));
  }

  support::TempFolder folder_;
  codec::CameraView first_;
  std::optional<Shot> shot_;
};

TEST_F(ExportTest, CamerasHaveARowForEachFrameThatCameAndTheirNumbersToTheLastBit) {
  ASSERT_TRUE(export_cameras(*shot_, folder_ / "x", {}).has_value());
  const auto a = recording::read_camera_table(folder_ / "x" / "a.csv");
  const auto b = recording::read_camera_table(folder_ / "x" / "b.csv");
  ASSERT_TRUE(a.has_value() && b.has_value());
  EXPECT_EQ(a->size(), 3u);
  ASSERT_EQ(b->size(), 2u);
  EXPECT_EQ((*b)[1].frame, 2);
  EXPECT_EQ((*a)[0].model.fx, first_.estimate.model.fx);
  EXPECT_EQ((*a)[0].cam_from_world.translation, first_.estimate.cam_from_world.translation);
  ASSERT_TRUE((*a)[0].report.has_value());
  EXPECT_EQ((*a)[0].report->state, geometry::Evidence::kLines);
}

TEST_F(ExportTest, MattesComeOutAsTheyWentIn) {
  ASSERT_TRUE(export_mattes(*shot_, folder_ / "x", {}).has_value());
  EXPECT_EQ(files(folder_ / "x" / "a"), 3u);
  EXPECT_EQ(files(folder_ / "x" / "b"), 2u);
  const auto png = output::read_png_rgb(folder_ / "x" / "a" / "000000.png");
  ASSERT_TRUE(png.has_value());
  ASSERT_EQ(png->width(), 320);
  for (std::size_t i = 0; i < png->size(); ++i)
    ASSERT_EQ(png->data()[i].r, first_.matte->alpha.data()[i]);
}

TEST_F(ExportTest, HullsAndPeopleHaveAFileAndRowsForEveryInstant) {
  std::size_t told = 0;
  ASSERT_TRUE(export_hull(*shot_, folder_ / "h", [&](std::size_t done, std::size_t) {
                told = done;
              }).has_value());
  EXPECT_EQ(files(folder_ / "h"), 3u);
  EXPECT_EQ(told, 3u);
  ASSERT_TRUE(export_people(*shot_, folder_ / "p", {}).has_value());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "p" / "people.csv"));
}

recording::CameraRow row(std::int64_t frame) {
  recording::CameraRow out;
  out.frame = frame;
  const auto camera = support::looking_at({5, -20, 4}, {0, 0, 1}, 300, 160, 90);
  out.model = camera.model;
  out.cam_from_world = camera.cam_from_world;
  return out;
}

TEST_F(ExportTest, APathMakesAPictureARowNamedByFrame) {
  const auto report = render_path(*shot_, {row(0), row(2)}, folder_ / "r", {}, {});
  ASSERT_TRUE(report.has_value()) << base::to_string(report.error());
  EXPECT_EQ(report->pictures, 2u);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "r" / "000002.png"));
  EXPECT_EQ(files(folder_ / "r"), 2u);
}

TEST_F(ExportTest, AFrozenPathIsNumberedByRow) {
  PathOptions options;
  options.mp4 = folder_ / "film.mp4";
  const auto report = render_path(*shot_, {row(1), row(1), row(1)}, folder_ / "r", options, {});
  ASSERT_TRUE(report.has_value()) << base::to_string(report.error());
  EXPECT_TRUE(std::filesystem::exists(folder_ / "r" / "000000.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "r" / "000002.png"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "film.mp4"), 0u);
}

TEST_F(ExportTest, AFrameThatIsNotThereIsNamedBesideThoseThatAre) {
  const auto report = render_path(*shot_, {row(9)}, folder_ / "r", {}, {});
  ASSERT_FALSE(report.has_value());
  EXPECT_THAT(base::to_string(report.error()),
              testing::AllOf(testing::HasSubstr("9"), testing::HasSubstr("0 to 2")));
}

TEST(VirtualCamera, AnotherSizeShowsTheSameView) {
  const recording::CameraRow path_row = row(0);
  const auto small = virtual_camera(path_row, std::nullopt);
  const auto large = virtual_camera(path_row, std::pair{320, 180});
  EXPECT_EQ(large.model.width, 320);
  // The border of the picture (half a pixel outside the outer centres) is the same ray.
  const Eigen::Vector3d a = small.model.unproject({-0.5, -0.5});
  const Eigen::Vector3d b = large.model.unproject({-0.5, -0.5});
  EXPECT_NEAR((a - b).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace touchline::hub
