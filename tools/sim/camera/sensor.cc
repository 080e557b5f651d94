#include "tools/sim/camera/sensor.h"

#include <algorithm>
#include <cmath>

#include "tools/sim/camera/detail.h"

namespace touchline::sim::camera {

namespace {

constexpr int kStepsPerWhite = 4096;
constexpr int kMostWhite = 8;  // times white; what is brighter is as bright
constexpr std::size_t kQuantiles = 4096;

// Quantiles of a standard normal distribution, scaled to deviation 1.
std::vector<float> normal_quantiles() {
  std::vector<double> q(kQuantiles);
  for (std::size_t i = 0; i < kQuantiles / 2; ++i) {
    const double p = (static_cast<double>(i) + 0.5) / kQuantiles;
    double low = -6, high = 0;
    for (int step = 0; step < 50; ++step) {
      const double middle = (low + high) / 2;
      (0.5 * std::erfc(-middle / std::sqrt(2.0)) < p ? low : high) = middle;
    }
    q[i] = low;
    q[kQuantiles - 1 - i] = -low;
  }
  double power = 0;
  for (const double v : q) power += v * v;
  const double scale = std::sqrt(kQuantiles / power);
  std::vector<float> out;
  for (const double v : q) out.push_back(static_cast<float>(v * scale));
  return out;
}

// Symmetric weights [0] + 2 ([1] + ...) = 1 of a blur with this deviation.
std::vector<float> blur_weights(double sigma) {
  if (sigma <= 0) return {1.0f};
  if (sigma <= 0.6) {
    const auto side = static_cast<float>(sigma * sigma / 2);  // the deviation is exact
    return {1 - 2 * side, side};
  }
  const int reach = static_cast<int>(std::ceil(3 * sigma));
  std::vector<double> w;
  double sum = 0;
  for (int k = 0; k <= reach; ++k) {
    w.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    sum += (k == 0 ? 1 : 2) * w.back();
  }
  std::vector<float> out;
  for (const double v : w) out.push_back(static_cast<float>(v / sum));
  return out;
}

// A row of the picture, blurred both ways, times a gain a channel; planar.
class Rows {
 public:
  Rows(const LinearImage& light, std::vector<float> weights, std::array<float, 3> gain)
      : light_(light), weights_(std::move(weights)), gain_(gain) {
    const auto n = static_cast<std::size_t>(light.width()) * 3;
    column_.resize(n);
  }

  void fill(int y, std::array<std::vector<float>, 3>& planes) {
    const int width = light_.width(), height = light_.height();
    const auto n = static_cast<std::size_t>(width) * 3;
    const float* const middle = light_.row(y)->data();
    for (std::size_t i = 0; i < n; ++i) column_[i] = weights_[0] * middle[i];
    for (std::size_t k = 1; k < weights_.size(); ++k) {
      const int reach = static_cast<int>(k);
      const float* const above = light_.row(std::max(y - reach, 0))->data();
      const float* const below = light_.row(std::min(y + reach, height - 1))->data();
      for (std::size_t i = 0; i < n; ++i) column_[i] += weights_[k] * (above[i] + below[i]);
    }
    for (std::size_t c = 0; c < 3; ++c) {
      for (int x = 0; x < width; ++x) {
        planes[c][static_cast<std::size_t>(x)] =
            gain_[c] * weights_[0] * column_[static_cast<std::size_t>(3 * x) + c];
      }
    }
    for (std::size_t k = 1; k < weights_.size(); ++k) {
      const int reach = static_cast<int>(k);
      for (std::size_t c = 0; c < 3; ++c) {
        const float weight = gain_[c] * weights_[k];
        const auto at = [&](int x) { return column_[static_cast<std::size_t>(3 * x) + c]; };
        for (int x = 0; x < std::min(reach, width); ++x) {
          planes[c][static_cast<std::size_t>(x)] +=
              weight * (at(0) + at(std::min(x + reach, width - 1)));
        }
        for (int x = reach; x < width - reach; ++x) {
          planes[c][static_cast<std::size_t>(x)] += weight * (at(x - reach) + at(x + reach));
        }
        for (int x = std::max(reach, width - reach); x < width; ++x) {
          planes[c][static_cast<std::size_t>(x)] += weight * (at(x - reach) + at(width - 1));
        }
      }
    }
  }

