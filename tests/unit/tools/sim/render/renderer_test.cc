// Pictures of a simulated ground, held against geometry.
#include "tools/sim/render/renderer.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

#include "tools/sim/people/cast.h"
#include "tools/sim/world/world.h"

namespace touchline::sim::render {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

geometry::Rigid3 looking(const Vector3d& from, const Vector3d& at) {
  const Vector3d z = (at - from).normalized();
  const Vector3d x = z.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation.row(0) = x;
  rotation.row(1) = z.cross(x);
  rotation.row(2) = z;
  geometry::Rigid3 pose;
  pose.rotation = Eigen::Quaterniond(rotation).normalized();
  pose.translation = -(pose.rotation * from);
  return pose;
}

geometry::CameraModel camera(int width, int height, double f) {
  geometry::CameraModel m;
  m.width = width;
  m.height = height;
  m.fx = m.fy = f;
  m.cx = 0.5 * (width - 1) + 3;
  m.cy = 0.5 * (height - 1) - 2;
  m.k1 = -0.09;
  m.k2 = 0.02;
  return m;
}

Exposure still(const geometry::CameraModel& model, const geometry::Rigid3& pose, double time = 0) {
  return {{model, pose}, {model, pose}, time, time};
}

// A ground without what would stand in the way.
world::WorldSpec bare() {
  world::WorldSpec spec;
  spec.stands.near_side.present = spec.stands.far_side.present = false;
  spec.stands.left_side.present = spec.stands.right_side.present = false;
  spec.stands.dugouts = false;
  spec.boards.far_side = spec.boards.left_side = spec.boards.right_side = world::Boards::kNone;
  spec.turf.texture = 0;
  spec.turf.wear = 0;
  spec.turf.mowing = world::Mowing::kNone;
  spec.lines.wear = 0;
  return spec;
}

pitch::PitchModel pitch_of(pitch::Sport sport, double crown) {
  pitch::PitchSizes sizes;
  sizes.crown_m = crown;
  return pitch::make_pitch(sport, sizes).value();
}

double brightness(const Picture& picture, double x, double y) {
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const double u = x - i, v = y - j;
  const auto at = [&](int a, int b) {
    const auto& p = picture.radiance(a, b);
    return static_cast<double>(p[0]) + static_cast<double>(p[2]);  // chalk has both, grass neither
  };
  return (1 - v) * ((1 - u) * at(i, j) + u * at(i + 1, j)) +
         v * ((1 - u) * at(i, j + 1) + u * at(i + 1, j + 1));
}

struct Offsets {
  double mean = 0, rms = 0;
  int count = 0;
};

// How far the centres of lines in the picture lie from where the camera projects them, across the
// lines, in pixels.
Offsets line_offsets(const Picture& picture, const pitch::PitchModel& pitch,
                     const ShutterPose& pose) {
  Offsets out;
  double sum = 0, squares = 0;
  const auto project = [&](const Vector2d& p) {
    return pose.model.project(pose.cam_from_world * pitch.on_turf(p));
  };
  for (const pitch::Marking& m : pitch.markings) {
    if (m.shape == pitch::MarkingShape::kSpot || m.dashed) continue;
    for (double s = 1.1; s < m.length() - 1.1; s += 0.1) {
      const Vector2d centre = m.at(s), along = m.tangent(s), across(-along.y(), along.x());
      bool alone = true;
      for (const pitch::Marking& other : pitch.markings) {
        if (other.id == m.id) continue;
        for (double q = 0; q <= other.length() && alone; q += 0.3)
          alone = (other.at(q) - centre).norm() > 1.0;
      }
      if (!alone) continue;
      const auto middle = project(centre);
      const auto left = project(centre - 0.5 * m.width * across);
      const auto right = project(centre + 0.5 * m.width * across);
      const auto before = project(centre - 0.05 * along), after = project(centre + 0.05 * along);
      if (!middle || !left || !right || !before || !after) continue;
      const Vector2d direction = (*after - *before).normalized(),
                     normal(-direction.y(), direction.x());
      const double wide = std::abs((*right - *left).dot(normal));
      if (wide < 1.5 || wide > 12) continue;  // thinner ones have no exact centre in pixels
      const double reach = 0.5 * wide + 2.5;
      if (middle->x() < reach + 2 || middle->y() < reach + 2 ||
          middle->x() > picture.radiance.width() - reach - 3 ||
          middle->y() > picture.radiance.height() - reach - 3)
        continue;
      const Vector2d expected = 0.5 * (*left + *right);
      const double base =
          0.5 *
          (brightness(picture, (expected - reach * normal).x(), (expected - reach * normal).y()) +
           brightness(picture, (expected + reach * normal).x(), (expected + reach * normal).y()));
      double mass = 0, moment = 0;
      for (double t = -reach; t <= reach; t += 0.1) {
        const Vector2d p = expected + t * normal;
        const double light = brightness(picture, p.x(), p.y()) - base;
        mass += light;
        moment += t * light;
      }
      if (mass < 1) continue;
      const double offset = moment / mass;
      sum += offset;
      squares += offset * offset;
      ++out.count;
    }
  }
  out.mean = sum / out.count;
  out.rms = std::sqrt(squares / out.count);
  return out;
}

TEST(Renderer, LinesLieWhereTheCameraProjectsThem) {
  for (const auto sport : {pitch::Sport::kSoccer, pitch::Sport::kRugbyUnion}) {
    const auto pitch = pitch_of(sport, 0.4);
    const auto world = world::World::create(bare(), pitch, 3).value();
    const Renderer renderer(world, nullptr);
    for (const Vector3d& at : {Vector3d(-30, 5, 0), Vector3d(4, -4, 0)}) {
      const ShutterPose pose{camera(960, 540, 1100), looking({-6, -62, 16}, at)};
      RenderOptions options;
      options.shadows = false;
      const Offsets offsets = line_offsets(
          renderer.render(still(pose.model, pose.cam_from_world), options), pitch, pose);
      EXPECT_GT(offsets.count, 100);
      EXPECT_LT(std::abs(offsets.mean), 0.02);
      EXPECT_LT(offsets.rms, 0.05) << offsets.count << " points";
    }
  }
}

TEST(Renderer, LinesStayThereOnWornGrassWithChalkThatVaries) {
  world::WorldSpec spec = bare();
  spec.turf = {};
  spec.lines = {};
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0.3);
  const auto world = world::World::create(spec, pitch, 3).value();
  const ShutterPose pose{camera(960, 540, 1300), looking({-6, -62, 16}, {-35, 0, 0})};
  const Picture picture = Renderer(world, nullptr).render(still(pose.model, pose.cam_from_world));
  const Offsets offsets = line_offsets(picture, pitch, pose);
  EXPECT_GT(offsets.count, 100);
  EXPECT_LT(std::abs(offsets.mean), 0.05);
  EXPECT_LT(offsets.rms, 0.2);
}

