#include "hub/hull/carve.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <optional>
#include <random>
#include <utility>

#include "hub/hull/surface_internal.h"
#include "hub/hull/volume_internal.h"
#include "tests/support/capsule_scene.h"
#include "tools/score/mesh_query.h"

namespace touchline::hull {
namespace {

using support::Capsule;

constexpr int kWidth = 480;
constexpr int kHeight = 270;

pitch::PitchModel small_pitch() {
  pitch::PitchModel pitch;
  pitch.length_m = 20;
  pitch.width_m = 20;
  return pitch;
}

HullOptions coarse_options() {
  HullOptions options;
  options.voxel_m = 0.04;
  options.margin_m = 2;
  return options;
}

// A camera somewhere round the middle of the pitch, looking at it.
geometry::CameraEstimate random_camera(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double angle = 2 * 3.14159265358979 * unit(random);
  const double away = 25 + 15 * unit(random);
  geometry::CameraEstimate camera =
      support::looking_at({away * std::cos(angle), away * std::sin(angle), 4 + 10 * unit(random)},
                          {0, 0, 1}, kWidth * away / 16, kWidth, kHeight);
  camera.model.k1 = -0.05;
  camera.model.k2 = 0.02;
  return camera;
}

std::vector<Capsule> random_people(std::mt19937& random, int count) {
  std::uniform_real_distribution<double> place(-3, 3);
  std::vector<Capsule> people;
  for (int i = 0; i < count; ++i) {
    people.push_back(support::standing(place(random), place(random)));
  }
  // An arm held out, and a ball in the air.
  people.push_back({{place(random), 0, 1.2}, {place(random), 1, 1.4}, 0.05});
  people.push_back({{0.3, 0.2, 2.6}, {0.3, 0.2, 2.6}, 0.11});
  return people;
}

std::vector<codec::CameraView> random_views(std::mt19937& random, int count,
                                            const std::vector<Capsule>& scene) {
  std::vector<codec::CameraView> views;
  for (int i = 0; i < count; ++i) {
    views.push_back(support::silhouettes(fmt::format("c{}", i), random_camera(random), scene));
  }
  return views;
}

score::MeshQuery query_of(const scene::Hull& hull) {
  score::MeshQuery query;
  for (const scene::HullGroup& group : hull.groups) query.add(group.surface);
  return query;
}

// The field of all samples that are inside, by lattice position.
std::map<std::array<int, 3>, float> inside_samples(std::span<const codec::CameraView> views,
                                                   const HullOptions& options) {
  std::vector<SilhouetteMap> maps;
  for (const codec::CameraView& view : views) {
    maps.emplace_back(view, options.alpha_threshold, options.dilation_px);
  }
  const Volume volume = carve_volume(maps, small_pitch(), options);
  std::map<std::array<int, 3>, float> samples;
  for (const Brick& brick : volume.bricks) {
    for (int s = 0; s < kBrickSamples; ++s) {
      const float value = brick.field[static_cast<std::size_t>(s)];
      if (value <= 0) continue;
      samples[{brick.key.x * kBrick + s % kBrick, brick.key.y * kBrick + s / kBrick % kBrick,
               brick.key.z * kBrick + s / kBrick / kBrick}] = value;
    }
  }
  return samples;
}

void expect_same(const HullResult& a, const HullResult& b) {
  ASSERT_EQ(a.hull.groups.size(), b.hull.groups.size());
  for (std::size_t g = 0; g < a.hull.groups.size(); ++g) {
    EXPECT_EQ(a.hull.groups[g].surface.vertices, b.hull.groups[g].surface.vertices);
    EXPECT_EQ(a.hull.groups[g].surface.triangles, b.hull.groups[g].surface.triangles);
    EXPECT_EQ(a.hull.groups[g].support, b.hull.groups[g].support);
    EXPECT_EQ(a.hull.groups[g].volume_m3, b.hull.groups[g].volume_m3);
    EXPECT_EQ(a.hull.groups[g].phantom, b.hull.groups[g].phantom);
  }
  ASSERT_EQ(a.hull.billboards.size(), b.hull.billboards.size());
  for (std::size_t i = 0; i < a.hull.billboards.size(); ++i) {
    EXPECT_EQ(a.hull.billboards[i].foot_in_world, b.hull.billboards[i].foot_in_world);
  }
}

TEST(HullOptions, NamesTheFieldThatIsOutOfBounds) {
  EXPECT_TRUE(HullOptions().validate());
  HullOptions options;
  options.dilation_px = 11;
  const base::Status status = options.validate();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().where, "hull.dilation_px");
  EXPECT_NE(status.error().what.find("11"), std::string::npos);
}

TEST(Carve, ContainsEverySurfacePoint) {
  for (unsigned seed = 0; seed < 6; ++seed) {
    std::mt19937 random(seed);
    const std::vector<Capsule> people = random_people(random, 5);
    const std::vector<codec::CameraView> views =
        random_views(random, 2 + static_cast<int>(seed % 4), people);
    const HullResult result = carve(views, small_pitch(), coarse_options());
    const score::MeshQuery query = query_of(result.hull);
    for (const Capsule& person : people) {
      for (const Eigen::Vector3d& point : support::surface_points(person, 300, random)) {
        EXPECT_TRUE(query.inside(point)) << "seed " << seed << " at " << point.transpose();
      }
    }
  }
}

TEST(Carve, SurfacesAreClosedManifoldsWithPositiveVolume) {
  std::mt19937 random(11);
  const std::vector<Capsule> people = random_people(random, 7);
  const HullResult result = carve(random_views(random, 3, people), small_pitch(), coarse_options());
  ASSERT_FALSE(result.hull.groups.empty());
  for (const scene::HullGroup& group : result.hull.groups) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
    for (const auto& t : group.surface.triangles) {
      for (std::size_t i = 0; i < 3; ++i) ++sides[{t[i], t[(i + 1) % 3]}];
    }
    for (const auto& [side, count] : sides) {
      ASSERT_EQ(count, 1);
      const auto back = sides.find({side.second, side.first});
      ASSERT_NE(back, sides.end());
      ASSERT_EQ(back->second, 1);
    }
    EXPECT_GT(group.volume_m3, 0);
    EXPECT_EQ(group.id, static_cast<std::uint32_t>(&group - result.hull.groups.data()));
  }
}

