#include <algorithm>
#include <cmath>

#include "edge/calibrate/lines/ridges_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kThetaBins = 180;
constexpr double kRhoStep = 4;
constexpr double kPi = 3.14159265358979323846;
constexpr double kLeastDensity = 0.3;  // points a pixel of a line
constexpr int kSpread = 2;             // theta bins either side that a point votes for

// Votes of the points for lines x cos(theta) + y sin(theta) = rho, theta in [0, pi).
class HoughSpace {
 public:
  HoughSpace(int width, int height)
      : reach_(std::hypot(width, height)),
        rho_bins_(static_cast<int>(2 * reach_ / kRhoStep) + 3),
        votes_(static_cast<std::size_t>(kThetaBins) * static_cast<std::size_t>(rho_bins_), 0) {
    for (int i = 0; i < kThetaBins; ++i) {
      cos_[static_cast<std::size_t>(i)] = std::cos((i + 0.5) * kPi / kThetaBins);
      sin_[static_cast<std::size_t>(i)] = std::sin((i + 0.5) * kPi / kThetaBins);
    }
  }

  void vote(const RidgePoint& point, int sign) {
    double theta = std::atan2(point.normal.y(), point.normal.x());
    if (theta < 0) theta += kPi;
    const int centre = static_cast<int>(theta / kPi * kThetaBins);
    for (int d = -kSpread; d <= kSpread; ++d) {
      const int bin = (centre + d + kThetaBins) % kThetaBins;
      const double rho = point.position.x() * cos_[static_cast<std::size_t>(bin)] +
                         point.position.y() * sin_[static_cast<std::size_t>(bin)];
      const int at = static_cast<int>((rho + reach_) / kRhoStep);
      votes_[static_cast<std::size_t>(bin * rho_bins_ + at)] += sign * (kSpread + 1 - std::abs(d));
    }
  }

  // The strongest line, neighbours in rho counted in.
  bool peak(Eigen::Vector2d& normal, double& offset) {
    int most = 0;
    int best_theta = -1;
    int best_rho = 0;
    for (int t = 0; t < kThetaBins; ++t) {
      const int* row = &votes_[static_cast<std::size_t>(t * rho_bins_)];
      for (int r = 0; r + 1 < rho_bins_; ++r) {
        const int sum = row[r] + row[r + 1];
        if (sum > most) {
          most = sum;
          best_theta = t;
          best_rho = r;
        }
      }
    }
    if (best_theta < 0) return false;
    last_ = static_cast<std::size_t>(best_theta * rho_bins_ + best_rho);
    normal = {cos_[static_cast<std::size_t>(best_theta)],
              sin_[static_cast<std::size_t>(best_theta)]};
    offset = (best_rho + 1) * kRhoStep - reach_;
    return true;
  }

  // The last peak is none from now on.
  void forget_peak() {
    votes_[last_] = kForgotten;
    votes_[last_ + 1] = kForgotten;
  }

 private:
  static constexpr int kForgotten = -(1 << 28);
  double reach_;
  int rho_bins_;
  std::vector<int> votes_;
  std::size_t last_ = 0;
  std::array<double, kThetaBins> cos_{};
  std::array<double, kThetaBins> sin_{};
};

bool near_line(const RidgePoint& point, const Eigen::Vector2d& normal, double offset, double reach,
               double least_cosine) {
  const double d = normal.x() * point.position.x() + normal.y() * point.position.y() - offset;
  const double c = normal.x() * point.normal.x() + normal.y() * point.normal.y();
  return std::abs(d) <= reach && std::abs(c) >= least_cosine;
}

// Least squares across the line; false when the points do not make one.
bool fit(const std::vector<RidgePoint>& points, const std::vector<int>& members,
         LineHypothesis& line) {
  if (members.size() < 2) return false;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int i : members) mean += points[static_cast<std::size_t>(i)].position.cast<double>();
  mean /= static_cast<double>(members.size());
  double xx = 0, xy = 0, yy = 0;
  for (const int i : members) {
    const Eigen::Vector2d d = points[static_cast<std::size_t>(i)].position.cast<double>() - mean;
    xx += d.x() * d.x();
    xy += d.x() * d.y();
    yy += d.y() * d.y();
  }
  const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
  const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
  line.normal = {-along.y(), along.x()};
  line.offset = line.normal.dot(mean);
  double least = 1e12, most = -1e12, squares = 0;
  for (const int i : members) {
    const Eigen::Vector2d p = points[static_cast<std::size_t>(i)].position.cast<double>();
    const double t = along.dot(p - mean);
    least = std::min(least, t);
    most = std::max(most, t);
    const double d = line.normal.dot(p) - line.offset;
    squares += d * d;
  }
  line.start = mean + least * along;
  line.end = mean + most * along;
  line.points = static_cast<int>(members.size());
  line.rms_px = std::sqrt(squares / static_cast<double>(members.size()));
  return most > least;
}

}  // namespace

std::vector<LineHypothesis> find_lines(const std::vector<RidgePoint>& points, int width, int height,
                                       const LineMapOptions& options) {
  std::vector<LineHypothesis> lines;
  if (points.empty()) return lines;
  HoughSpace space(width, height);
  for (const RidgePoint& point : points) space.vote(point, 1);
  std::vector<std::uint8_t> used(points.size(), 0);
  std::vector<int> members;
  const double scale = height / 1080.0;
  const double reach = options.line_tolerance_px * std::max(scale, 0.5);
  int failures = 0;
  while (static_cast<int>(lines.size()) < options.most_lines && failures < options.most_lines) {
    LineHypothesis line;
    if (!space.peak(line.normal, line.offset)) break;
    // From the bin to the line: wide first, then narrow.
    bool fitted = true;
    for (const double r : {2 * reach, reach, reach}) {
      members.clear();
      for (std::size_t i = 0; i < points.size(); ++i)
        if (used[i] == 0 && near_line(points[i], line.normal, line.offset, r, 0.99))
          members.push_back(static_cast<int>(i));
      fitted = fit(points, members, line);
      if (!fitted) break;
    }
    // Scattered pieces that happen to lie in line are none.
    const Eigen::Vector2d span = (line.end - line.start).cwiseAbs();
    const bool good = fitted && line.points >= options.least_line_points &&
                      line.points >= kLeastDensity * span.maxCoeff();
    int removed = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (used[i] != 0 || !near_line(points[i], line.normal, line.offset, 1.5 * reach, 0.985))
        continue;
      used[i] = 1;
      space.vote(points[i], -1);
      ++removed;
    }
    if (good) lines.push_back(line);
    if (!good) ++failures;
    // Points along a bow vote for a line that, once fitted, none of them is on.
    if (removed == 0) space.forget_peak();
  }
  std::stable_sort(
      lines.begin(), lines.end(),
      [](const LineHypothesis& a, const LineHypothesis& b) { return a.points > b.points; });
  return lines;
}

}  // namespace touchline::calibrate