TEST(Renderer, LinesOfAMovingCameraLieInTheMiddleOfItsMove) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0.3);
  const auto world = world::World::create(bare(), pitch, 3).value();
  const geometry::CameraModel model = camera(960, 540, 1300);
  Exposure exposure = still(model, looking({-6, -62, 16}, {-35, 0, 0}));
  exposure.close.cam_from_world = looking({-6, -62, 16}, {-34.8, 0, 0});
  ShutterPose middle{model, looking({-6, -62, 16}, {-34.9, 0, 0})};
  const Picture picture = Renderer(world, nullptr).render(exposure);
  const Offsets offsets = line_offsets(picture, pitch, middle);
  EXPECT_GT(offsets.count, 100);
  EXPECT_LT(std::abs(offsets.mean), 0.05);
  EXPECT_LT(offsets.rms, 0.15);
}

// A cast of one person far off and a ball.
std::optional<people::Cast> ball_at(const Vector2d& place, const pitch::PitchModel& pitch) {
  people::CastSpec spec;
  people::PersonSpec person;
  person.id = "p1";
  person.team = "home";
  person.number = 4;
  person.position_m = {40, 25};
  spec.people.push_back(person);
  spec.ball.path = people::BallPath::kResting;
  spec.ball.position_m = place;
  spec.duration_s = 2;
  auto cast = people::Cast::create(spec, pitch, 1, TOUCHLINE_SIM_ASSETS);
  if (!cast) {
    ADD_FAILURE() << base::to_string(cast.error());
    return std::nullopt;
  }
  return std::move(*cast);
}

