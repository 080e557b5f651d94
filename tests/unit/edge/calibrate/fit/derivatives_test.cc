// Every derivative that is written by hand, against automatic differentiation of the projection.
#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "edge/calibrate/fit/pose_model_internal.h"
#include "edge/calibrate/initialise/refine_row_internal.h"

namespace touchline::calibrate {
namespace {

template <typename T>
using Vector2 = Eigen::Matrix<T, 2, 1>;
template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;
template <typename T>
using Matrix3 = Eigen::Matrix<T, 3, 3>;

template <typename T>
Matrix3<T> about(int axis, const T& angle) {
  using std::cos;
  using std::sin;
  const int i = (axis + 1) % 3, k = (axis + 2) % 3;
  Matrix3<T> out = Matrix3<T>::Zero();
  out(axis, axis) = T(1);
  out(i, i) = out(k, k) = cos(angle);
  out(k, i) = sin(angle);
  out(i, k) = -sin(angle);
  return out;
}

// Design section 2: at 0, 0, 0 the camera looks along +Y with +X to its right.
template <typename T>
Matrix3<T> cam_from_head(const T& pan, const T& tilt, const T& roll) {
  Matrix3<T> axes = Matrix3<T>::Zero();
  axes(0, 0) = axes(2, 1) = T(1);
  axes(1, 2) = T(-1);
  return about<T>(2, -roll) * axes * about<T>(0, -tilt) * about<T>(2, pan);
}

// k1 r^2 and k2 r^4 are linear in log focal length between knots and held beyond them.
template <typename T>
void lens_at(const geometry::Mount& mount, const T& log_focal, T& k1, T& k2) {
  const auto& lens = mount.lens;
  std::size_t high = 0;
  while (high < lens.size() && T(std::log(lens[high].focal_px)) < log_focal) ++high;
  const std::size_t low = high == 0 ? 0 : high - 1;
  high = std::min(high, lens.size() - 1);
  const double from = std::log(lens[low].focal_px), to = std::log(lens[high].focal_px);
  const T share = to > from ? (log_focal - from) / (to - from) : T(0);
  const auto mix = [&](double a, double b, int power) {
    const double shift_low = a * std::exp(-power * from), shift_high = b * std::exp(-power * to);
    return (shift_low + share * (shift_high - shift_low)) * exp(double(power) * log_focal);
  };
  k1 = mix(lens[low].k1, lens[high].k1, 2);
  k2 = mix(lens[low].k2, lens[high].k2, 4);
}

// The whole projection. `by_mount` are changes of what geometry::Mount::covariance is of.
template <typename T>
Vector2<T> image(const geometry::Mount& mount, const std::array<T, 9>& pose,
                 const std::array<T, kMountErrors>& by_mount, const Eigen::Vector3d& point,
                 const Eigen::Matrix3d& by_size) {
  Vector3<T> from_mount;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    from_mount(i) = T(point(i) - mount.position_in_world(i)) - by_mount[k] - pose[6 + k];
    for (std::size_t size = 0; size < 3; ++size)
      from_mount(i) += by_size(i, static_cast<int>(size)) * by_mount[9 + size];
  }
  const Matrix3<T> world_from_head =
      about<T>(1, by_mount[4] + mount.level_y) * about<T>(0, by_mount[3] + mount.level_x);
  Vector3<T> p =
      cam_from_head(pose[0], pose[1], pose[2]) * (world_from_head.transpose() * from_mount);
  p.z() -= by_mount[7] + mount.pupil_offset_m +
           (by_mount[8] + mount.pupil_by_log_focal_m) * (pose[3] - std::log(mount.width));
  const T focal = exp(pose[3]);
  T k1, k2;
  lens_at(mount, pose[3], k1, k2);
  const T s = 0.25 * (std::pow(mount.width, 2) + std::pow(mount.height, 2)) / (focal * focal);
  k1 += pose[4] + by_mount[12] / s;
  k2 += pose[5] + by_mount[13] / (s * s);
  return geometry::project_point<T>(p, focal, focal, by_mount[5] + mount.cx, by_mount[6] + mount.cy,
                                    k1, k2);
}

struct Drawn {
  geometry::Mount mount;
  PoseVector pose;
  Eigen::Vector3d point;
  Eigen::Matrix3d by_size;
};

class Draw {
 public:
  explicit Draw(std::uint32_t seed) : engine_(seed) {}
  double operator()(double most) { return most * unit_(engine_); }

