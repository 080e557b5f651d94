#include "tools/score/view_score.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace touchline::score {

namespace {

constexpr int kMostShift = 6;
constexpr int kSide = 2 * kMostShift + 1;
constexpr double kBestPsnr = 99;  // of equal pictures

double psnr_of(double squares, double samples) {
  if (samples <= 0 || squares <= 0) return kBestPsnr;
  return std::min(kBestPsnr, 10 * std::log10(255.0 * 255.0 * samples / squares));
}

float luma(const image::Rgb8& p) {
  return 0.2126F * static_cast<float>(p.r) + 0.7152F * static_cast<float>(p.g) +
         0.0722F * static_cast<float>(p.b);
}

cv::Mat luma_of(const Picture& picture) {
  cv::Mat out(picture.height(), picture.width(), CV_32FC1);
  for (int y = 0; y < picture.height(); ++y) {
    float* row = out.ptr<float>(y);
    for (int x = 0; x < picture.width(); ++x) row[x] = luma(picture(x, y));
  }
  return out;
}

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

cv::Mat mat_of(const Mask& mask) {
  return {mask.height(), mask.width(), CV_8UC1, const_cast<std::uint8_t*>(mask.data())};
}

double square_error(const image::Rgb8& a, const image::Rgb8& b) {
  const int r = a.r - b.r;
  const int g = a.g - b.g;
  const int l = a.b - b.b;
  return r * r + g * g + l * l;
}

struct Error {
  double squares = 0;
  double samples = 0;
  double mean() const {
    return samples > 0 ? squares / samples : std::numeric_limits<double>::infinity();
  }
};

// Where the parabola through three errors has its least, -0.5..0.5 of the middle one.
double parabola(double before, double middle, double after) {
  const double bend = before - 2 * middle + after;
  if (!std::isfinite(bend) || bend <= 0) return 0;
  return std::clamp(0.5 * (before - after) / bend, -0.5, 0.5);
}

}  // namespace

Mask grown_foreground(const Mask& matte, int margin_px) {
  Mask out(matte.width(), matte.height());
  const int side = 2 * margin_px + 1;
  cv::Mat grown = mat_of(out);
  const cv::Mat mask = mat_of(matte) >= 128;
  cv::dilate(mask, grown, cv::getStructuringElement(cv::MORPH_ELLIPSE, {side, side}));
  return out;
}

double psnr_db(const Picture& clean, const Picture& rendered, const Mask& where) {
  Error error;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    if (!where.data()[i]) continue;
    error.squares += square_error(clean.data()[i], rendered.data()[i]);
    error.samples += 3;
  }
  return psnr_of(error.squares, error.samples);
}

Similarity ssim(const Picture& clean, const Picture& rendered, const Mask& where) {
  const cv::Mat map = ssim_map(luma_of(clean), luma_of(rendered));
  Similarity out;
  out.full = cv::mean(map)[0];
  if (cv::countNonZero(mat_of(where)) > 0) out.inside = cv::mean(map, mat_of(where))[0];
  return out;
}

Alignment align(const Picture& clean, const Picture& rendered, const Mask& where) {
  constexpr int kLeastPixels = 100;
  cv::Mat labels;
  cv::Mat stats;
  cv::Mat centres;
  const int count = cv::connectedComponentsWithStats(mat_of(where), labels, stats, centres);
  Alignment out;
  Error all;
  for (int label = 1; label < count; ++label) {
    if (stats.at<int>(label, cv::CC_STAT_AREA) < kLeastPixels) continue;
    const int x0 = stats.at<int>(label, cv::CC_STAT_LEFT);
    const int y0 = stats.at<int>(label, cv::CC_STAT_TOP);
    const int x1 = x0 + stats.at<int>(label, cv::CC_STAT_WIDTH);
    const int y1 = y0 + stats.at<int>(label, cv::CC_STAT_HEIGHT);
    std::array<std::array<Error, kSide>, kSide> errors{};
    for (int dy = -kMostShift; dy <= kMostShift; ++dy) {
      for (int dx = -kMostShift; dx <= kMostShift; ++dx) {
        Error& error = errors[static_cast<std::size_t>(dy + kMostShift)]
                             [static_cast<std::size_t>(dx + kMostShift)];
        for (int y = std::max(y0, -dy); y < std::min(y1, clean.height() - dy); ++y) {
          const int* of = labels.ptr<int>(y);
          for (int x = std::max(x0, -dx); x < std::min(x1, clean.width() - dx); ++x) {
            if (of[x] != label) continue;
            error.squares += square_error(clean(x, y), rendered(x + dx, y + dy));
            error.samples += 3;
          }
        }
      }
    }
    // No shift where none is better.
    int best_x = 0, best_y = 0;
    const auto at = [&](int dx, int dy) {
      if (std::abs(dx) > kMostShift || std::abs(dy) > kMostShift) {
        return std::numeric_limits<double>::infinity();
      }
      return errors[static_cast<std::size_t>(dy + kMostShift)]
                   [static_cast<std::size_t>(dx + kMostShift)]
                       .mean();
    };
    for (int dy = -kMostShift; dy <= kMostShift; ++dy) {
      for (int dx = -kMostShift; dx <= kMostShift; ++dx) {
        if (at(dx, dy) < at(best_x, best_y)) {
          best_x = dx;
          best_y = dy;
        }
      }
    }
    const double least = at(best_x, best_y);
    PieceShift piece;
    piece.pixels = stats.at<int>(label, cv::CC_STAT_AREA);
    piece.shift_px = {best_x, best_y};
    if (least > 0) {
      piece.shift_px.x() += parabola(at(best_x - 1, best_y), least, at(best_x + 1, best_y));
      piece.shift_px.y() += parabola(at(best_x, best_y - 1), least, at(best_x, best_y + 1));
    }
    out.pieces.push_back(piece);
    const Error& error = errors[static_cast<std::size_t>(best_y + kMostShift)]
                               [static_cast<std::size_t>(best_x + kMostShift)];
    all.squares += error.squares;
    all.samples += error.samples;
  }
  out.psnr_db = psnr_of(all.squares, all.samples);
  return out;
}

ForegroundCount count_foreground(const Mask& truth, const Mask& found) {
  ForegroundCount count;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool should = truth.data()[i] >= 128;
    const bool is = found.data()[i] >= 128;
    count.truth += should;
    count.missing += should && !is;
    count.phantom += is && !should;
  }
  return count;
}

Flicker flicker(const Picture& clean_before, const Picture& rendered_before, const Picture& clean,
                const Picture& rendered, const Mask& where) {
  Flicker out;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    if (!where.data()[i]) continue;
    const auto change = static_cast<double>(luma(clean.data()[i]) - luma(clean_before.data()[i]));
    const auto shown =
        static_cast<double>(luma(rendered.data()[i]) - luma(rendered_before.data()[i]));
    out.error_change += std::abs(shown - change);
    out.clean_change += std::abs(change);
  }
  return out;
}

}  // namespace touchline::score