TEST(FillCavities, KeepsOnlyWhatFacesOutwards) {
  geometry::Mesh mesh;
  const auto add = [&](float size, bool inwards) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const Eigen::Vector3f& corner : {Eigen::Vector3f(-1, -1, -1), Eigen::Vector3f(3, -1, -1),
                                          Eigen::Vector3f(-1, 3, -1), Eigen::Vector3f(-1, -1, 3)}) {
      mesh.vertices.push_back(size * corner);
    }
    for (std::array<std::uint32_t, 3> t :
         {std::array<std::uint32_t, 3>{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}) {
      if (inwards) std::swap(t[0], t[1]);
      mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  };
  add(0.2F, true);
  add(1, false);
  fill_cavities(mesh);
  ASSERT_EQ(mesh.vertices.size(), 4U);
  EXPECT_EQ(mesh.vertices[0], Eigen::Vector3f(-1, -1, -1));
  ASSERT_EQ(mesh.triangles.size(), 4U);
  EXPECT_GT(enclosed_volume(mesh), 0);
}

TEST(Carve, GroupsAreOrderedByCentre) {
  std::mt19937 random(4);
  const HullResult result =
      carve(random_views(random, 4, random_people(random, 6)), small_pitch(), coarse_options());
  for (std::size_t g = 1; g < result.hull.groups.size(); ++g) {
    EXPECT_LE(result.hull.groups[g - 1].bounds.center().x(),
              result.hull.groups[g].bounds.center().x());
  }
}

