#include "edge/compensate/edge_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace touchline::compensate {
namespace {

constexpr int kGrid = 10;              // samples of a drawn response in a pixel
constexpr double kMargin = 3.2;        // drawn beyond the samples, pixels
constexpr double kModelError = 0.012;  // of the model itself, share of the step
constexpr double kStripWidth = 1;      // pixels
constexpr double kStripGain = 10;      // less misfit (squared) that makes one believed
constexpr double kNearWhite = 900;     // levels below are not overexposed, code values
constexpr double kExcessPrior = 0.2;   // spread of the overexposure
constexpr double kAperture = 0.5;      // of a pixel, share of its pitch; a wide one would hide blur
constexpr double kStripPrior = 0.3;    // spread of its darkness, share of the ground's light
constexpr double kBlack = 64, kWhite = 940;  // 10-bit code values
constexpr double kLeastBlur = 0.08, kMostBlur = 3;

enum Parameter { kPlace, kBlur, kLeft, kRight, kExcess, kStrip, kWidth, kTop };

// Inverse of BT.709's transfer curve, continued beyond both ends.
double light(double code) {
  const double v = (code - kBlack) / (kWhite - kBlack);
  return v < 0.081 ? v / 4.5 : std::pow((v + 0.099) / 1.099, 1 / 0.45);
}

// The curve itself, from a table.
class Curve {
 public:
  Curve() {
    for (std::size_t i = 0; i < values_.size(); ++i) {
      const double l = static_cast<double>(i) / kPerUnit;
      const double v = l < 0.018 ? 4.5 * l : 1.099 * std::pow(l, 0.45) - 0.099;
      values_[i] = kBlack + v * (kWhite - kBlack);
    }
  }
  double operator()(double l) const {
    if (l < 0.018) return kBlack + 4.5 * l * (kWhite - kBlack);
    const double position = std::min(l * kPerUnit, static_cast<double>(values_.size() - 2));
    const auto i = static_cast<std::size_t>(position);
    return values_[i] + (position - static_cast<double>(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr double kPerUnit = 1024;
  std::vector<double> values_ = std::vector<double>(4096);
};

// The integral of a unit Gaussian, from a table.
class Normal {
 public:
  Normal() {
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_[i] =
          0.5 * std::erfc(-(static_cast<double>(i) / kPerUnit - kEnd) / std::numbers::sqrt2);
  }
  double operator()(double t) const {
    const double position = (t + kEnd) * kPerUnit;
    if (position <= 0) return 0;
    if (position >= static_cast<double>(values_.size() - 1)) return 1;
    const auto i = static_cast<std::size_t>(position);
    return values_[i] + (position - static_cast<double>(i)) * (values_[i + 1] - values_[i]);
  }

 private:
  static constexpr double kPerUnit = 64, kEnd = 4;
  std::vector<double> values_ = std::vector<double>(513);
};

const Curve& curve() {
  static const Curve c;
  return c;
}

const Normal& normal() {
  static const Normal n;
  return n;
}

}  // namespace

EdgeFit::EdgeFit(const EdgeProfile& edge) : edge_(edge) {
  own_ = edge.bar ? 8 : 6;
  scale_ = edge.step();
  parameters_.setZero(own_);
  prior_weight_.setZero(own_);
  parameters_[kPlace] = 0;
  prior_weight_[kPlace] = 1 / 1.0;
  parameters_[kBlur] = std::log(0.5);
  prior_weight_[kBlur] = 1 / 0.7;
  parameters_[kLeft] = edge.left;
  parameters_[kRight] = edge.right;
  prior_weight_[kLeft] = prior_weight_[kRight] = 1 / (0.2 * scale_);
  parameters_[kExcess] = 0;
  if (edge.bar) {
    parameters_[kWidth] = edge.width;
    prior_weight_[kWidth] = 1 / 5.0;
    parameters_[kTop] = edge.top;
    prior_weight_[kTop] = 1 / (2.0 * scale_);
  }
  prior_weight_[kStrip] = 1 / kStripPrior;
  prior_ = parameters_;
  side_ = darker_side();
  strip_ = 0;
  may_exceed_ = std::max({edge.left, edge.right, edge.bar ? edge.top : 0.0}) > kNearWhite;
  prior_weight_[kExcess] = 1 / kExcessPrior;
  const auto n = static_cast<Eigen::Index>(edge.at.size());
  weight_.resize(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    weight_[i] = 1 / std::sqrt(edge.noise * edge.noise / static_cast<double>(edge.number[k]) +
                               std::pow(kModelError * scale_, 2));
    reach_ = std::max(reach_, static_cast<double>(std::abs(edge.at[k])));
  }
  reach_ += kMargin;
  drawn_.resize(static_cast<std::size_t>(2 * reach_ * kGrid) + 3);
  integral_.resize(drawn_.size());
}

// On which side a dark strip may lie: -1 left, 1 right, 0 none.
int EdgeFit::darker_side() const {
  if (!edge_.bar) return edge_.left < edge_.right ? -1 : 1;
  if (edge_.top < std::max(edge_.left, edge_.right)) return 0;
  double left = edge_.left;
  double right = edge_.right;
  for (std::size_t i = 0; i < edge_.at.size(); ++i) {
    double& side = edge_.at[i] < 0 ? left : right;
    side = std::min(side, static_cast<double>(edge_.value[i]));
  }
  return left - edge_.left < right - edge_.right ? -1 : 1;
}

// The mean over `width` pixels round every place of the grid.
void EdgeFit::average(double width) {
  const double half = 0.5 * width * kGrid;
  if (half < 0.1) return;
  integral_[0] = 0;
  for (std::size_t i = 1; i < drawn_.size(); ++i)
    integral_[i] = integral_[i - 1] + 0.5 * (drawn_[i - 1] + drawn_[i]);
  const auto whole = static_cast<std::ptrdiff_t>(half);
  const double part = half - static_cast<double>(whole);
  const auto n = static_cast<std::ptrdiff_t>(drawn_.size());
  const double first = drawn_.front();
  const double last = drawn_.back();
  const double end = integral_.back();
  const auto at = [&](std::ptrdiff_t i) {
    if (i < 0) return static_cast<double>(i) * first;
    if (i >= n) return end + static_cast<double>(i - n + 1) * last;
    return integral_[static_cast<std::size_t>(i)];
  };
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const double up = (1 - part) * at(i + whole) + part * at(i + whole + 1);
    const double down = (1 - part) * at(i - whole) + part * at(i - whole - 1);
    drawn_[static_cast<std::size_t>(i)] = (up - down) / (2 * half);
  }
}

void EdgeFit::draw(const Eigen::VectorXd& p) {
  const double left = light(p[kLeft]);
  const double right = light(p[kRight]);
  const double top = edge_.bar ? light(p[kTop]) : std::max(left, right);
  // Overexposed: the scene is brighter than the level at which it is cut.
  const double brightest = std::max({left, right, top});
  const bool top_bright = edge_.bar && top >= brightest;
  const double excess = 1 + p[kExcess];
  const double l = !edge_.bar && left > right ? left * excess : left;
  const double r = !edge_.bar && right >= left ? right * excess : right;
  const double m = top_bright ? top * excess : top;
  const double per_blur = std::exp(-p[kBlur]);
  const Curve& c = curve();
  const Normal& gauss = normal();
  const double a = p[kPlace] - (edge_.bar ? 0.5 * p[kWidth] : 0);
  const double b = p[kPlace] + (edge_.bar ? 0.5 * p[kWidth] : 0);
  // The dark strip lies to the right of the last edge or to the left of the first.
  const double from = strip_ > 0 ? b : a - kStripWidth;
  const double strip = p[kStrip] * (strip_ > 0 ? r : l);
  for (std::size_t i = 0; i < drawn_.size(); ++i) {
    const double t = static_cast<double>(i) / kGrid - reach_;
    const double up = gauss((t - a) * per_blur);
    double value =
        edge_.bar ? l + (m - l) * up + (r - m) * gauss((t - b) * per_blur) : l + (r - l) * up;
    if (strip_ != 0)
      value -= strip * (gauss((t - from) * per_blur) - gauss((t - from - kStripWidth) * per_blur));
    drawn_[i] = value;
  }
  average(kAperture * edge_.cosine);
  average(kAperture * edge_.sine);
  for (double& value : drawn_) value = c(std::min(value, brightest));
}

double EdgeFit::sample(double t) const {
  const double position =
      std::clamp((t + reach_) * kGrid, 0.0, static_cast<double>(drawn_.size()) - 1.001);
  const auto i = static_cast<std::size_t>(position);
  return drawn_[i] + (position - static_cast<double>(i)) * (drawn_[i + 1] - drawn_[i]);
}

void EdgeFit::residuals(const Eigen::VectorXd& parameters, const Taps& taps, Eigen::VectorXd& out) {
  draw(parameters);
  const std::array<double, 4> distance{edge_.cosine, 2 * edge_.cosine, edge_.sine, 2 * edge_.sine};
  for (Eigen::Index i = 0; i < weight_.size(); ++i) {
    const auto n = static_cast<std::size_t>(i);
    const double t = static_cast<double>(edge_.at[n]);
    const double here = sample(t);
    double value = here;
    for (Eigen::Index k = 0; k < 4; ++k) {
      const double d = distance[static_cast<std::size_t>(k)];
      const double boost = here - 0.5 * (sample(t - d) + sample(t + d));
      value += taps[k] * boost;
      tap_jacobian_(i, k) = -weight_[i] * boost;
    }
    out[i] = weight_[i] * (static_cast<double>(edge_.value[n]) - value);
  }
}

void EdgeFit::jacobian(const Taps& taps) {
  const Eigen::Index n = weight_.size();
  own_jacobian_.resize(n, own_);
  tap_jacobian_.resize(n, 4);
  residual_.resize(n);
  Eigen::VectorXd moved(n);
  Eigen::VectorXd base(n);
  residuals(parameters_, taps, base);
  for (Eigen::Index k = 0; k < own_; ++k) {
    const bool level = k == kLeft || k == kRight || k == kTop;
    const double by = level ? 0.01 * scale_ : 0.02;
    Eigen::VectorXd p = parameters_;
    p[k] += by;
    residuals(p, taps, moved);
    own_jacobian_.col(k) = (moved - base) / by;
  }
  residuals(parameters_, taps, residual_);
}

void EdgeFit::refine(const Taps& taps, int steps) {
  const auto cost = [&](const Eigen::VectorXd& r, const Eigen::VectorXd& p) {
    return r.squaredNorm() + prior_weight_.cwiseProduct(p - prior_).squaredNorm();
  };
  for (int step = 0; step < steps; ++step) {
    jacobian(taps);
    const double before = cost(residual_, parameters_);
    Eigen::MatrixXd h = own_jacobian_.transpose() * own_jacobian_;
    h.diagonal() += prior_weight_.cwiseAbs2();
    const Eigen::VectorXd g = -own_jacobian_.transpose() * residual_ -
                              prior_weight_.cwiseAbs2().cwiseProduct(parameters_ - prior_);
    for (int trial = 0; trial < 4; ++trial) {
      Eigen::MatrixXd damped = h;
      damped.diagonal() *= 1 + damping_;
      Eigen::VectorXd p = parameters_ + damped.ldlt().solve(g);
      p[kBlur] = std::clamp(p[kBlur], std::log(kLeastBlur), std::log(kMostBlur));
      p[kExcess] = may_exceed_ ? std::clamp(p[kExcess], 0.0, 2.0) : 0;
      p[kStrip] = strip_ != 0 ? std::clamp(p[kStrip], 0.0, 1.0) : 0;
      if (edge_.bar) p[kWidth] = std::max(p[kWidth], 0.2);
      Eigen::VectorXd r(residual_.size());
      residuals(p, taps, r);
      if (cost(r, p) < before) {
        parameters_ = p;
        residual_ = r;
        damping_ = std::max(1e-4, damping_ / 5);
        break;
      }
      damping_ = std::min(1e3, damping_ * 6);
    }
  }
}

void EdgeFit::choose_strip(const Taps& taps, int steps) {
  if (side_ == 0) return;
  const auto cost = [&] {
    return residual_.squaredNorm() + prior_weight_.cwiseProduct(parameters_ - prior_).squaredNorm();
  };
  const Eigen::VectorXd start = parameters_;
  strip_ = 0;
  parameters_[kStrip] = 0;
  damping_ = 1e-3;
  refine(taps, steps);
  const Eigen::VectorXd without = parameters_;
  const double cost_without = cost();
  parameters_ = start;
  strip_ = side_;
  damping_ = 1e-3;
  if (parameters_[kStrip] == 0) parameters_[kStrip] = 0.2;
  refine(taps, steps);
  if (cost_without - cost() > kStripGain) return;
  strip_ = 0;
  parameters_ = without;
}

void EdgeFit::expect_blur(double log_mean, double spread) {
  prior_[kBlur] = log_mean;
  prior_weight_[kBlur] = 1 / spread;
}

EdgeFit::Reduced EdgeFit::reduce(const Taps& taps) {
  jacobian(taps);
  Eigen::MatrixXd h = own_jacobian_.transpose() * own_jacobian_;
  h.diagonal() += prior_weight_.cwiseAbs2();
  const Eigen::VectorXd g = -own_jacobian_.transpose() * residual_ -
                            prior_weight_.cwiseAbs2().cwiseProduct(parameters_ - prior_);
  const Eigen::MatrixXd cross = own_jacobian_.transpose() * tap_jacobian_;
  const auto solver = h.ldlt();
  Reduced out;
  out.information =
      tap_jacobian_.transpose() * tap_jacobian_ - cross.transpose() * solver.solve(cross);
  out.gradient = -tap_jacobian_.transpose() * residual_ - cross.transpose() * solver.solve(g);
  return out;
}

double EdgeFit::blur() const { return std::exp(parameters_[kBlur]); }

double EdgeFit::misfit() const {
  return std::sqrt(residual_.squaredNorm() /
                   std::max<double>(1, static_cast<double>(residual_.size() - own_)));
}

double EdgeFit::residual_rms() const {
  double sum = 0;
  for (Eigen::Index i = 0; i < residual_.size(); ++i) sum += std::pow(residual_[i] / weight_[i], 2);
  return std::sqrt(sum / static_cast<double>(std::max<Eigen::Index>(1, residual_.size()))) / scale_;
}

}  // namespace touchline::compensate