  Drawn scene() {
    Draw& draw = *this;
    Drawn out;
    out.mount.position_in_world = {draw(40), -70 + draw(15), 18 + draw(8)};
    out.mount.level_x = draw(0.02);
    out.mount.level_y = draw(0.02);
    out.mount.width = 1920;
    out.mount.height = 1080;
    out.mount.cx = 959.5 + draw(20);
    out.mount.cy = 539.5 + draw(20);
    out.mount.pupil_offset_m = draw(0.3);
    out.mount.pupil_by_log_focal_m = draw(0.1);
    const double focal = 3000 * std::exp(draw(0.9));
    out.mount.lens = {{900, draw(0.05), draw(0.02)},
                      {0.8 * focal, draw(0.05), draw(0.05)},
                      {1.3 * focal, draw(0.1), draw(0.1)}};
    const Eigen::Vector3d aim(draw(50), draw(30), 0);
    const Eigen::Vector3d to = aim - out.mount.position_in_world;
    out.pose << std::atan2(to.x(), to.y()), std::asin(to.z() / to.norm()), draw(0.1),
        std::log(focal), draw(0.02), draw(0.02), draw(0.3), draw(0.3), draw(0.3);
    out.point = aim + Eigen::Vector3d(draw(5), draw(5), draw(1));
    for (int i = 0; i < 9; ++i) out.by_size(i / 3, i % 3) = draw(1);
    return out;
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> unit_{-1, 1};
};

constexpr int kDraws = 300;

TEST(Derivatives, OfAPixelByThePose) {
  using T = ceres::Jet<double, 9>;
  Draw draw(1);
  for (int n = 0; n < kDraws; ++n) {
    const Drawn d = draw.scene();
    std::array<T, 9> pose;
    for (int i = 0; i < 9; ++i) pose[static_cast<std::size_t>(i)] = T(d.pose(i), i);
    std::array<T, kMountErrors> none;
    none.fill(T(0));
    const auto truth = image<T>(d.mount, pose, none, d.point, d.by_size);
    const auto found = PoseModel(d.mount, d.pose).project(d.point);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->pixel.x(), truth.x().a, 1e-7);
    EXPECT_NEAR(found->pixel.y(), truth.y().a, 1e-7);
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector2d column(truth.x().v(i), truth.y().v(i));
      // The lens over zoom is followed by a difference over half a percent.
      const double tolerance = i == 3 ? 3e-4 : 1e-9;
      EXPECT_LT((found->by_pose.col(i) - column).norm(), tolerance * (1 + column.norm()))
          << "draw " << n << " column " << i;
    }
  }
}

TEST(Derivatives, OfAPixelByTheMount) {
  using T = ceres::Jet<double, kMountErrors>;
  Draw draw(2);
  for (int n = 0; n < kDraws; ++n) {
    const Drawn d = draw.scene();
    std::array<T, 9> pose;
    for (int i = 0; i < 9; ++i) pose[static_cast<std::size_t>(i)] = T(d.pose(i));
    std::array<T, kMountErrors> changes;
    for (int i = 0; i < kMountErrors; ++i) changes[static_cast<std::size_t>(i)] = T(0, i);
    const auto truth = image<T>(d.mount, pose, changes, d.point, d.by_size);
    const auto found = PoseModel(d.mount, d.pose).by_mount(d.point, d.by_size);
    ASSERT_TRUE(found.has_value());
    for (int i = 0; i < kMountErrors; ++i) {
      const Eigen::Vector2d column(truth.x().v(i), truth.y().v(i));
      EXPECT_LT((found->col(i) - column).norm(), 1e-9 * (1 + column.norm()))
          << "draw " << n << " column " << i;
    }
  }
}

TEST(Derivatives, OfTheSearchsRefinement) {
  using T = ceres::Jet<double, 8>;
  Draw draw(3);
  for (int n = 0; n < kDraws; ++n) {
    const Drawn d = draw.scene();
    Pose pose;
    pose.model = geometry::camera_model(d.mount, std::exp(d.pose(3)));
    pose.rotation = PoseModel(d.mount, d.pose).cam_from_world().rotation.toRotationMatrix();
    pose.position = d.mount.position_in_world;
    const geometry::CameraModel& m = pose.model;
    const double corner = std::hypot(0.5 * m.width, 0.5 * m.height) / m.fx;
    std::array<T, 8> u;
    for (int i = 0; i < 8; ++i) u[static_cast<std::size_t>(i)] = T(0, i);
    // A turn by a small vector w takes p to p + w x p.
    Vector3<T> away;
    for (int i = 0; i < 3; ++i)
      away(i) = T(d.point(i) - pose.position(i)) - u[static_cast<std::size_t>(3 + i)];
    const Vector3<T> p = pose.rotation.cast<T>() * away;
    const Vector3<T> w(u[0], u[1], u[2]);
    const T focal = m.fx * exp(u[6]);
    const Vector3<T> turned = p + w.cross(p);
    const auto truth = geometry::project_point<T>(turned, focal, focal, T(m.cx), T(m.cy),
                                                  m.k1 + u[7] / (corner * corner), T(m.k2));
    const double angle = draw(3.14);
    const Eigen::Vector2d normal(std::cos(angle), std::sin(angle));
    const auto found = refine_point(pose, 1e9, d.point);
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->pixel.x(), truth.x().a, 1e-7);
    const RefineRow row = refine_row(pose, corner, *found, normal);
    for (int i = 0; i < 8; ++i) {
      const double expected = normal.x() * truth.x().v(i) + normal.y() * truth.y().v(i);
      EXPECT_NEAR(row(i), expected, 1e-9 * (1 + std::abs(expected))) << "draw " << n << " of " << i;
    }
  }
}

// Where the lens folds, the distorted radius no longer grows.
TEST(Derivatives, OfTheDistortedRadiusAtTheFold) {
  using T = ceres::Jet<double, 1>;
  Draw draw(4);
  for (int n = 0; n < kDraws; ++n) {
    geometry::CameraModel model;
    model.k1 = draw(0.3);
    model.k2 = draw(0.3);
    const double fold = model.fold_radius_squared();
    if (!std::isfinite(fold)) continue;
    const T r(std::sqrt(fold), 0);
    const T distorted = r * (1.0 + r * r * (model.k1 + model.k2 * r * r));
    EXPECT_NEAR(distorted.v(0), 0, 1e-9 * (1 + fold * fold)) << model.k1 << " " << model.k2;
  }
}

}  // namespace
}  // namespace touchline::calibrate