 private:
  const LinearImage& light_;
  const std::vector<float> weights_;
  const std::array<float, 3> gain_;
  std::vector<float> column_;
};

std::uint16_t code(float value, float least, float most) {
  return static_cast<std::uint16_t>(std::min(std::max(value + 0.5f, least), most));
}

}  // namespace

double bt709_oetf(double light) {
  if (light < 0.018053968510807) return 4.5 * std::max(0.0, light);
  return 1.09929682680944 * std::pow(light, 0.45) - 0.09929682680944;
}

Sensor::Sensor(const SensorSpec& spec, double exposure)
    : spec_(spec), exposure_(exposure), gaussian_(normal_quantiles()) {
  for (int i = 0; i <= kStepsPerWhite * kMostWhite + 1; ++i) {
    curve_.push_back(static_cast<float>(curve(static_cast<double>(i) / kStepsPerWhite)));
  }
}

double Sensor::curve(double light) const {
  double v = bt709_oetf(std::min(light, static_cast<double>(kMostWhite)));
  if (v > spec_.knee) v = spec_.knee + spec_.knee_slope * (v - spec_.knee);
  return std::min(v, 1.0);
}

double Sensor::noise(double light) const {
  return std::sqrt(spec_.read_noise * spec_.read_noise +
                   spec_.shot_noise * spec_.shot_noise * std::max(0.0, light));
}

image::Frame Sensor::expose(const LinearImage& light, const Stream& random) const {
  const int width = light.width(), height = light.height();
  const double exposure = exposure_ * std::exp2(spec_.exposure_stops);
  std::array<float, 3> gain{};
  for (std::size_t c = 0; c < 3; ++c) {
    gain[c] = static_cast<float>(exposure * spec_.gain[static_cast<Eigen::Index>(c)]);
  }
  Rows rows(light, blur_weights(spec_.softness_px), gain);
  image::Frame frame;
  frame.planes = {image::Image<std::uint16_t>(width, height),
                  image::Image<std::uint16_t>((width + 1) / 2, height),
                  image::Image<std::uint16_t>((width + 1) / 2, height)};
  image::Image<float> luma(width, height);
  const auto w = static_cast<std::size_t>(width);
  std::array<std::vector<float>, 3> planes, noise;
  for (std::size_t c = 0; c < 3; ++c) {
    planes[c].resize(w);
    noise[c].resize(w, 0.0f);
  }
  std::vector<float> cb(w), cr(w);
  const auto read2 = static_cast<float>(spec_.read_noise * spec_.read_noise);
  const auto shot2 = static_cast<float>(spec_.shot_noise * spec_.shot_noise);
  const bool noisy = read2 > 0 || shot2 > 0;
  for (int y = 0; y < height; ++y) {
    rows.fill(y, planes);
    if (noisy) {
      const Stream here = random.sub(static_cast<std::uint64_t>(y));
      for (std::size_t x = 0; x < w; ++x) {
        const std::uint64_t bits = here.bits(x);
        noise[0][x] = gaussian_[bits & 4095];
        noise[1][x] = gaussian_[(bits >> 20) & 4095];
        noise[2][x] = gaussian_[(bits >> 40) & 4095];
      }
    }
    for (std::size_t c = 0; c < 3; ++c) {
      float* const p = planes[c].data();
      const float* const n = noise[c].data();
      constexpr float kMost = kMostWhite;
      for (std::size_t x = 0; x < w; ++x) {
        const float v = p[x] + n[x] * std::sqrt(read2 + shot2 * std::max(p[x], 0.0f));
        p[x] = std::min(std::max(v, 0.0f), kMost) * kStepsPerWhite;
      }
      const float* const curve = curve_.data();
      for (std::size_t x = 0; x < w; ++x) {
        const int i = static_cast<int>(p[x]);
        const float t = p[x] - static_cast<float>(i);
        p[x] = curve[i] + t * (curve[i + 1] - curve[i]);
      }
    }
    float* const to = luma.row(y);
    for (std::size_t x = 0; x < w; ++x) {
      const float r = planes[0][x], g = planes[1][x], b = planes[2][x];
      const float l = 0.2126f * r + 0.7152f * g + 0.0722f * b;
      to[x] = l;
      cb[x] = (b - l) * (896.0f / 1.8556f);
      cr[x] = (r - l) * (896.0f / 1.5748f);
    }
    std::uint16_t* const pb = frame.planes[1].row(y);
    std::uint16_t* const pr = frame.planes[2].row(y);
    for (int x = 0; x < width; x += 2) {
      const auto m = static_cast<std::size_t>(x);
      const std::size_t left = x > 0 ? m - 1 : m, right = x + 1 < width ? m + 1 : m;
      pb[x / 2] = code(512 + 0.25f * (cb[left] + 2 * cb[m] + cb[right]), 4, 1019);
      pr[x / 2] = code(512 + 0.25f * (cr[left] + 2 * cr[m] + cr[right]), 4, 1019);
    }
  }
  if (spec_.detail.level > 0) luma = apply_detail(spec_.detail, luma);
  for (int y = 0; y < height; ++y) {
    const float* const from = luma.row(y);
    std::uint16_t* const to = frame.planes[0].row(y);
    for (int x = 0; x < width; ++x) to[x] = code(64 + 876 * from[x], 4, 1019);
  }
  return frame;
}

image::Image<image::Rgb8> clean_picture(const LinearImage& light, double exposure) {
  SensorSpec ideal;
  const Sensor sensor(ideal, 1);
  constexpr int kSteps = 4096;
  std::vector<std::uint8_t> table;
  for (int i = 0; i <= kSteps * kMostWhite; ++i) {
    table.push_back(static_cast<std::uint8_t>(
        std::lround(255 * sensor.curve(static_cast<double>(i) / kSteps))));
  }
  const auto byte = [&](float v) {
    const double scaled = std::clamp(v * exposure, 0.0, static_cast<double>(kMostWhite));
    return table[static_cast<std::size_t>(scaled * kSteps + 0.5)];
  };
  image::Image<image::Rgb8> out(light.width(), light.height());
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) {
      const auto& p = light(x, y);
      out(x, y) = {byte(p[0]), byte(p[1]), byte(p[2])};
    }
  }
  return out;
}

}  // namespace touchline::sim::camera
