#include "edge/compensate/edge_profile.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <optional>

namespace touchline::compensate {
namespace {

constexpr int kFrom = 5;     // ground, from the edge, pixels along the row
constexpr int kTo = 10;      // up to here
constexpr int kWidest = 16;  // bar, pixels along the row
constexpr int kReach = kWidest + kTo + 2;
constexpr int kRows = 14;           // followed at most on either side
constexpr int kLeastRows = 11;      // in all
constexpr int kEvery = 7;           // rows between the starts
constexpr double kStraight = 0.12;  // rms from a straight line, pixels
constexpr double kFlat = 0.07;      // mean deviation of the ground, share of the step
constexpr double kTilt = 0.03;      // of the averaged ground, share of the step
constexpr double kSlope = 1.05;     // dx/dy
constexpr int kBinsPerPixel = 4;

// Luma with the axes swapped where edges are close to horizontal, so that profiles run along x.
struct Picture {
  image::ImageView<const std::uint16_t> luma;
  bool swapped;
  int width() const { return swapped ? luma.height : luma.width; }
  int height() const { return swapped ? luma.width : luma.height; }
  int operator()(int x, int y) const { return swapped ? luma.row(x)[y] : luma.row(y)[x]; }
};

struct Ground {
  double level = 0;
  double deviation = 0;
};

Ground ground(const Picture& p, int from, int to, int y) {
  Ground g;
  const int n = to - from + 1;
  int sum = 0;
  for (int x = from; x <= to; ++x) sum += p(x, y);
  g.level = static_cast<double>(sum) / n;
  for (int x = from; x <= to; ++x) g.deviation += std::abs(p(x, y) - g.level);
  g.deviation /= n;
  return g;
}

// Where the row crosses `level` between x0 and x1, rising or falling; below a pixel.
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
  double width = 0;
  double left = 0, top = 0, right = 0;
  double deviation = 0;
};

// A bar on row y whose first edge is near x: `bright` on darker ground or dark on brighter.
std::optional<Place> bar_at(const Picture& p, double x, int y, double least, bool bright) {
  const int near = static_cast<int>(std::lround(x));
  if (near < kTo + 4 || near + kReach + 4 >= p.width()) return std::nullopt;
  const Ground left = ground(p, near - kTo - 1, near - kFrom - 1, y);
  if (left.deviation > 60) return std::nullopt;
  // The far edge: where the row comes back to the ground's level.
  int end = near + 1;
  int top = p(near + 1, y);
  for (; end < near + kWidest + 2; ++end) {
    const int v = p(end, y);
    top = bright ? std::max(top, v) : std::min(top, v);
    if (std::abs(top - left.level) > least &&
        std::abs(v - left.level) < 0.35 * std::abs(top - left.level))
      break;
  }
  const double step = top - left.level;
  if (bright ? step < least : step > -least) return std::nullopt;
  if (end >= near + kWidest + 2) return std::nullopt;
  const Ground right = ground(p, end + kFrom, end + kTo, y);
  const double height = std::abs(step);
  if (std::max(left.deviation, right.deviation) > kFlat * height ||
      std::abs(left.level - right.level) > 0.15 * height)
    return std::nullopt;
  const auto a = crossing(p, near - 4, near + 4, y, left.level + 0.5 * step, bright);
  if (!a) return std::nullopt;
  const auto b = crossing(p, std::max(end - 4, static_cast<int>(*a) + 1), end + 1, y,
                          right.level + 0.5 * (top - right.level), !bright);
  if (!b) return std::nullopt;
  return Place{0.5 * (*a + *b),          *b - *a,     left.level,
               static_cast<double>(top), right.level, 0.5 * (left.deviation + right.deviation)};
}

// A step near x.
std::optional<Place> step_at(const Picture& p, double x, int y, double least, bool rising) {
  const int near = static_cast<int>(std::lround(x));
  if (near < kTo + 2 || near + kTo + 2 >= p.width()) return std::nullopt;
  const Ground left = ground(p, near - kTo, near - kFrom, y);
  const Ground right = ground(p, near + kFrom, near + kTo, y);
  const double step = right.level - left.level;
  if (rising ? step < least : step > -least) return std::nullopt;
  if (std::max(left.deviation, right.deviation) > kFlat * std::abs(step)) return std::nullopt;
  const auto a = crossing(p, near - 4, near + 4, y, 0.5 * (left.level + right.level), rising);
  if (!a) return std::nullopt;
  return Place{*a,          0,           left.level,
               right.level, right.level, 0.5 * (left.deviation + right.deviation)};
}

struct Piece {
  int first = 0, last = 0;  // rows
  double x = 0, slope = 0;  // at row y0: x + slope * (y - y0)
  int y0 = 0;
  Place mean;
};

std::optional<Piece> follow(const Picture& p, double x, int y, double least, bool bar,
                            bool positive) {
  std::array<Place, 2 * kRows + 1> places;
  const auto seek = [&](double at, int row) {
    return bar ? bar_at(p, at, row, least, positive) : step_at(p, at, row, least, positive);
  };
  const auto start = seek(x, y);
  if (!start) return std::nullopt;
  places[kRows] = *start;
  int first = 0;
  int last = 0;
  for (const int direction : {1, -1}) {
    double at = start->centre;
    double half = 0.5 * start->width;
    double slope = 0;
    for (int k = 1; k <= kRows; ++k) {
      const int row = y + direction * k;
      if (row < 0 || row >= p.height()) break;
      const auto place = seek(at + slope - half, row);
      if (!place || std::abs(place->centre - at - slope) > (k < 3 ? 1.6 : 0.8) ||
          std::abs(place->width - 2 * half) > 1.5)
        break;
      slope = (place->centre - start->centre) / k;
      at = place->centre;
      half = 0.5 * place->width;
      places[static_cast<std::size_t>(kRows + direction * k)] = *place;
      (direction > 0 ? last : first) = direction * k;
    }
  }
  const int n = last - first + 1;
  if (n < kLeastRows) return std::nullopt;
  Piece piece;
  piece.first = y + first;
  piece.last = y + last;
  piece.y0 = y;
  double sy = 0, syy = 0, sx = 0, sxy = 0;
  for (int k = first; k <= last; ++k) {
    const Place& q = places[static_cast<std::size_t>(kRows + k)];
    sy += k;
    syy += k * k;
    sx += q.centre;
    sxy += k * q.centre;
    piece.mean.width += q.width / n;
    piece.mean.left += q.left / n;
    piece.mean.right += q.right / n;
    piece.mean.top += q.top / n;
    piece.mean.deviation += q.deviation / n;
  }
  piece.slope = (n * sxy - sx * sy) / (n * syy - sy * sy);
  piece.x = (sx - piece.slope * sy) / n;
  if (std::abs(piece.slope) > kSlope) return std::nullopt;
  double rms = 0;
  for (int k = first; k <= last; ++k) {
    const double e = places[static_cast<std::size_t>(kRows + k)].centre - piece.x - piece.slope * k;
    rms += e * e;
  }
  if (std::sqrt(rms / n) > kStraight) return std::nullopt;
  return piece;
}

std::optional<EdgeProfile> sample(const Picture& p, const Piece& piece, bool bar) {
  EdgeProfile e;
  e.bar = bar;
  const double across = 1 / std::hypot(1, piece.slope);  // pixels across per pixel along the row
  const double nx = across;
  const double ny = std::abs(piece.slope) * across;
  e.cosine = p.swapped ? ny : nx;
  e.sine = p.swapped ? nx : ny;
  e.width = piece.mean.width * across;
  e.left = piece.mean.left;
  e.top = piece.mean.top;
  e.right = piece.mean.right;
  const double reach = 0.5 * e.width + kTo * across;
  const int bins = 2 * static_cast<int>(reach * kBinsPerPixel) + 1;
  std::vector<double> sum(static_cast<std::size_t>(bins)), where(sum), count(sum), square(sum);
  for (int y = piece.first; y <= piece.last; ++y) {
    const double centre = piece.x + piece.slope * (y - piece.y0);
    const int from = static_cast<int>(std::ceil(centre - reach / across));
    const int to = static_cast<int>(std::floor(centre + reach / across));
    for (int x = std::max(0, from); x <= std::min(p.width() - 1, to); ++x) {
      const double t = (x - centre) * across;
      const long b = std::lround(t * kBinsPerPixel) + bins / 2;
      if (b < 0 || b >= bins) continue;
      const auto i = static_cast<std::size_t>(b);
      const double v = p(x, y);
      sum[i] += v;
      square[i] += v * v;
      where[i] += t;
      count[i] += 1;
    }
  }
  double spread = 0;
  double samples = 0;
  std::array<double, 4> level{}, weight{};  // outer and inner half of the ground, both sides
  const double near = 0.5 * e.width + kFrom * across;
  for (std::size_t i = 0; i < sum.size(); ++i) {
    if (count[i] < 1) continue;
    const double t = where[i] / count[i];
    const double v = sum[i] / count[i];
    e.at.push_back(static_cast<float>(t));
    e.value.push_back(static_cast<float>(v));
    e.number.push_back(static_cast<float>(count[i]));
    if (std::abs(t) < near) continue;
    if (count[i] > 1) {
      spread += square[i] - sum[i] * v;
      samples += count[i] - 1;
    }
    const std::size_t half = std::abs(t) > 0.5 * (near + reach) ? 1 : 0;
    level[(t > 0 ? 2 : 0) + half] += sum[i];
    weight[(t > 0 ? 2 : 0) + half] += count[i];
  }
  if (samples < 20) return std::nullopt;
  e.noise = std::sqrt(spread / samples);
  const double height = e.step();
  for (const std::size_t side : {0U, 2U}) {
    if (weight[side] < 1 || weight[side + 1] < 1) return std::nullopt;
    const double tilt = level[side] / weight[side] - level[side + 1] / weight[side + 1];
    if (std::abs(tilt) > kTilt * height + 1) return std::nullopt;
  }
  // Sharpness: the steepest rise between samples about a pixel apart.
  double rise = 0;
  for (std::size_t i = 0; i < e.at.size(); ++i)
    for (std::size_t k = i + 1; k < e.at.size() && e.at[k] - e.at[i] < 1.3f; ++k)
      if (e.at[k] - e.at[i] > 0.8f)
        rise = std::max(
            rise, static_cast<double>(std::abs(e.value[k] - e.value[i]) / (e.at[k] - e.at[i])));
  rise /= height;
  if (rise < 0.22) return std::nullopt;
  e.quality = std::min(rise, 0.8) / (0.02 + e.noise / (height * std::sqrt(samples / 20)));
  return e;
}

}  // namespace

