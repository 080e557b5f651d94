#include <algorithm>
#include <cmath>

#include "edge/calibrate/lines/line_profile_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kTangentTap = 1.5;  // pixels along the line, either side: averages the noise down
constexpr double kSlack = 1.5;       // pixels of turf that a template sees beyond paint and blur
constexpr double kTurfClear = 0.85;  // share of turf for a window to count as in plain sight
constexpr double kLeastGreen = 12;   // code values of chroma
constexpr double kMostRed = 0.07;    // Cr - 512 over luma
constexpr double kSamplingSigma = 0.25;  // pixels, for paint of no width
constexpr double kTypicalPaint = 200;    // code values of worn paint over turf
constexpr double kThinPaintPx = 1.2;     // paint that a band beside the pitch may pass for
constexpr double kBlursBeside = 2.2;     // of the point spread, and these pixels: beside thin paint
constexpr double kPixelBeside = 1;
constexpr double kLeastFall = 0.4;  // beside thin paint, of the fall to twice as far

// Unchecked bilinear sample; the position must lie at least half a pixel inside.
inline float bilinear(const image::ImageView<const std::uint16_t>& view, double x, double y) {
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  const float fx = static_cast<float>(x - ix);
  const float fy = static_cast<float>(y - iy);
  const std::uint16_t* p = view.row(iy) + ix;
  const std::uint16_t* q = p + view.stride;
  const float top = static_cast<float>(p[0]) + fx * static_cast<float>(p[1] - p[0]);
  const float bottom = static_cast<float>(q[0]) + fx * static_cast<float>(q[1] - q[0]);
  return top + fy * (bottom - top);
}

// Share of paint of a line `width` wide, blurred by `sigma`, at distance `u` from its centre.
double coverage(double u, double width, double sigma) {
  const double s = 1 / (std::sqrt(2.0) * sigma);
  return 0.5 * (std::erf((u + width / 2) * s) - std::erf((u - width / 2) * s));
}

}  // namespace

ProfileReader::ProfileReader(const image::Frame& frame, const LinePointOptions& options)
    : frame_(frame),
      options_(options),
      shift_(image::chroma_shift(frame.format)),
      scale_(frame.height() / 1080.0),
      // The point spread does not shrink below a pixel's own area with a smaller picture.
      blur_(std::max(0.5, options.blur_px * scale_)) {}

ProfileReader::Span ProfileReader::inside(const LinePoint& window, double reach) const {
  Span span{-reach, reach};
  const auto clip = [&](double position, double direction, double low, double high) {
    if (std::abs(direction) < 1e-9) {
      if (position < low || position > high) span = {1, -1};
      return;
    }
    const double a = (low - position) / direction;
    const double b = (high - position) / direction;
    span.low = std::max(span.low, std::min(a, b));
    span.high = std::min(span.high, std::max(a, b));
  };
  const double margin = kTangentTap + 1;
  clip(window.predicted.x(), window.normal.x(), margin, frame_.width() - 1 - margin);
  clip(window.predicted.y(), window.normal.y(), margin, frame_.height() - 1 - margin);
  return span;
}

void ProfileReader::sample(const LinePoint& window, double low, int count) {
  samples_.resize(static_cast<std::size_t>(count));
  const auto luma = frame_.luma();
  const Eigen::Vector2d tap = kTangentTap * Eigen::Vector2d(-window.normal.y(), window.normal.x());
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d p = window.predicted + (low + i * step_) * window.normal;
    samples_[static_cast<std::size_t>(i)] =
        (bilinear(luma, p.x() - tap.x(), p.y() - tap.y()) + bilinear(luma, p.x(), p.y()) +
         bilinear(luma, p.x() + tap.x(), p.y() + tap.y())) *
        (1.0F / 3.0F);
  }
}

void ProfileReader::shape_template(double width_px) {
  if (std::abs(width_px - template_width_) < 0.02 * width_px) return;
  template_width_ = width_px;
  step_ = std::clamp(width_px / 8, 0.5, 2.0);
  half_ = static_cast<int>(std::ceil((width_px / 2 + 2.5 * blur_ + kSlack * scale_) / step_));
  const int taps = 2 * half_ + 1;
  shape_.resize(static_cast<std::size_t>(taps));
  weights_.resize(static_cast<std::size_t>(taps));
  double sum = 0;
  for (int k = 0; k < taps; ++k) {
    const double c = coverage((k - half_) * step_, width_px, blur_);
    shape_[static_cast<std::size_t>(k)] = static_cast<float>(c);
    sum += c;
  }
  slope_energy_ = 0;
  for (std::size_t k = 0; k + 1 < shape_.size(); ++k) {
    const double slope = (shape_[k + 1] - shape_[k]) / step_;
    slope_energy_ += slope * slope * step_;
  }
  shape_energy_ = 0;
  const float mean = static_cast<float>(sum / taps);
  for (float& c : shape_) {
    c -= mean;
    shape_energy_ += static_cast<double>(c) * c;
  }
  for (std::size_t k = 0; k < shape_.size(); ++k)
    weights_[k] = shape_[k] / static_cast<float>(shape_energy_);
}

