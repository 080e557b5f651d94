#include "tools/score/matte_score.h"

#include <algorithm>
#include <cstdlib>
#include <opencv2/imgproc.hpp>

namespace touchline::score {

namespace {

constexpr std::uint8_t kForeground = 128;
constexpr float kMostDistance = 20;

double ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

// 255 on foreground pixels that have a neighbour (of 4) outside.
cv::Mat boundary_of(const image::Image<std::uint8_t>& alpha) {
  cv::Mat mask(alpha.height(), alpha.width(), CV_8UC1);
  for (int y = 0; y < alpha.height(); ++y) {
    for (int x = 0; x < alpha.width(); ++x) {
      mask.at<std::uint8_t>(y, x) = alpha(x, y) >= kForeground ? 255 : 0;
    }
  }
  cv::Mat inner;
  cv::erode(mask, inner, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
  return mask - inner;
}

void add_distances(MatteScore& score, const cv::Mat& of, const cv::Mat& to) {
  cv::Mat away;
  cv::distanceTransform(255 - to, away, cv::DIST_L2, cv::DIST_MASK_PRECISE);
  for (int y = 0; y < of.rows; ++y) {
    for (int x = 0; x < of.cols; ++x) {
      if (!of.at<std::uint8_t>(y, x)) continue;
      score.boundary_sum_px += static_cast<double>(std::min(away.at<float>(y, x), kMostDistance));
      ++score.boundary_count;
    }
  }
}

}  // namespace

double MatteScore::iou() const { return ratio(both_px, true_px + found_px - both_px); }
double MatteScore::missing_share() const { return ratio(true_px - both_px, true_px); }
double MatteScore::extra_share() const { return ratio(found_px - both_px, true_px); }
double MatteScore::mean_alpha_error() const { return ratio(alpha_error, alpha_px); }
double MatteScore::mean_boundary_px() const { return ratio(boundary_sum_px, boundary_count); }

void add_matte(MatteScore& score, const image::Image<std::uint8_t>& truth,
               const image::Image<std::uint8_t>& found) {
  ++score.frames;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const int t = truth.data()[i];
    const int f = found.data()[i];
    score.true_px += t >= kForeground;
    score.found_px += f >= kForeground;
    score.both_px += t >= kForeground && f >= kForeground;
    if (t == 0 && f == 0) continue;
    score.alpha_error += std::abs(t - f) / 255.0;
    ++score.alpha_px;
  }
  const cv::Mat a = boundary_of(truth);
  const cv::Mat b = boundary_of(found);
  add_distances(score, a, b);
  add_distances(score, b, a);
}

}  // namespace touchline::score