TEST(Carve, AnotherCameraNeverAddsWhereAllSee) {
  std::mt19937 random(21);
  const std::vector<Capsule> people = random_people(random, 4);
  const std::vector<codec::CameraView> views = random_views(random, 4, people);
  HullOptions options = coarse_options();
  for (std::size_t count = 3; count <= views.size(); ++count) {
    const auto fewer = inside_samples(std::span(views).first(count - 1), options);
    const auto more = inside_samples(std::span(views).first(count), options);
    EXPECT_LT(more.size(), fewer.size());
    for (const auto& [place, value] : more) {
      const auto at = fewer.find(place);
      // What only the wider picture of another camera lets in lies outside somebody's picture.
      if (at == fewer.end()) {
        const Eigen::Vector3d p = Eigen::Vector3d(place[0], place[1], place[2]) * options.voxel_m;
        const bool all_see =
            std::all_of(views.begin(), views.begin() + static_cast<std::ptrdiff_t>(count),
                        [&](const codec::CameraView& view) {
                          const auto pixel = geometry::project(view.estimate, p);
                          return pixel && view.estimate.model.sees(*pixel);
                        });
        EXPECT_FALSE(all_see);
        continue;
      }
      EXPECT_LE(value, at->second);
    }
  }
}

TEST(Carve, GrowsWithTheDilation) {
  std::mt19937 random(23);
  const std::vector<codec::CameraView> views = random_views(random, 3, random_people(random, 4));
  HullOptions options = coarse_options();
  options.dilation_px = 1;
  auto before = inside_samples(views, options);
  for (const double dilation : {2.0, 3.0, 5.0}) {
    options.dilation_px = dilation;
    auto now = inside_samples(views, options);
    EXPECT_GT(now.size(), before.size());
    for (const auto& [place, value] : before) {
      const auto at = now.find(place);
      ASSERT_NE(at, now.end());
      EXPECT_GE(at->second, value);
    }
    before = std::move(now);
  }
}

TEST(Carve, AbsentAndLostCamerasTakeNoPart) {
  std::mt19937 random(31);
  const std::vector<Capsule> people = random_people(random, 4);
  std::vector<codec::CameraView> views = random_views(random, 3, people);
  const HullResult expected = carve(views, small_pitch(), coarse_options());
  views.push_back(support::silhouettes("absent", random_camera(random), {}));
  views.back().matte.reset();
  views.push_back(support::silhouettes("lost", random_camera(random), {}));
  views.back().estimate.evidence = geometry::Evidence::kLost;
  views.push_back(support::silhouettes("wrong", random_camera(random), {}));
  views.back().matte->alpha = image::Image<std::uint8_t>(10, 10);
  const HullResult result = carve(views, small_pitch(), coarse_options());
  expect_same(expected, result);
  ASSERT_EQ(result.report.cameras.size(), 6U);
  EXPECT_EQ(result.report.cameras[3].participation, Participation::kWithoutMatte);
  EXPECT_EQ(result.report.cameras[4].participation, Participation::kLost);
  EXPECT_EQ(result.report.cameras[5].participation, Participation::kWrongSize);
}

TEST(Carve, UnknownPixelsNeverCarve) {
  std::mt19937 random(37);
  const std::vector<Capsule> people = {support::standing(0, 0)};
  std::vector<codec::CameraView> views = random_views(random, 4, people);
  // One camera has lost the left half of its picture behind something.
  image::Matte& matte = *views[0].matte;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 2; ++x) {
      matte.alpha(x, y) = 0;
      (y % 2 ? matte.unknown : matte.occluders)(x, y) = 255;
    }
  }
  const score::MeshQuery query = query_of(carve(views, small_pitch(), coarse_options()).hull);
  for (const Eigen::Vector3d& point : support::surface_points(people[0], 500, random)) {
    EXPECT_TRUE(query.inside(point)) << point.transpose();
  }
}