double ProfileReader::noise() const {
  // From differences a pixel apart: the few that a line's edges make do not move the median.
  const std::size_t lag = static_cast<std::size_t>(std::max(1.0, std::round(1 / step_)));
  if (samples_.size() < lag + 3) return 0;
  scratch_.clear();
  for (std::size_t i = 0; i + lag < samples_.size(); ++i)
    scratch_.push_back(std::abs(samples_[i + lag] - samples_[i]));
  const auto middle = scratch_.begin() + static_cast<std::ptrdiff_t>(scratch_.size() / 2);
  std::nth_element(scratch_.begin(), middle, scratch_.end());
  return 1.4826 / std::sqrt(2.0) * static_cast<double>(*middle);
}

void ProfileReader::correlate() {
  const int count = static_cast<int>(samples_.size());
  response_.assign(samples_.size(), 0.0F);
  for (int i = half_; i + half_ < count; ++i) {
    const float* p = samples_.data() + (i - half_);
    float sum = 0;
    for (std::size_t k = 0; k < weights_.size(); ++k) sum += weights_[k] * p[k];
    response_[static_cast<std::size_t>(i)] = sum;
  }
}

double ProfileReader::match(int centre) const {
  const float* p = samples_.data() + (centre - half_);
  const int taps = 2 * half_ + 1;
  double sum = 0, moment = 0, squares = 0, product = 0;
  for (int k = 0; k < taps; ++k) {
    const double v = static_cast<double>(p[k]);
    sum += v;
    squares += v * v;
    moment += v * (k - half_);
    product += v * static_cast<double>(shape_[static_cast<std::size_t>(k)]);
  }
  const double indices = half_ * (half_ + 1.0) * (2.0 * half_ + 1) / 3;  // sum of (k - half)^2
  const double energy = squares - sum * sum / taps - moment * moment / indices;
  if (energy <= 0) return 0;
  return product / std::sqrt(shape_energy_ * energy);
}

bool ProfileReader::far_wider(int centre) const {
  if (template_width_ > kThinPaintPx) return false;
  const int beside = static_cast<int>(
      std::lround((template_width_ / 2 + kBlursBeside * blur_ + kPixelBeside) / step_));
  const int last = static_cast<int>(samples_.size()) - 1;
  const auto at = [&](int i) {
    return static_cast<double>(samples_[static_cast<std::size_t>(std::clamp(i, 0, last))]);
  };
  const double top = at(centre);
  const double flank = std::max(at(centre - beside), at(centre + beside));
  const double foot = 0.5 * (at(centre - 2 * beside) + at(centre + 2 * beside));
  return top - flank < kLeastFall * (top - foot);
}

bool ProfileReader::is_turf(double luma, double cb, double cr) const {
  const double level = std::max(luma - 64, 0.0);
  const double green = -(cb - 512) - (cr - 512);
  return green > std::max(kLeastGreen, options_.turf_chroma * level) && cb < 512 &&
         cr - 512 < kMostRed * level;
}

bool ProfileReader::turf_at(const Eigen::Vector2d& pixel) const {
  const int x = static_cast<int>(pixel.x() + 0.5);
  const int y = static_cast<int>(pixel.y() + 0.5);
  if (!frame_.planes[0].contains(x, y)) return false;
  const int cx = std::min(x >> shift_.x, frame_.planes[1].width() - 1);
  const int cy = std::min(y >> shift_.y, frame_.planes[1].height() - 1);
  return is_turf(frame_.planes[0](x, y), frame_.planes[1](cx, cy), frame_.planes[2](cx, cy));
}

