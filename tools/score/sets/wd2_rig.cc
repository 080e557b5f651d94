#include "tools/score/sets/wd2_rig.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <utility>

#include "hub/hull/carve.h"
#include "shared/image/colour.h"
#include "tools/score/oracle.h"
#include "tools/score/series.h"
#include "tools/score/sets/multiview_wd2_person.h"
#include "tools/score/sets/set_pictures.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

constexpr int kTileMargin = 16;    // pixels round the person
constexpr double kFarBelow = 1.0;  // metres that the floor is put down while it is not known
constexpr std::size_t kLeast = 4;  // cameras

// The point nearest to the rays through the middles of the masks.
Eigen::Vector3d middle_of(const std::vector<Wd2Camera>& cameras) {
  Eigen::Matrix3d left = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Wd2Camera& camera : cameras) {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    double count = 0;
    for (int y = 0; y < camera.mask.height(); ++y) {
      for (int x = 0; x < camera.mask.width(); ++x) {
        if (camera.mask(x, y) < 128) continue;
        sum += Eigen::Vector2d(x, y);
        count += 1;
      }
    }
    if (count == 0) continue;
    const Eigen::Vector3d ray = geometry::ray_in_world(camera.estimate, sum / count);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray * ray.transpose();
    left += across;
    right += across * geometry::position_in_world(camera.estimate);
  }
  return left.ldlt().solve(right);
}

// Normal of the plane through the cameras, away from the side that their pictures call down.
Eigen::Vector3d up_of(const std::vector<Wd2Camera>& cameras) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const Wd2Camera& camera : cameras) {
    mean += geometry::position_in_world(camera.estimate) / static_cast<double>(cameras.size());
    up -= camera.estimate.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitY();
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Wd2Camera& camera : cameras) {
    const Eigen::Vector3d d = geometry::position_in_world(camera.estimate) - mean;
    spread += d * d.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(spread);
  Eigen::Vector3d normal = solver.eigenvectors().col(0);
  return normal.dot(up) < 0 ? Eigen::Vector3d(-normal) : normal;
}

// Height over `middle` along `up` at which the ray of a pixel passes the upright axis.
double height_on_axis(const geometry::CameraEstimate& camera, const Eigen::Vector2d& pixel,
                      const Eigen::Vector3d& middle, const Eigen::Vector3d& up) {
  const Eigen::Vector3d from = geometry::position_in_world(camera) - middle;
  const Eigen::Vector3d ray = geometry::ray_in_world(camera, pixel);
  const double across = ray.dot(up);
  const double share = (from.dot(up) * across - from.dot(ray)) / (1 - across * across);
  return (from + share * ray).dot(up);
}

// Of the highest and the lowest row of the masks: median over the cameras.
std::pair<double, double> extent(const std::vector<Wd2Camera>& cameras,
                                 const Eigen::Vector3d& middle, const Eigen::Vector3d& up) {
  std::vector<double> tops;
  std::vector<double> feet;
  for (const Wd2Camera& camera : cameras) {
    std::optional<Eigen::Vector2d> top;
    Eigen::Vector2d foot = Eigen::Vector2d::Zero();
    for (int y = 0; y < camera.mask.height(); ++y) {
      for (int x = 0; x < camera.mask.width(); ++x) {
        if (camera.mask(x, y) < 128) continue;
        if (!top) top = Eigen::Vector2d(x, y);
        foot = Eigen::Vector2d(x, y);
      }
    }
    if (!top) continue;
    tops.push_back(height_on_axis(camera.estimate, *top, middle, up));
    feet.push_back(height_on_axis(camera.estimate, foot, middle, up));
  }
  return {quantile(feet, 0.5), quantile(tops, 0.5)};
}

// x_new = scale * turn * (x - middle), then `lift` upwards.
void move_world(Wd2Camera& camera, const Eigen::Quaterniond& turn, const Eigen::Vector3d& middle,
                double scale, double lift) {
  geometry::Rigid3& pose = camera.estimate.cam_from_world;
  const Eigen::Vector3d centre = pose.rotation * middle + pose.translation;
  pose.rotation = (pose.rotation * turn.conjugate()).normalized();
  pose.translation = scale * centre - pose.rotation * Eigen::Vector3d(0, 0, lift);
}

void make_view(Wd2Camera& camera) {
  image::Matte matte;
  matte.region = {0, 0, camera.mask.width(), camera.mask.height()};
  matte.alpha = camera.mask;
  matte.unknown = image::Image<std::uint8_t>(camera.mask.width(), camera.mask.height());
  matte.occluders = matte.unknown;
  camera.view.id.camera = base::CameraId{fmt::format("c{:02}", camera.number)};
  camera.view.estimate = camera.estimate;
  camera.view.tiles = cut_tiles(camera.frame, matte, kTileMargin);
  camera.view.matte = std::move(matte);
}

}  // namespace

