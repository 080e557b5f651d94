#include "edge/encode/features.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/features2d.hpp>
#include <tuple>

namespace touchline::encode {
namespace {

using geometry::Feature;
using image::Rect;

constexpr int kBorder = 20;  // ORB looks so far round a point
constexpr int kPatch = 31;
constexpr int kFastThreshold = 12;  // of 255

struct Scored {
  Feature feature;
  float response = 0;
};

Rect grown_inside(const Rect& rect, int by, int width, int height) {
  const int x = std::max(0, rect.x - by);
  const int y = std::max(0, rect.y - by);
  return {x, y, std::min(width, rect.x + rect.width + by) - x,
          std::min(height, rect.y + rect.height + by) - y};
}

void find_in(const image::Frame& frame, const image::Matte& matte, const Rect& box, int most,
             std::vector<Scored>& found) {
  const Rect area = grown_inside(box, kBorder, frame.width(), frame.height());
  cv::Mat1b luma(area.height, area.width);
  cv::Mat1b mask(area.height, area.width, std::uint8_t{0});
  for (int y = 0; y < area.height; ++y) {
    const std::uint16_t* const from = frame.planes[0].row(area.y + y) + area.x;
    const std::uint8_t* const alpha = matte.alpha.row(area.y + y) + area.x;
    for (int x = 0; x < area.width; ++x) {
      luma(y, x) = static_cast<std::uint8_t>(from[x] >> 2);
      mask(y, x) = alpha[x] >= 128 && box.contains(area.x + x, area.y + y) ? 255 : 0;
    }
  }
  const cv::Ptr<cv::ORB> orb = cv::ORB::create(most, 1.2f, 1, kPatch / 2 + 1, 0, 2,
                                               cv::ORB::HARRIS_SCORE, kPatch, kFastThreshold);
  std::vector<cv::KeyPoint> points;
  cv::Mat descriptors;
  orb->detectAndCompute(luma, mask, points, descriptors);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const cv::KeyPoint& point = points[i];
    Scored one;
    one.response = point.response;
    one.feature.position = {point.pt.x + static_cast<float>(area.x),
                            point.pt.y + static_cast<float>(area.y)};
    one.feature.scale = point.size;
    const float angle = point.angle * std::numbers::pi_v<float> / 180;
    one.feature.angle =
        angle > std::numbers::pi_v<float> ? angle - 2 * std::numbers::pi_v<float> : angle;
    const std::uint8_t* const bytes = descriptors.ptr<std::uint8_t>(static_cast<int>(i));
    one.feature.descriptor.assign(bytes, bytes + descriptors.cols);
    found.push_back(std::move(one));
  }
}

}  // namespace

std::vector<Feature> find_features(const image::Frame& frame, const image::Matte& matte,
                                   const std::vector<Rect>& boxes, int most) {
  if (most <= 0) return {};
  const auto side = [](const Rect& box) {
    return std::sqrt(static_cast<double>(box.width) * box.height);
  };
  double sides = 0;
  for (const Rect& box : boxes) sides += side(box);
  std::vector<Scored> found;
  for (const Rect& box : boxes) {
    const int share = static_cast<int>(std::ceil(1.5 * most * side(box) / sides)) + 1;
    find_in(frame, matte, box, std::min(most, share), found);
  }
  std::sort(found.begin(), found.end(), [](const Scored& a, const Scored& b) {
    return std::tuple(-a.response, a.feature.position.y(), a.feature.position.x()) <
           std::tuple(-b.response, b.feature.position.y(), b.feature.position.x());
  });
  if (found.size() > static_cast<std::size_t>(most)) found.resize(static_cast<std::size_t>(most));
  std::vector<Feature> features;
  for (Scored& one : found) features.push_back(std::move(one.feature));
  return features;
}

}  // namespace touchline::encode