TEST(Carve, UnknownPixelsSupportWhatAnotherCameraSees) {
  std::mt19937 random(38);
  const std::vector<Capsule> people = {support::standing(0, 0)};
  std::vector<codec::CameraView> views = random_views(random, 2, people);
  // The second camera cannot tell black shorts from a black board.
  image::Matte& matte = *views[1].matte;
  const auto hide = [](image::Matte& of, int first_row) {
    for (int y = first_row; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) std::swap(of.alpha(x, y), of.unknown(x, y));
    }
  };
  hide(matte, kHeight / 2);
  const score::MeshQuery query = query_of(carve(views, small_pitch(), coarse_options()).hull);
  for (const Eigen::Vector3d& point : support::surface_points(people[0], 500, random)) {
    EXPECT_TRUE(query.inside(point)) << point.transpose();
  }
  // What one camera alone sees is no group.
  for (int y = 0; y < kHeight / 2; ++y) {
    for (int x = 0; x < kWidth; ++x) std::swap(matte.alpha(x, y), matte.unknown(x, y));
  }
  EXPECT_TRUE(carve(views, small_pitch(), coarse_options()).hull.groups.empty());
}

TEST(Carve, HealsAHoleInOneMatte) {
  std::mt19937 random(39);
  const std::vector<Capsule> people = {support::standing(0, 0), support::standing(1.5, 0.5)};
  std::vector<codec::CameraView> views = random_views(random, 4, people);
  // One camera has lost the legs of one of them.
  const auto knee = geometry::project(views[0].estimate, {0, 0, 0.5});
  ASSERT_TRUE(knee);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      if (y > knee->y() && std::abs(x - knee->x()) < 15) views[0].matte->alpha(x, y) = 0;
    }
  }
  HullOptions options = coarse_options();
  const HullResult healed = carve(views, small_pitch(), options);
  options.heal = false;
  const HullResult cut = carve(views, small_pitch(), options);
  EXPECT_GT(healed.report.healed_samples, 0U);
  EXPECT_EQ(cut.report.healed_samples, 0U);
  const score::MeshQuery with = query_of(healed.hull);
  const score::MeshQuery without = query_of(cut.hull);
  int lost = 0;
  for (const Eigen::Vector3d& point : support::surface_points(people[0], 500, random)) {
    EXPECT_TRUE(with.inside(point)) << point.transpose();
    lost += !without.inside(point);
  }
  EXPECT_GT(lost, 50);
}

TEST(Carve, HealsNothingWhereMattesAreWhole) {
  std::mt19937 random(40);
  const std::vector<codec::CameraView> views = random_views(random, 4, random_people(random, 5));
  EXPECT_EQ(carve(views, small_pitch(), coarse_options()).report.healed_samples, 0U);
}

TEST(Carve, IsTheSameAtAnyThreadCount) {
  std::mt19937 random(41);
  const std::vector<codec::CameraView> views = random_views(random, 4, random_people(random, 6));
  std::optional<HullResult> one;
  std::optional<HullResult> many;
  tbb::task_arena(1).execute([&] { one = carve(views, small_pitch(), coarse_options()); });
  tbb::task_arena(4).execute([&] { many = carve(views, small_pitch(), coarse_options()); });
  expect_same(*one, *many);
}

// Two people, two cameras at right angles: the cones cross in four places. The cameras stand so low
// that the false crossings touch the turf as well; they are smaller, being nearer to the cameras.
TEST(Carve, FindsThePhantomsOfTwoCameras) {
  const std::vector<Capsule> people = {support::standing(2, 1.2), support::standing(-1.5, -2)};
  std::vector<codec::CameraView> views;
  views.push_back(support::silhouettes(
      "a", support::looking_at({0, -30, 5}, {0, 0, 0.9}, 900, kWidth, kHeight), people));
  views.push_back(support::silhouettes(
      "b", support::looking_at({-30, 0, 5}, {0, 0, 0.9}, 900, kWidth, kHeight), people));
  const HullResult result = carve(views, small_pitch(), coarse_options());
  std::vector<Eigen::Vector3d> real;
  for (const scene::HullGroup& group : result.hull.groups) {
    if (!group.phantom) real.push_back(group.bounds.center());
  }
  EXPECT_GE(result.report.phantoms, 1U);
  ASSERT_EQ(real.size(), 2U);
  EXPECT_NEAR(real[0].x(), -1.5, 0.3);
  EXPECT_NEAR(real[0].y(), -2, 0.3);
  EXPECT_NEAR(real[1].x(), 2, 0.3);
  EXPECT_NEAR(real[1].y(), 1.2, 0.3);
  EXPECT_TRUE(result.hull.billboards.empty());
}

