#include "edge/compensate/detail_estimator.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "edge/compensate/detail_fit.h"

namespace touchline::compensate {
namespace {

constexpr int kSide = 12;           // pixels read on either side of an edge
constexpr int kFlatFrom = 7;        // pixels from the edge at which the ground must be flat
constexpr int kRows = 4;            // neighbours on either side over which an edge must be straight
constexpr double kStraight = 0.12;  // rms of those from a straight line, pixels
constexpr double kFlat = 0.05;      // mean deviation of the ground, share of the step
constexpr double kWidest = 7;       // lines, pixels
constexpr int kAngles = 9;          // classes over 0..90 degrees
constexpr double kNarrowest = 1.2;  // lines, pixels
constexpr double kClipped = 1000;   // code values from here may be clipped
constexpr double kBlurred = 2;      // edges that rise more slowly show no detail, pixels
constexpr double kBlack = 20;       // code values down to here may be clipped
constexpr double kOvershoot = 0.35;  // share of the step that an overshoot may reach

// Luma with the axes swapped where edges are close to horizontal, so that profiles run along x.
struct Picture {
  image::ImageView<const std::uint16_t> luma;
  bool swapped;
  int width() const { return swapped ? luma.height : luma.width; }
  int height() const { return swapped ? luma.width : luma.height; }
  std::uint16_t operator()(int x, int y) const { return swapped ? luma.row(x)[y] : luma.row(y)[x]; }
};

struct Ground {
  double low = 0;   // level left of the edge
  double high = 0;  // right of it
  double noise = 0;
};

// Levels 7..12 pixels away on both sides, and how flat they are.
Ground ground(const Picture& p, int x, int y) {
  Ground g;
  constexpr int n = kSide - kFlatFrom + 1;
  for (int k = kFlatFrom; k <= kSide; ++k) {
    g.low += p(x - k, y);
    g.high += p(x + k, y);
  }
  g.low /= n;
  g.high /= n;
  for (int k = kFlatFrom; k <= kSide; ++k)
    g.noise += std::abs(p(x - k, y) - g.low) + std::abs(p(x + k, y) - g.high);
  g.noise /= 2 * n;
  return g;
}

// Where the profile crosses `level` first between x0 and x1, rising or falling; below a pixel.
std::optional<double> crossing(const Picture& p, int x0, int x1, int y, double level, bool rising) {
  for (int x = x0; x < x1; ++x) {
    const double a = p(x, y);
    const double b = p(x + 1, y);
    if (rising ? (a < level && b >= level) : (a > level && b <= level))
      return x + (level - a) / (b - a);
  }
  return std::nullopt;
}

struct Place {
  double centre = 0;
  double width = 0;  // along the row; 0 = a step
};

// The edge of row y close to x: a step between two levels or a bright line on level ground.
std::optional<Place> locate(const Picture& p, int x, int y, double least, bool line) {
  const Ground g = ground(p, x, y);
  if (!line) {
    const double step = g.high - g.low;
    if (std::abs(step) < least || g.noise > kFlat * std::abs(step)) return std::nullopt;
    const auto at = crossing(p, x - 4, x + 4, y, 0.5 * (g.low + g.high), step > 0);
    if (!at) return std::nullopt;
    return Place{*at, 0};
  }
  double top = 0;
  for (int k = -4; k <= 4; ++k) top = std::max(top, static_cast<double>(p(x + k, y)));
  const double base = 0.5 * (g.low + g.high);
  const double height = top - base;
  if (height < least || std::abs(g.high - g.low) > 0.1 * height || g.noise > kFlat * height)
    return std::nullopt;
  const auto left = crossing(p, x - 6, x + 3, y, base + 0.5 * height, true);
  if (!left) return std::nullopt;
  const auto right = crossing(p, static_cast<int>(*left) + 1, x + 7, y, base + 0.5 * height, false);
  if (!right) return std::nullopt;
  return Place{0.5 * (*left + *right), *right - *left};
}

struct Edge {
  double x = 0;      // on the row
  double slope = 0;  // of x over y
  double width = 0;  // along the row, 0 = a step
};

// The same edge on the rows above and below, if it is straight.
std::optional<Edge> follow(const Picture& p, int x, int y, double least, bool line) {
  std::array<double, 2 * kRows + 1> centre{};
  double width = 0;
  double at = x;
  for (int direction : {1, -1}) {
    at = x;
    for (int k = direction > 0 ? 0 : 1; k <= kRows; ++k) {
      const int row = y + direction * k;
      const int near = static_cast<int>(std::lround(at));
      if (near < kSide + 1 || near + kSide + 2 > p.width()) return std::nullopt;
      const auto place = locate(p, near, row, least, line);
      if (!place || std::abs(place->centre - at) > 2.5) return std::nullopt;
      centre[static_cast<std::size_t>(kRows + direction * k)] = place->centre;
      width += place->width;
      at = place->centre;
    }
  }
  constexpr int n = 2 * kRows + 1;
  double mean = 0;
  double slope = 0;
  double scatter = 0;
  for (int k = -kRows; k <= kRows; ++k) {
    mean += centre[static_cast<std::size_t>(k + kRows)];
    slope += k * centre[static_cast<std::size_t>(k + kRows)];
    scatter += k * k;
  }
  mean /= n;
  slope /= scatter;
  double rms = 0;
  for (int k = -kRows; k <= kRows; ++k) {
    const double e = centre[static_cast<std::size_t>(k + kRows)] - mean - slope * k;
    rms += e * e;
  }
  if (std::sqrt(rms / n) > kStraight || std::abs(slope) > 1.1) return std::nullopt;
  return Edge{mean, slope, width / n};
}

base::Status in_bounds(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is outside {}..{}", value, low, high), "correct the value");
}

}  // namespace

base::Status DetailOptions::validate() const {
  for (const auto& s : {in_bounds("edges_per_frame", edges_per_frame, 16, 100000),
                        in_bounds("step_codes", step_codes, 10, 500),
                        in_bounds("edges_needed", edges_needed, 10, 1000000),
                        in_bounds("least_boost", least_boost, 0, 0.2)})
    if (!s) return s;
  return {};
}

DetailEstimator::DetailEstimator(const DetailOptions& options) : options_(options) {
  options_.edges_per_frame = std::clamp(options_.edges_per_frame, 16, 100000);
  options_.step_codes = std::clamp(options_.step_codes, 10.0, 500.0);
  options_.edges_needed = std::clamp(options_.edges_needed, 10, 1000000);
  options_.least_boost = std::clamp(options_.least_boost, 0.0, 0.2);
}

void DetailEstimator::add(image::ImageView<const std::uint16_t> luma) {
  if (luma.width < 64 || luma.height < 64) return;
  for (const bool swapped : {false, true}) {
    const Picture p{luma, swapped};
    int taken = 0;
    const int limit = options_.edges_per_frame / 2;
    // Rows are visited spread over the picture, so that the limit does not favour its top.
    constexpr int kSpread = 7;
    for (int pass = 0; pass < kSpread && taken < limit; ++pass)
      for (int y = kRows + pass; y + kRows < p.height() && taken < limit; y += kSpread)
        for (int x = kSide + 5; x + kSide + 6 < p.width(); ++x) {
          const int gradient = p(x + 1, y) - p(x - 1, y);
          const int curve = 2 * p(x, y) - p(x - 3, y) - p(x + 3, y);
          const bool step = std::abs(gradient) > 0.4 * options_.step_codes &&
                            std::abs(gradient) >= std::abs(p(x + 2, y) - p(x, y)) &&
                            std::abs(gradient) > std::abs(p(x, y) - p(x - 2, y));
          const bool line =
              curve > options_.step_codes && p(x, y) >= p(x + 1, y) && p(x, y) > p(x - 1, y);
          if (!step && !line) continue;
          std::optional<Edge> edge;
          bool is_line = false;
          if (line) {
            edge = follow(p, x, y, options_.step_codes, true);
            is_line = edge.has_value();
          }
          if (!edge && step) edge = follow(p, x, y, options_.step_codes, false);
          if (!edge) continue;

          const double cosine = 1 / std::sqrt(1 + edge->slope * edge->slope);  // |normal along row|
          const double sine = std::abs(edge->slope) * cosine;
          const double width = edge->width * cosine;
          if (is_line && (width < kNarrowest || width > kWidest)) continue;
          const int centre = static_cast<int>(std::lround(edge->x));
          const Ground g = ground(p, centre, y);
          const double base = is_line ? 0.5 * (g.low + g.high) : std::min(g.low, g.high);
          double top = std::max(g.low, g.high);
          if (is_line)
            for (int k = -3; k <= 3; ++k)
              top = std::max(top, static_cast<double>(p(centre + k, y)));
          const double scale = top - base;
          if (scale < options_.step_codes || base - kOvershoot * scale < kBlack ||
              (is_line && top > kClipped))
            continue;
          // From a quarter to three quarters of the step, across the edge.
          const bool rising = is_line || g.low < g.high;
          const int from = static_cast<int>(std::floor(edge->x - 0.5 * edge->width)) - 4;
          const auto quarter = crossing(p, from, from + 9, y,
                                        rising ? base + 0.25 * scale : base + 0.75 * scale, rising);
          const auto most = crossing(p, from, from + 9, y,
                                     rising ? base + 0.75 * scale : base + 0.25 * scale, rising);
          if (!quarter || !most) continue;
          const double rise = (*most - *quarter) * cosine;
          if (rise < 0 || rise > kBlurred) continue;

          const double nx = swapped ? sine : cosine;
          const double ny = swapped ? cosine : sine;
          const double angle = std::atan2(ny, nx) * 2 / std::numbers::pi;
          const Class c{std::min(kAngles - 1, static_cast<int>(angle * kAngles)),
                        static_cast<int>(rise * 2.5),
                        is_line ? 1 + static_cast<int>(width * 2) : 0};
          Profile& profile = profiles_[c];
          if (profile.sum.empty()) {
            profile.sum.assign(kBins, 0);
            profile.count.assign(kBins, 0);
          }
          profile.cosine += nx;
          profile.sine += ny;
          profile.width += width;
          ++profile.edges;
          ++taken;
          for (int k = -kSide; k <= kSide; ++k) {
            double t = (centre + k - edge->x) * cosine;
            // A falling step is a rising one seen from the other side.
            if (!is_line && g.low > g.high) t = -t;
            const long bin = std::lround((t + kReach) * kBinsPerPixel);
            if (bin < 0 || bin >= kBins) continue;
            const double value = (p(centre + k, y) - base) / scale;
            const auto b = static_cast<std::size_t>(bin);
            profile.sum[b] += value;
            profile.count[b] += 1;
          }
          x += 2;
        }
  }
}

state::DetailModel DetailEstimator::estimate() const { return fit_detail(profiles_, options_); }

}  // namespace touchline::compensate
