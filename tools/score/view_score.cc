#include "tools/score/view_score.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace touchline::score {

namespace {

constexpr int kDilation = 8;
constexpr int kMostShift = 6;
constexpr double kBestPsnr = 99;  // of equal pictures

double psnr_of(double squares, double samples) {
  if (samples <= 0 || squares <= 0) return kBestPsnr;
  return std::min(kBestPsnr, 10 * std::log10(255.0 * 255.0 * samples / squares));
}

cv::Mat luma_of(const image::Image<image::Rgb8>& picture) {
  cv::Mat luma(picture.height(), picture.width(), CV_32FC1);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const image::Rgb8 p = picture(x, y);
      luma.at<float>(y, x) = 0.2126F * static_cast<float>(p.r) + 0.7152F * static_cast<float>(p.g) +
                             0.0722F * static_cast<float>(p.b);
    }
  }
  return luma;
}

// Wang et al. 2004: Gaussian window of 11 pixels, 1.5 wide.
cv::Mat ssim_map(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255;
  constexpr double kC2 = 0.03 * 255 * 0.03 * 255;
  const auto mean = [](const cv::Mat& m) {
    cv::Mat out;
    cv::GaussianBlur(m, out, {11, 11}, 1.5);
    return out;
  };
  const cv::Mat ma = mean(a);
  const cv::Mat mb = mean(b);
  const cv::Mat va = mean(a.mul(a)) - ma.mul(ma);
  const cv::Mat vb = mean(b.mul(b)) - mb.mul(mb);
  const cv::Mat vab = mean(a.mul(b)) - ma.mul(mb);
  const cv::Mat top = (2 * ma.mul(mb) + kC1).mul(2 * vab + kC2);
  const cv::Mat low = (ma.mul(ma) + mb.mul(mb) + kC1).mul(va + vb + kC2);
  cv::Mat out;
  cv::divide(top, low, out);
  return out;
}

double psnr(const image::Image<image::Rgb8>& clean, const image::Image<image::Rgb8>& rendered,
            const cv::Mat& where, int dx, int dy) {
  double squares = 0;
  double samples = 0;
  for (int y = 0; y < clean.height(); ++y) {
    for (int x = 0; x < clean.width(); ++x) {
      if (!where.at<std::uint8_t>(y, x) || !rendered.contains(x + dx, y + dy)) continue;
      const image::Rgb8 a = clean(x, y);
      const image::Rgb8 b = rendered(x + dx, y + dy);
      const double r = a.r - b.r;
      const double g = a.g - b.g;
      const double l = a.b - b.b;
      squares += r * r + g * g + l * l;
      samples += 3;
    }
  }
  return psnr_of(squares, samples);
}

}  // namespace

ViewScore score_view(const image::Image<image::Rgb8>& clean,
                     const image::Image<image::Rgb8>& rendered,
                     const std::optional<image::Image<std::uint8_t>>& matte) {
  ViewScore score;
  const cv::Mat everywhere(clean.height(), clean.width(), CV_8UC1, cv::Scalar(255));
  cv::Mat where = everywhere;
  if (matte) {
    cv::Mat mask(matte->height(), matte->width(), CV_8UC1);
    for (int y = 0; y < matte->height(); ++y) {
      for (int x = 0; x < matte->width(); ++x) {
        mask.at<std::uint8_t>(y, x) = (*matte)(x, y) >= 128 ? 255 : 0;
      }
    }
    const int side = 2 * kDilation + 1;
    cv::dilate(mask, where, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  }
  const cv::Mat similarity = ssim_map(luma_of(clean), luma_of(rendered));
  score.full_psnr_db = psnr(clean, rendered, everywhere, 0, 0);
  score.full_ssim = cv::mean(similarity)[0];
  score.psnr_db = psnr(clean, rendered, where, 0, 0);
  score.ssim = cv::mean(similarity, where)[0];
  score.shifted_psnr_db = score.psnr_db;
  for (int dy = -kMostShift; dy <= kMostShift; ++dy) {
    for (int dx = -kMostShift; dx <= kMostShift; ++dx) {
      const double value = psnr(clean, rendered, where, dx, dy);
      if (value > score.shifted_psnr_db + 1e-9) {
        score.shifted_psnr_db = value;
        score.shift_px = {dx, dy};
      }
    }
  }
  return score;
}

}  // namespace touchline::score