double matte_area(const Picture& picture) {
  double sum = 0;
  for (std::size_t i = 0; i < picture.matte.size(); ++i)
    sum += static_cast<double>(picture.matte.data()[i]) / 255;
  return sum;
}

// Area of a sphere's outline in a picture, pixels.
double outline_area(const Vector3d& centre, double radius, const ShutterPose& pose) {
  const Vector3d c = pose.cam_from_world * centre;
  const double d = c.norm(), sine = radius / d;
  const Vector3d axis = c / d, side = axis.unitOrthogonal(), other = axis.cross(side);
  const Vector3d middle = c * (1 - sine * sine);
  const double rim = radius * std::sqrt(1 - sine * sine);
  constexpr int kSteps = 2000;
  double area = 0;
  const auto at = [&](int i) {
    const double a = 2 * std::numbers::pi * i / kSteps;
    return pose.model.project(middle + rim * (std::cos(a) * side + std::sin(a) * other)).value();
  };
  for (int i = 0; i < kSteps; ++i) {
    const Vector2d p = at(i), q = at(i + 1);
    area += 0.5 * (p.x() * q.y() - q.x() * p.y());
  }
  return std::abs(area);
}

TEST(Renderer, MatteOfTheBallIsTheAreaOfItsOutline) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0.3);
  const auto world = world::World::create(bare(), pitch, 3).value();
  const auto cast = ball_at({-20, 3}, pitch);
  ASSERT_TRUE(cast);
  const people::BallState ball = cast->ball(0);
  const Renderer renderer(world, &*cast);
  for (const double f : {1500.0, 4000.0, 15000.0}) {
    const ShutterPose pose{camera(640, 360, f),
                           looking({-14, -20, 6}, ball.centre + Vector3d(0.1, 0, 0))};
    const double expected = outline_area(ball.centre, ball.radius, pose);
    const double seen = matte_area(renderer.render(still(pose.model, pose.cam_from_world)));
    EXPECT_NEAR(seen / expected, 1, f < 3000 ? 0.03 : 0.01) << expected << " px";
  }
}

TEST(Renderer, PostsCutTheMatte) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0);
  const pitch::Bar& post = pitch.bars.front();
  world::WorldSpec spec = bare();
  spec.goals.nets = false;
  const auto world = world::World::create(spec, pitch, 3).value();
  // The ball behind a post, seen along the ground.
  const Vector2d foot = post.start.head<2>();
  const auto cast = ball_at(foot + Vector2d(-0.6, 0), pitch);
  ASSERT_TRUE(cast);
  const Renderer renderer(world, &*cast);
  const geometry::CameraModel model = camera(480, 270, 2000);
  const Vector3d ball = cast->ball(0).centre;
  const ShutterPose behind{model, looking(ball + Vector3d(12, 0, 0.6), ball)};
  const ShutterPose beside{model, looking(ball + Vector3d(0, -12, 0.6), ball)};
  const double hidden = matte_area(renderer.render(still(model, behind.cam_from_world)));
  const double whole = matte_area(renderer.render(still(model, beside.cam_from_world)));
  // A post 0.12 m wide in front of a ball 0.22 m wide: two caps are left.
  EXPECT_GT(hidden, 0.15 * whole);
  EXPECT_LT(hidden, 0.5 * whole);
}

