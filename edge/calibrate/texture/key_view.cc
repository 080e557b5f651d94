#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "edge/calibrate/texture/key_view_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kCell = 14;     // pixels of level 1 a cell with at most one point
constexpr int kMargin = 12;   // pixels of level 1 that a point keeps from the border
constexpr int kReach = 3;     // half width of the window that texture is summed over
constexpr int kGrid = 16;     // pixels of level 0 between directions that are worked out
constexpr double kFar = 100;  // metres, of what is not turf

// The gradient's strength in its weakest direction over the window round (x, y); 0 at unknown ones.
float weakest(const image::Image<std::uint16_t>& in, int x, int y) {
  float xx = 0, xy = 0, yy = 0;
  for (int j = y - kReach; j <= y + kReach; ++j) {
    const std::uint16_t* above = in.row(j - 1);
    const std::uint16_t* row = in.row(j);
    const std::uint16_t* below = in.row(j + 1);
    for (int i = x - kReach; i <= x + kReach; ++i) {
      if (row[i - 1] == 0 || row[i + 1] == 0 || above[i] == 0 || below[i] == 0) return 0;
      const float gx = 0.5F * static_cast<float>(row[i + 1] - row[i - 1]);
      const float gy = 0.5F * static_cast<float>(below[i] - above[i]);
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  constexpr float kArea = (2 * kReach + 1) * (2 * kReach + 1);
  const float half_trace = (xx + yy) / 2;
  const float root = std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
  return std::sqrt(std::max(0.0F, half_trace - root) / kArea) / 16;
}

// The best place of every cell, where it has texture enough.
std::vector<KeyPoint> pick_points(const LumaPyramid& pyramid,
                                  const geometry::CameraEstimate& camera, double least_texture) {
  const image::Image<std::uint16_t>& in = pyramid.level[1];
  std::vector<KeyPoint> points;
  for (int top = kMargin; top < in.height() - kMargin; top += kCell)
    for (int left = kMargin; left < in.width() - kMargin; left += kCell) {
      float best = 0;
      Eigen::Vector2d place(0, 0);
      const int bottom = std::min(top + kCell, in.height() - kMargin);
      const int right = std::min(left + kCell, in.width() - kMargin);
      for (int y = top; y < bottom; y += 3)
        for (int x = left; x < right; x += 3) {
          const float texture = weakest(in, x, y);
          if (texture <= best) continue;
          best = texture;
          place = Eigen::Vector2d(x, y);
        }
      if (best < static_cast<float>(least_texture)) continue;
      KeyPoint point;
      point.pixel = pyramid.in_picture(place, 1);
      point.point_in_world = scene_point(camera, point.pixel);
      point.texture = best;
      points.push_back(point);
    }
  return points;
}

// Bilinear luma of the plate; 0 where it is unknown or does not stand still.
class PlateReader {
 public:
  PlateReader(const image::PlateSnapshot& plate, const PlateViewOptions& options)
      : plate_(plate),
        least_count_(options.least_count),
        most_deviation_(static_cast<int>(16 * options.most_deviation)),
        turn_(2 * std::numbers::pi / plate.radians_per_px) {}

  double turn() const { return turn_; }

  int at(double u, double v) {
    u -= turn_ * std::round(u / turn_);
    const double fu = std::floor(u), fv = std::floor(v);
    const int x = static_cast<int>(fu), y = static_cast<int>(fv);
    const int a = sample(x, y), b = sample(x + 1, y), c = sample(x, y + 1),
              d = sample(x + 1, y + 1);
    if (a == 0 || b == 0 || c == 0 || d == 0) return 0;
    const double p = u - fu, q = v - fv;
    return static_cast<int>((1 - q) * ((1 - p) * a + p * b) + q * ((1 - p) * c + p * d) + 0.5);
  }

 private:
  int sample(int x, int y) {
    constexpr int kBits = 8;
    static_assert(image::kPlateTileSize == 1 << kBits);
    const image::PlateTileKey key{x >> kBits, y >> kBits};
    if (!asked_ || key != key_) {
      const auto found = plate_.tiles.find(key);
      tile_ = found == plate_.tiles.end() ? nullptr : &*found->second;
      key_ = key;
      asked_ = true;
    }
    if (tile_ == nullptr) return 0;
    const int i = x & (image::kPlateTileSize - 1), j = y & (image::kPlateTileSize - 1);
    if (tile_->count(i, j) < least_count_ || tile_->deviation[0](i, j) > most_deviation_) return 0;
    return std::max<int>(1, tile_->mean[0](i, j));
  }

  const image::PlateSnapshot& plate_;
  int least_count_;
  int most_deviation_;
  double turn_;
  image::PlateTileKey key_;
  const image::PlateTile* tile_ = nullptr;
  bool asked_ = false;
};

}  // namespace

Eigen::Vector3d scene_point(const geometry::CameraEstimate& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  const Eigen::Vector3d ray = geometry::ray_in_world(camera, pixel);
  const bool turf = eye.z() > 0 && -ray.z() * kFar > eye.z();
  return eye + (turf ? -eye.z() / ray.z() : kFar) * ray;
}

KeyView view_of_frame(const image::Frame& frame, const geometry::CameraEstimate& camera,
                      double least_texture) {
  KeyView view;
  view.pyramid = make_pyramid(frame.luma());
  view.camera = camera;
  view.points = pick_points(view.pyramid, camera, least_texture);
  return view;
}

std::optional<KeyView> view_of_plate(const image::PlateSnapshot& plate,
                                     const geometry::CameraEstimate& camera, double least_texture,
                                     const PlateViewOptions& options) {
  if (plate.tiles.empty() || !(plate.radians_per_px > 0)) return std::nullopt;
  const double plate_px = camera.model.fx * plate.radians_per_px;
  if (plate_px > options.most_plate_px) return std::nullopt;
  const int shift = pyramid_shift(camera.model.width);
  const int scale = 1 << shift;
  image::Image<std::uint16_t> base(camera.model.width >> shift, camera.model.height >> shift);
  const int columns = base.width() / kGrid + 2;
  const int rows = base.height() / kGrid + 2;
  std::vector<Eigen::Vector2d> nodes;
  const double turn = 2 * std::numbers::pi / plate.radians_per_px;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector2d pixel((column * kGrid + 0.5) * scale - 0.5,
                                  (row * kGrid + 0.5) * scale - 0.5);
      Eigen::Vector2d node =
          image::plate_from_direction(plate, geometry::ray_in_world(camera, pixel));
      if (!nodes.empty()) node.x() -= turn * std::round((node.x() - nodes[0].x()) / turn);
      nodes.push_back(node);
    }
  // Plate pixels a pixel of the view, and samples of the plate that go into one.
  const double step = scale / (camera.model.fx * plate.radians_per_px);
  const int taps = std::clamp(static_cast<int>(step / 2 + 0.5), 1, 4);
  PlateReader reader(plate, options);
  std::size_t known = 0;
  for (int y = 0; y < base.height(); ++y) {
    const int row = y / kGrid;
    const double q = static_cast<double>(y % kGrid) / kGrid;
    for (int x = 0; x < base.width(); ++x) {
      const auto n = static_cast<std::size_t>(row * columns + x / kGrid);
      const auto below = n + static_cast<std::size_t>(columns);
      const double p = static_cast<double>(x % kGrid) / kGrid;
      const Eigen::Vector2d place = (1 - q) * ((1 - p) * nodes[n] + p * nodes[n + 1]) +
                                    q * ((1 - p) * nodes[below] + p * nodes[below + 1]);
      int sum = 0;
      bool all = true;
      for (int j = 0; all && j < taps; ++j)
        for (int i = 0; all && i < taps; ++i) {
          const double across = (i - 0.5 * (taps - 1)) * step / taps;
          const double down = (j - 0.5 * (taps - 1)) * step / taps;
          const int value = reader.at(place.x() + across, place.y() + down);
          all = value > 0;
          sum += value;
        }
      if (!all) continue;
      base(x, y) = static_cast<std::uint16_t>(sum / (taps * taps));
      ++known;
    }
  }
  if (static_cast<double>(known) < options.least_share * static_cast<double>(base.size()))
    return std::nullopt;
  KeyView view;
  view.pyramid = make_pyramid(std::move(base), shift);
  view.camera = camera;
  view.camera.covariance.setZero();
  view.points = pick_points(view.pyramid, view.camera, least_texture);
  view.from_plate = true;
  view.plate_px = std::max(1.0, plate_px);
  return view;
}

}  // namespace touchline::calibrate
