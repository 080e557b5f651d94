#include "edge/calibrate/texture/plate_registration.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "edge/calibrate/fit/pose_fit.h"
#include "tests/unit/edge/calibrate/painted_pitch.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;

// Luma of the world by direction alone: bumps on two scales, the same from everywhere.
class Surroundings {
 public:
  explicit Surroundings(std::uint32_t seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (auto& v : coarse_) v = unit(random);
    for (auto& v : fine_) v = unit(random);
  }
  double at(const Eigen::Vector3d& direction) const {
    const double pan = std::atan2(direction.x(), direction.y()) / kRadians;
    const double tilt = std::asin(direction.normalized().z()) / kRadians;
    return 200 + 300 * value(coarse_, pan, tilt, 2.5) + 300 * value(fine_, pan, tilt, 9.0);
  }

 private:
  static constexpr int kSize = 256;
  static double value(const std::array<double, kSize * kSize>& grid, double pan, double tilt,
                      double a_degree) {
    const double x = pan * a_degree, y = tilt * a_degree;
    const double fx = std::floor(x), fy = std::floor(y);
    const auto node = [&](double i, double j) {
      const auto c = static_cast<unsigned>(static_cast<int>(i)) % kSize;
      const auto r = static_cast<unsigned>(static_cast<int>(j)) % kSize;
      return grid[r * kSize + c];
    };
    const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
    const double p = smooth(x - fx), q = smooth(y - fy);
    return (1 - q) * ((1 - p) * node(fx, fy) + p * node(fx + 1, fy)) +
           q * ((1 - p) * node(fx, fy + 1) + p * node(fx + 1, fy + 1));
  }
  std::array<double, kSize * kSize> coarse_{}, fine_{};
};

struct Look {
  double noise = 4;
  int people = 0;        // a third of the picture's height tall, not standing still
  double people_at = 0;  // shift of all of them, pixels
  std::uint32_t seed = 1;
};

image::Frame picture(const Surroundings& world, const geometry::CameraEstimate& camera,
                     const Look& look) {
  const int width = camera.model.width, height = camera.model.height;
  std::mt19937 random(look.seed), places(99);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> unit(0, 1);
  image::Image<float> luma(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      luma(x, y) = static_cast<float>(world.at(
          geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)})));
  for (int i = 0; i < look.people; ++i) {
    const int left = static_cast<int>(unit(places) * width + look.people_at);
    const int top = static_cast<int>(unit(places) * height * 0.6);
    for (int y = top; y < std::min(height, top + height / 3); ++y)
      for (int x = std::max(0, left); x < std::min(width, left + height / 9); ++x)
        luma(x, y) = 300.0F + 200.0F * static_cast<float>(((x - left) / 8 + (y - top) / 8) % 3);
  }
  image::Frame frame;
  frame.planes = {image::Image<std::uint16_t>(width, height),
                  image::Image<std::uint16_t>(width / 2, height, 512),
                  image::Image<std::uint16_t>(width / 2, height, 512)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      frame.planes[0](x, y) = static_cast<std::uint16_t>(
          std::clamp(std::lround(luma(x, y) + look.noise * gauss(random)), 4L, 1019L));
  return frame;
}

image::PlateSnapshot plate_of(const Surroundings& world, const Eigen::Vector3d& centre,
                              double focal, double pan_deg, double tilt_deg, double reach_deg) {
  image::PlateSnapshot plate;
  plate.version = 1;
  plate.centre_in_world = centre;
  plate.radians_per_px = 1 / focal;
  const double u = pan_deg * kRadians * focal, v = -tilt_deg * kRadians * focal;
  const double reach = reach_deg * kRadians * focal;
  const auto tile_of = [](double p) {
    return static_cast<int>(std::floor(p / image::kPlateTileSize));
  };
  for (int row = tile_of(v - reach); row <= tile_of(v + reach); ++row)
    for (int column = tile_of(u - reach); column <= tile_of(u + reach); ++column) {
      image::PlateTile tile;
      for (auto& plane : tile.mean)
        plane = image::Image<std::uint16_t>(image::kPlateTileSize, image::kPlateTileSize, 8192);
      for (auto& plane : tile.deviation)
        plane = image::Image<std::uint16_t>(image::kPlateTileSize, image::kPlateTileSize, 64);
      tile.count = image::Image<std::uint8_t>(image::kPlateTileSize, image::kPlateTileSize, 20);
      for (int y = 0; y < image::kPlateTileSize; ++y)
        for (int x = 0; x < image::kPlateTileSize; ++x) {
          const Eigen::Vector2d place(column * image::kPlateTileSize + x,
                                      row * image::kPlateTileSize + y);
          tile.mean[0](x, y) =
              static_cast<std::uint16_t>(16 * world.at(image::direction_from_plate(plate, place)));
        }
      plate.tiles.emplace(image::PlateTileKey{column, row}, std::move(tile));
    }
  return plate;
}