TEST(Renderer, NetsTakeALittleOfTheMatte) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0);
  const Vector2d inside(-(pitch.length_m / 2) - 0.9, 0.5);
  const auto cast = ball_at(inside, pitch);
  ASSERT_TRUE(cast);
  const ShutterPose pose{camera(480, 270, 1500),
                         looking({-pitch.length_m / 2 - 14, 0.5, 1.5}, {inside.x(), 0.5, 0.1})};
  world::WorldSpec spec = bare();
  const auto netted = world::World::create(spec, pitch, 3).value();
  spec.goals.nets = false;
  const auto open = world::World::create(spec, pitch, 3).value();
  const double with =
      matte_area(Renderer(netted, &*cast).render(still(pose.model, pose.cam_from_world)));
  const double without =
      matte_area(Renderer(open, &*cast).render(still(pose.model, pose.cam_from_world)));
  const double cord = spec.goals.net_cord_m / spec.goals.net_mesh_m;
  EXPECT_NEAR(with / without, (1 - cord) * (1 - cord), 0.03);
}

TEST(Renderer, ShadowsPointAwayFromTheSun) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0);
  world::WorldSpec spec = bare();
  spec.goals.nets = false;
  spec.sun.azimuth_deg = 60;
  spec.sun.elevation_deg = 45;
  const auto world = world::World::create(spec, pitch, 3).value();
  const auto cast = ball_at({-20, 3}, pitch);
  ASSERT_TRUE(cast);
  const Renderer renderer(world, &*cast);
  const geometry::CameraModel model = camera(480, 270, 1500);
  const Vector3d ball = cast->ball(0).centre;
  const ShutterPose pose{model, looking(ball + Vector3d(0, -0.5, 12), ball)};
  const Picture picture = renderer.render(still(model, pose.cam_from_world));
  const double azimuth = spec.sun.azimuth_deg * std::numbers::pi / 180;
  const Vector3d to_sun(std::cos(azimuth), std::sin(azimuth), 0);
  const auto at = [&](double metres) {
    Vector3d p = ball + metres * to_sun;
    p.z() = 0;
    const Vector2d pixel = model.project(pose.cam_from_world * p).value();
    return brightness(picture, pixel.x(), pixel.y());
  };
  // The middle of the shadow of a sphere at 45 degrees lies its height further on.
  EXPECT_LT(at(-0.16), 0.6 * at(0.5));
  EXPECT_GT(at(0.35), 0.9 * at(0.5));
  EXPECT_GT(at(-0.5), 0.9 * at(0.5));
}

TEST(Renderer, SameBytesAtAnyThreadCount) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0.3);
  world::WorldSpec spec;
  spec.weather.rain = 0.5;
  const auto world = world::World::create(spec, pitch, 3).value();
  const auto cast = ball_at({-20, 3}, pitch);
  ASSERT_TRUE(cast);
  Exposure exposure = still(camera(480, 270, 600), looking({-6, -62, 16}, {-20, 3, 0}), 1);
  exposure.close.cam_from_world = looking({-6, -62, 16}, {-19.8, 3, 0});
  exposure.close_s = 1.01;
  const auto with_threads = [&](int threads) {
    tbb::task_arena arena(threads);
    Picture picture;
    arena.execute([&] { picture = Renderer(world, &*cast).render(exposure); });
    return picture;
  };
  const Picture one = with_threads(1), four = with_threads(4);
  EXPECT_EQ(std::memcmp(one.radiance.data(), four.radiance.data(), one.radiance.size() * 12), 0);
  EXPECT_EQ(one.matte, four.matte);
}

TEST(Renderer, MeshHoldsEverybodyAndTheBall) {
  const auto pitch = pitch_of(pitch::Sport::kSoccer, 0);
  const auto cast = ball_at({-20, 3}, pitch);
  ASSERT_TRUE(cast);
  const geometry::Mesh mesh = mesh_of(*cast, 0);
  EXPECT_EQ(mesh.triangles.size(),
            cast->body(0).triangles.size() + cast->ball_body().triangles.size());
  for (const auto& t : mesh.triangles)
    for (const std::uint32_t v : t) ASSERT_LT(v, mesh.vertices.size());
}

}  // namespace
}  // namespace touchline::sim::render