TEST(Carve, PeopleOfOneCameraBecomeBillboards) {
  const std::vector<Capsule> people = {support::standing(0, 0), support::standing(-2, -6)};
  std::vector<codec::CameraView> views;
  views.push_back(support::silhouettes(
      "wide", support::looking_at({0, -40, 10}, {0, 0, 0.9}, 1300, kWidth, kHeight), people));
  for (const double x : {-40.0, 40.0}) {
    views.push_back(support::silhouettes(
        x < 0 ? "left" : "right",
        support::looking_at({x, -10, 10}, {0, 0, 0.9}, 3500, kWidth, kHeight), people));
  }
  const HullResult result = carve(views, small_pitch(), coarse_options());
  ASSERT_EQ(result.hull.billboards.size(), 1U);
  const scene::Billboard& card = result.hull.billboards[0];
  EXPECT_EQ(card.camera.value, "wide");
  EXPECT_NEAR(card.foot_in_world.x(), -2, 0.1);
  EXPECT_NEAR(card.foot_in_world.y(), -6, 0.4);
  EXPECT_NEAR(card.height_m, 1.8, 0.15);
  EXPECT_GT(card.region.height, card.region.width);
}

std::vector<codec::CameraView> three_views(const std::vector<Capsule>& scene) {
  std::vector<codec::CameraView> views;
  for (const Eigen::Vector3d& position :
       {Eigen::Vector3d(0, -30, 8), Eigen::Vector3d(28, -12, 8), Eigen::Vector3d(-28, 10, 8)}) {
    views.push_back(support::silhouettes(
        fmt::format("c{}", views.size()),
        support::looking_at(position, {0, 0, 2}, 700, kWidth, kHeight), scene));
  }
  return views;
}

TEST(Carve, KeepsABallInTheAir) {
  const Eigen::Vector3d ball(0, 0, 5);
  const HullResult result = carve(three_views({{ball, ball, 0.11}, support::standing(-2, 0)}),
                                  small_pitch(), coarse_options());
  ASSERT_EQ(result.hull.groups.size(), 2U);
  EXPECT_FALSE(result.hull.groups[1].phantom);
  EXPECT_LT((result.hull.groups[1].bounds.center() - ball).norm(), 0.1);
  EXPECT_EQ(result.hull.groups[1].support.size(), 3U);
}

TEST(Carve, KeepsNothingLargeInTheAir) {
  const HullResult result =
      carve(three_views({{{2, 0, 3.5}, {2, 0, 5.5}, 0.25}, support::standing(-2, 0)}),
            small_pitch(), coarse_options());
  for (const scene::HullGroup& group : result.hull.groups) {
    EXPECT_TRUE(group.phantom || group.bounds.max().z() < 2.9);
  }
}

TEST(Carve, IsClosedJustBelowTheTurf) {
  std::mt19937 random(47);
  pitch::PitchModel pitch = small_pitch();
  pitch.crown_m = 0.3;
  const double turf = pitch.turf_z(4);
  const std::vector<Capsule> people = {support::standing(1, 4, turf)};
  const HullOptions options = coarse_options();
  const HullResult result = carve(random_views(random, 4, people), pitch, options);
  ASSERT_FALSE(result.hull.groups.empty());
  for (const scene::HullGroup& group : result.hull.groups) {
    for (const Eigen::Vector3f& vertex : group.surface.vertices) {
      EXPECT_GE(vertex.z(), pitch.turf_z(vertex.y()) - options.below_turf_m - 0.005);
    }
  }
}

TEST(Carve, NothingFromNothing) {
  EXPECT_TRUE(carve({}, small_pitch(), HullOptions()).hull.groups.empty());
  std::mt19937 random(1);
  const std::vector<codec::CameraView> empty = random_views(random, 3, {});
  const HullResult result = carve(empty, small_pitch(), coarse_options());
  EXPECT_TRUE(result.hull.groups.empty());
  EXPECT_TRUE(result.hull.billboards.empty());
}

}  // namespace
}  // namespace touchline::hull