geometry::CameraEstimate near(const geometry::CameraEstimate& camera, double sd_px) {
  geometry::CameraEstimate prior = camera;
  prior.covariance.setZero();
  prior.covariance(0, 0) = prior.covariance(1, 1) = std::pow(sd_px / camera.model.fx, 2);
  prior.covariance(3, 3) = 0.01 * 0.01;
  return prior;
}

geometry::CameraEstimate surely(geometry::CameraEstimate camera) {
  camera.covariance.setZero();
  camera.covariance.diagonal().head<4>() = Eigen::Vector4d(1e-10, 1e-10, 1e-10, 1e-9);
  return camera;
}

// Root mean square distance between two cameras' images of the same directions.
double picture_rms(const geometry::CameraEstimate& truth, const geometry::CameraEstimate& found) {
  double sum = 0;
  int count = 0;
  for (int y = 20; y < truth.model.height; y += 50)
    for (int x = 20; x < truth.model.width; x += 50) {
      const Eigen::Vector3d ray =
          geometry::ray_in_world(truth, {static_cast<double>(x), static_cast<double>(y)});
      const auto b = found.model.project(found.cam_from_world.rotation * ray);
      sum += b ? (*b - Eigen::Vector2d(x, y)).squaredNorm() : 1e6;
      ++count;
    }
  return std::sqrt(sum / count);
}

geometry::Mount close_mount() {
  geometry::Mount mount = test_mount();
  mount.lens = {{2000, -0.05, 0.02}, {6000, 0.02, -0.1}};
  return mount;
}

TEST(PlateRegistration, FindsThePoseOfAPictureInThePlateBelowAPixelAndWithinItsCovariance) {
  ASSERT_TRUE(RegistrationOptions{}.validate().has_value());
  const Surroundings world(3);
  const geometry::Mount mount = close_mount();
  auto plate = std::make_shared<image::PlateSnapshot>(
      plate_of(world, mount.position_in_world, 3200, 5, -10, 14));
  double normalised = 0;
  for (int k = 0; k < 6; ++k) {
    const auto truth = camera_at(mount, 4 + 0.3 * k, -10 + 0.2 * k, 2900 + 40 * k);
    const auto guess = camera_at(mount, 4.25 + 0.3 * k, -10.1 + 0.2 * k, 2915 + 40 * k);
    PlateRegistration registration(mount, {});
    registration.use_plate(plate);
    const Registration found = registration.track(
        picture(world, truth, {4, 0, 0, static_cast<std::uint32_t>(k)}), near(guess, 15));
    ASSERT_FALSE(found.lost()) << k << " " << found.result.report.stopped_because;
    EXPECT_EQ(found.result.estimate.evidence, geometry::Evidence::kPlate);
    EXPECT_LT(picture_rms(truth, found.result.estimate), 0.3) << k;
    const geometry::HeadPose a = head_pose(mount, truth);
    const geometry::HeadPose b = head_pose(mount, found.result.estimate);
    const Eigen::Vector2d off(b.pan - a.pan, b.tilt - a.tilt);
    const Eigen::Matrix2d spread = found.result.estimate.covariance.topLeftCorner<2, 2>();
    normalised += off.dot(spread.inverse() * off) / 2;
  }
  EXPECT_LT(normalised / 6, 3);
}

TEST(PlateRegistration, FollowsAViewThatWasSolvedBefore) {
  const Surroundings world(4);
  const geometry::Mount mount = close_mount();
  PlateRegistration registration(mount, {});
  const auto first = camera_at(mount, 0, -8, 3000);
  registration.learn(picture(world, first, {}), surely(first));
  EXPECT_EQ(registration.views(), 1U);
  geometry::CameraEstimate last = first;
  for (int k = 1; k <= 14; ++k) {
    // More than half a picture's width a second, at 25 frames a second.
    const auto truth = camera_at(mount, 0.5 * k, -8 + 0.02 * k, 3000 * (1 + 0.004 * k));
    const image::Frame frame = picture(world, truth, {4, 0, 0, static_cast<std::uint32_t>(k)});
    const Registration found = registration.track(frame, near(last, 10));
    ASSERT_FALSE(found.lost()) << k << " " << found.result.report.stopped_because;
    EXPECT_LT(picture_rms(truth, found.result.estimate), 1) << k;
    last = found.result.estimate;
    registration.learn(frame, last);
  }
  EXPECT_GT(registration.views(), 1U);
}