double EdgeProfile::step() const {
  return bar ? std::abs(top - 0.5 * (left + right)) : std::abs(right - left);
}

std::vector<EdgeProfile> find_edges(image::ImageView<const std::uint16_t> luma, double least) {
  std::vector<EdgeProfile> edges;
  for (const bool swapped : {false, true}) {
    const Picture p{luma, swapped};
    const double start = 0.2 * least;
    std::vector<Piece> taken;
    for (int y = kEvery / 2; y < p.height(); y += kEvery) {
      int x = kTo + 4;
      while (x + kTo + 6 < p.width()) {
        const int gradient = p(x + 1, y) - p(x - 1, y);
        if (std::abs(gradient) < start) {
          ++x;
          continue;
        }
        // The steepest place of this slope.
        int steepest = x;
        int most = std::abs(gradient);
        int end = x + 1;
        for (; end + kTo + 6 < p.width(); ++end) {
          const int g = p(end + 1, y) - p(end - 1, y);
          if (std::abs(g) < start || (g > 0) != (gradient > 0)) break;
          if (std::abs(g) > most) {
            most = std::abs(g);
            steepest = end;
          }
        }
        x = end;
        const bool rising = gradient > 0;
        bool bar = false;
        auto piece = follow(p, steepest, y, least, false, rising);
        if (!piece) {
          piece = follow(p, steepest, y, least, true, rising);
          bar = true;
        }
        if (!piece) continue;
        const bool again = std::any_of(taken.begin(), taken.end(), [&](const Piece& t) {
          return t.last >= piece->first &&
                 std::abs(t.x + t.slope * (piece->y0 - t.y0) - piece->x) < 2;
        });
        if (again) continue;
        std::erase_if(taken, [&](const Piece& t) { return t.last < y - kRows; });
        taken.push_back(*piece);
        auto edge = sample(p, *piece, bar);
        if (edge) edges.push_back(std::move(*edge));
        if (bar) x = std::max(x, static_cast<int>(piece->x + 0.5 * piece->mean.width) + 3);
      }
    }
  }
  return edges;
}

}  // namespace touchline::compensate