base::Result<std::map<int, geometry::CameraEstimate>> parse_wd2_calibration(
    const std::string& text, const std::string& file) {
  std::istringstream in(text);
  std::map<int, geometry::CameraEstimate> out;
  int number = 0;
  while (in >> number) {
    double k[9], lens[2], pose[12];
    for (double& v : k) in >> v;
    for (double& v : lens) in >> v;
    for (double& v : pose) in >> v;
    if (!in) {
      return base::fail(base::ErrorKind::kFormat, file,
                        fmt::format("camera {} is not whole", number));
    }
    geometry::CameraEstimate camera;
    camera.model = {0, 0, k[0], k[4], k[2], k[5], lens[0], lens[1]};
    Eigen::Matrix3d rotation;
    rotation << pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10];
    const double error = (rotation * rotation.transpose() - Eigen::Matrix3d::Identity()).norm();
    if (!(k[0] > 0) || !(k[4] > 0) || !(error < 1e-2) || rotation.determinant() < 0) {
      return base::fail(base::ErrorKind::kFormat, file,
                        fmt::format("camera {} has no rotation or no focal length", number));
    }
    camera.cam_from_world.rotation = Eigen::Quaterniond(rotation).normalized();
    camera.cam_from_world.translation = Eigen::Vector3d(pose[3], pose[7], pose[11]);
    camera.evidence = geometry::Evidence::kLines;
    out[number] = camera;
  }
  if (out.empty() || !in.eof()) {
    return base::fail(base::ErrorKind::kFormat, file, "is no list of cameras");
  }
  return out;
}

base::Result<std::map<int, geometry::CameraEstimate>> read_wd2_calibration(const fs::path& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be read");
  return parse_wd2_calibration(text.str(), path.string());
}

base::Result<Wd2Rig> load_wd2_rig(const fs::path& folder, double height_m) {
  const auto calibration = read_wd2_calibration(folder / "calibParamsI.txt");
  if (!calibration) return base::fail(calibration.error());
  Wd2Rig rig;
  for (const auto& [number, estimate] : *calibration) {
    const fs::path path = folder / fmt::format("WD2_{}_00020.png", number);
    if (!fs::exists(path)) continue;
    auto picture = read_rgb(path);
    if (!picture) return base::fail(picture.error());
    auto mask = read_grey(folder / fmt::format("WD2_{}_00020_mask.png", number));
    if (!mask) return base::fail(mask.error());
    if (mask->width() != picture->width() || mask->height() != picture->height()) {
      return base::fail(base::ErrorKind::kFormat, path.string(), "has another size than its mask");
    }
    Wd2Camera camera;
    camera.number = number;
    camera.estimate = estimate;
    camera.estimate.model.width = picture->width();
    camera.estimate.model.height = picture->height();
    camera.frame = image::from_rgb(*picture, image::PixelFormat::kYuv422p10, {});
    camera.picture = std::move(*picture);
    camera.mask = std::move(*mask);
    rig.cameras.push_back(std::move(camera));
  }
  if (rig.cameras.size() < kLeast) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(),
                      fmt::format("holds {} views, {} are needed", rig.cameras.size(), kLeast));
  }
  const Eigen::Vector3d middle = middle_of(rig.cameras);
  const Eigen::Vector3d up = up_of(rig.cameras);
  const auto [foot, top] = extent(rig.cameras, middle, up);
  if (!(top > foot)) {
    return base::fail(base::ErrorKind::kNumerical, folder.string(), "the masks have no height");
  }
  rig.metres_per_unit = height_m / (top - foot);
  rig.floor.length_m = 4;
  rig.floor.width_m = 4;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ());
  std::vector<double> distances;
  std::vector<codec::CameraView> views;
  for (Wd2Camera& camera : rig.cameras) {
    move_world(camera, turn, middle, rig.metres_per_unit, kFarBelow - rig.metres_per_unit * foot);
    make_view(camera);
    views.push_back(camera.view);
  }
  hull::HullOptions options;
  options.dilation_px = 0;
  options.people_height_m = 4;
  options.margin_m = 0;
  const hull::HullResult result = hull::carve(views, rig.floor, options);
  const scene::HullGroup* person = nullptr;
  for (const scene::HullGroup& group : result.hull.groups) {
    if (person == nullptr || group.volume_m3 > person->volume_m3) person = &group;
  }
  if (person == nullptr) {
    return base::fail(base::ErrorKind::kNumerical, folder.string(), "the masks have no common hull",
                      "check the calibration");
  }
  // Feet that stand apart make masks higher than the person: the hull's height counts.
  const double scale = height_m / person->bounds.sizes().z();
  rig.metres_per_unit *= scale;
  for (Wd2Camera& camera : rig.cameras) {
    move_world(camera, Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero(), scale,
               -scale * person->bounds.min().z());
    camera.view.estimate = camera.estimate;
    distances.push_back(geometry::position_in_world(camera.estimate).head<2>().norm());
  }
  rig.camera_distance_m = quantile(distances, 0.5);
  return rig;
}

}  // namespace touchline::score