TEST(PlateRegistration, PeopleWhoMoveDoNotMoveIt) {
  const Surroundings world(5);
  const geometry::Mount mount = close_mount();
  const auto first = camera_at(mount, 0, -8, 3000);
  const auto truth = camera_at(mount, 0.4, -8.05, 3010);
  PlateRegistration registration(mount, {});
  registration.learn(picture(world, first, {4, 8, 0, 1}), surely(first));
  // The head follows them: they stay where they are in the picture.
  const Registration found =
      registration.track(picture(world, truth, {4, 8, 5, 2}), near(first, 10));
  ASSERT_FALSE(found.lost()) << found.result.report.stopped_because;
  EXPECT_LT(picture_rms(truth, found.result.estimate), 0.5);
}

TEST(PlateRegistration, RefusesAPictureOfAnotherPlaceAndOneWithoutTexture) {
  const Surroundings world(6), elsewhere(7);
  const geometry::Mount mount = close_mount();
  const auto camera = camera_at(mount, 0, -8, 3000);
  PlateRegistration registration(mount, {});
  EXPECT_TRUE(registration.track(picture(world, camera, {}), near(camera, 10)).lost());
  registration.learn(picture(world, camera, {}), surely(camera));
  for (std::uint32_t seed = 0; seed < 4; ++seed) {
    const auto other = registration.track(
        picture(elsewhere, camera_at(mount, 3.0 * seed, -8, 3000), {4, 4, 0, seed}),
        near(camera, 10));
    EXPECT_TRUE(other.lost());
    EXPECT_FALSE(other.result.report.stopped_because.empty());
  }
  image::Frame flat = picture(world, camera, {});
  flat.planes[0] = image::Image<std::uint16_t>(mount.width, mount.height, 500);
  EXPECT_TRUE(registration.track(flat, near(camera, 10)).lost());
  EXPECT_TRUE(registration.recover(flat).lost());
  EXPECT_TRUE(registration.recover(picture(elsewhere, camera, {})).lost());
}

TEST(PlateRegistration, RecoversFromTheViewsItKept) {
  const Surroundings world(8);
  const geometry::Mount mount = close_mount();
  PlateRegistration registration(mount, {});
  for (const double pan : {-20.0, 0.0, 20.0})
    registration.learn(picture(world, camera_at(mount, pan, -8, 3000), {}),
                       surely(camera_at(mount, pan, -8, 3000)));
  ASSERT_EQ(registration.views(), 3U);
  const auto truth = camera_at(mount, 20.5, -8.2, 3030);
  const Registration found = registration.recover(picture(world, truth, {4, 3, 0, 9}));
  ASSERT_FALSE(found.lost()) << found.result.report.stopped_because;
  EXPECT_LT(picture_rms(truth, found.result.estimate), 0.5);
}

TEST(PlateRegistration, SaysHowFarItMayHaveDriftedAndGivesUpThen) {
  const Surroundings world(9);
  const geometry::Mount mount = close_mount();
  const auto camera = camera_at(mount, 0, -8, 3000);
  const image::Frame frame = picture(world, camera, {});
  PlateRegistration sure(mount, {}), unsure(mount, {}), adrift(mount, {});
  geometry::CameraEstimate doubtful = camera;
  doubtful.covariance(0, 0) = doubtful.covariance(1, 1) = std::pow(2.0 / 3000, 2);
  geometry::CameraEstimate lost_way = camera;
  lost_way.covariance(0, 0) = std::pow(20.0 / 3000, 2);
  sure.learn(frame, surely(camera));
  unsure.learn(frame, doubtful);
  adrift.learn(frame, lost_way);
  const Registration a = sure.track(frame, near(camera, 10));
  const Registration b = unsure.track(frame, near(camera, 10));
  ASSERT_FALSE(a.lost());
  ASSERT_FALSE(b.lost());
  EXPECT_LT(std::sqrt(a.result.estimate.covariance(0, 0)) * 3000, 0.5);
  EXPECT_GT(std::sqrt(b.result.estimate.covariance(0, 0)) * 3000, 1.9);
  EXPECT_TRUE(adrift.track(frame, near(camera, 10)).lost());
  // A surer view of the same place takes the other's.
  unsure.learn(frame, surely(camera));
  EXPECT_EQ(unsure.views(), 1U);
  EXPECT_LT(
      std::sqrt(unsure.track(frame, near(camera, 10)).result.estimate.covariance(0, 0)) * 3000,
      0.5);
}

TEST(PlateRegistration, OptionsNameFieldAndBound) {
  RegistrationOptions options;
  options.least_share = 0;
  const auto status = options.validate();
  ASSERT_FALSE(status.has_value());
  EXPECT_NE(status.error().where.find("least_share"), std::string::npos);
}

}  // namespace
}  // namespace touchline::calibrate
