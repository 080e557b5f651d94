#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "hub/hull/coverage_internal.h"

namespace touchline::hull {

namespace {

constexpr double kUsualHeight = 1.8;  // metres, of someone whose feet are below the picture
constexpr double kLeastHeight = 0.12;
constexpr double kMostHeight = 4;
constexpr int kSliver = 2;  // left-over rims this many pixels thick or less, on each side, are none

struct Stand {
  Eigen::Vector3d foot_in_world;
  double height_m = 0;
};

// Where an upright card with this top and bottom pixel stands.
std::optional<Stand> stand(const geometry::CameraEstimate& camera, const Eigen::Vector2d& top,
                           const Eigen::Vector2d& bottom, bool cut_below,
                           const pitch::PitchModel& pitch) {
  const Eigen::Vector3d eye = geometry::position_in_world(camera);
  const Eigen::Vector3d up_ray = geometry::ray_in_world(camera, top);
  if (cut_below) {
    // The top is at the usual height: meet the turf as seen from that much lower.
    const auto hit =
        pitch::intersect_turf(pitch, eye - Eigen::Vector3d(0, 0, kUsualHeight), up_ray);
    if (!hit) return std::nullopt;
    return Stand{*hit, kUsualHeight};
  }
  const auto foot = pitch::intersect_turf(pitch, eye, geometry::ray_in_world(camera, bottom));
  if (!foot) return std::nullopt;
  const double away = (*foot - eye).head<2>().norm();
  const double slant = up_ray.head<2>().norm();
  if (slant < 1e-6) return std::nullopt;
  const double top_z = eye.z() + up_ray.z() * away / slant;
  return Stand{*foot, top_z - foot->z()};
}

}  // namespace

std::vector<scene::Billboard> find_billboards(const SilhouetteMap& map,
                                              const base::CameraId& camera,
                                              const CameraCoverage& coverage,
                                              const pitch::PitchModel& pitch,
                                              const HullOptions& options) {
  const image::Image<std::uint8_t>& foreground = map.foreground();
  const int width = foreground.width();
  const int height = foreground.height();
  std::vector<scene::Billboard> billboards;
  cv::Mat left(height, width, CV_8UC1, cv::Scalar(0));
  std::size_t left_px = 0;
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* seen = foreground.row(y);
    const std::uint16_t* count = coverage.count.row(y);
    std::uint8_t* to = left.ptr<std::uint8_t>(y);
    unsigned in_row = 0;
    for (int x = 0; x < width; ++x) {
      const bool is = seen[x] && count[x] == 0;
      to[x] = is ? 255 : 0;
      in_row += is;
    }
    left_px += in_row;
  }
  if (left_px < static_cast<std::size_t>(options.min_billboard_px)) return billboards;
  cv::Mat core;
  cv::erode(left, core, cv::Mat(), cv::Point(-1, -1), kSliver);
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centres;
  const int pieces = cv::connectedComponentsWithStats(left, labels, stats, centres, 8, CV_32S);
  std::vector<std::uint8_t> thick(static_cast<std::size_t>(pieces));
  std::vector<double> top_sum(thick.size());
  std::vector<double> bottom_sum(thick.size());
  std::vector<int> top_count(thick.size());
  std::vector<int> bottom_count(thick.size());
  for (int y = 0; y < height; ++y) {
    const int* label = labels.ptr<int>(y);
    const std::uint8_t* inner = core.ptr<std::uint8_t>(y);
    for (int x = 0; x < width; ++x) {
      if (label[x] == 0) continue;
      const auto piece = static_cast<std::size_t>(label[x]);
      thick[piece] |= inner[x];
      const int first = stats.at<int>(label[x], cv::CC_STAT_TOP);
      if (y == first) {
        top_sum[piece] += x;
        ++top_count[piece];
      }
      if (y == first + stats.at<int>(label[x], cv::CC_STAT_HEIGHT) - 1) {
        bottom_sum[piece] += x;
        ++bottom_count[piece];
      }
    }
  }
  const double half_x = pitch.length_m / 2 + pitch.in_goal_m + options.margin_m;
  const double half_y = pitch.width_m / 2 + options.margin_m;
  for (int piece = 1; piece < pieces; ++piece) {
    const auto at = static_cast<std::size_t>(piece);
    if (!thick[at] || stats.at<int>(piece, cv::CC_STAT_AREA) < options.min_billboard_px) continue;
    const image::Rect region{
        stats.at<int>(piece, cv::CC_STAT_LEFT), stats.at<int>(piece, cv::CC_STAT_TOP),
        stats.at<int>(piece, cv::CC_STAT_WIDTH), stats.at<int>(piece, cv::CC_STAT_HEIGHT)};
    const bool cut_above = region.y <= 0;
    const bool cut_below = region.y + region.height >= height;
    if (cut_above && cut_below) continue;
    // Edges of pixels, not their centres, bound the silhouette.
    const Eigen::Vector2d top(top_sum[at] / top_count[at], region.y - 0.5);
    const Eigen::Vector2d bottom(bottom_sum[at] / bottom_count[at], region.y + region.height - 0.5);
    const auto card = stand(map.camera(), top, bottom, cut_below, pitch);
    if (!card || card->height_m < kLeastHeight || card->height_m > kMostHeight) continue;
    if (std::abs(card->foot_in_world.x()) > half_x || std::abs(card->foot_in_world.y()) > half_y) {
      continue;
    }
    billboards.push_back({0, camera, region, card->foot_in_world, card->height_m});
  }
  return billboards;
}

}  // namespace touchline::hull