bool ProfileReader::paint_on_turf(const LinePoint& window, double offset) const {
  // Chroma is blurred by its subsampling, so turf is looked for a little away from the paint.
  const double away = window.width_px / 2 + 2 * blur_ + 1 + (1 << shift_.x);
  for (const double side : {-away, away})
    if (!turf_at(window.predicted + (offset + side) * window.normal)) return false;
  // Paint is white: less coloured than the turf beside it, or as much where it is thin.
  const auto colour = [&](double along) {
    const Eigen::Vector2d p = window.predicted + along * window.normal;
    const int x =
        std::clamp(static_cast<int>(p.x() + 0.5) >> shift_.x, 0, frame_.planes[1].width() - 1);
    const int y =
        std::clamp(static_cast<int>(p.y() + 0.5) >> shift_.y, 0, frame_.planes[1].height() - 1);
    return std::abs(frame_.planes[1](x, y) - 512) + std::abs(frame_.planes[2](x, y) - 512);
  };
  return colour(offset) <= 1.15 * std::max(colour(offset - away), colour(offset + away)) + 8;
}

bool ProfileReader::measure(LinePoint& window) {
  window.count = 0;
  window.state = WindowState::kHidden;
  shape_template(window.width_px);
  const double support = half_ * step_;
  const Span span = inside(window, window.search_px + support);
  if (span.low > -support || span.high < support) return false;
  const int before = static_cast<int>(-span.low / step_);
  const int after = static_cast<int>(span.high / step_);
  const double low = -before * step_;
  sample(window, low, before + after + 1);
  const double sigma = noise();
  // Amplitude noise of the fitted template; neighbouring samples share pixels.
  const double amplitude_sigma = sigma / std::sqrt(shape_energy_ * std::min(1.0, step_));
  const double threshold =
      std::max(options_.least_contrast, options_.noise_factor * amplitude_sigma);
  correlate();

  const int count = static_cast<int>(samples_.size());
  const int apart = std::max(1, static_cast<int>((window.width_px / 2 + scale_) / step_));
  bool hidden = false;  // by something as pale that is wider than the paint
  for (int i = half_ + 1; i + half_ + 1 < count; ++i) {
    const float peak = response_[static_cast<std::size_t>(i)];
    if (static_cast<double>(peak) < threshold) continue;
    bool highest = true;
    for (int k = std::max(half_, i - apart); highest && k <= std::min(count - 1 - half_, i + apart);
         ++k)
      highest = k == i || response_[static_cast<std::size_t>(k)] < peak ||
                (response_[static_cast<std::size_t>(k)] == peak && k > i);
    if (!highest) continue;
    const double quality = match(i);
    if (quality < options_.least_match) continue;
    const double left = static_cast<double>(response_[static_cast<std::size_t>(i - 1)]);
    const double right = static_cast<double>(response_[static_cast<std::size_t>(i + 1)]);
    const double bend = left - 2 * static_cast<double>(peak) + right;
    const double shift = bend < 0 ? std::clamp(0.5 * (left - right) / bend, -0.5, 0.5) : 0.0;
    LineCandidate candidate;
    candidate.offset_px = low + (i + shift) * step_;
    if (std::abs(candidate.offset_px) > window.search_px) continue;
    if (!paint_on_turf(window, candidate.offset_px)) continue;
    if (far_wider(i)) {
      hidden = true;
      continue;
    }
    candidate.contrast = static_cast<double>(peak);
    candidate.match = quality;
    // Paint thinner than a pixel falls on one row or the next: a sharp picture does not say where
    // in it.
    const double sampling = kSamplingSigma * std::max(0.0, 1 - window.width_px);
    candidate.sigma_px = std::hypot(options_.sigma_floor_px, sampling,
                                    sigma / (candidate.contrast * std::sqrt(slope_energy_)));
    const auto strength = [](const LineCandidate& c) { return c.contrast * c.match; };
    int at = window.count;
    while (at > 0 &&
           strength(window.candidates[static_cast<std::size_t>(at - 1)]) < strength(candidate))
      --at;
    if (at >= LinePoint::kMostCandidates) continue;
    window.count = std::min(window.count + 1, LinePoint::kMostCandidates);
    for (int k = window.count - 1; k > at; --k)
      window.candidates[static_cast<std::size_t>(k)] =
          window.candidates[static_cast<std::size_t>(k - 1)];
    window.candidates[static_cast<std::size_t>(at)] = candidate;
  }
  if (window.count > 0) {
    window.state = WindowState::kFound;
    return true;
  }
  // Nothing found: is there plain turf, and would paint have shown on it?
  int turf = 0;
  int looked = 0;
  const double stride = std::max(2.0 * scale_, 2 * step_);
  for (double s = low + support; s <= after * step_ - support + 1e-9; s += stride) {
    ++looked;
    if (turf_at(window.predicted + s * window.normal)) ++turf;
  }
  if (looked > 0 && turf >= kTurfClear * looked)
    window.state = kTypicalPaint >= threshold && !hidden ? WindowState::kBare : WindowState::kFaint;
  return true;
}

}  // namespace touchline::calibrate
