#include "edge/encode/silhouettes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace touchline::encode {
namespace {

using Eigen::Vector2f;
using Eigen::Vector2i;
using Ring = std::vector<Vector2f>;

constexpr int kThreshold = 128;  // as image::Matte has it
constexpr float kLevel = 127.5f;

// Alpha, with what cannot be told as full foreground and nothing outside the matte's region,
// whatever its planes hold there.
class Field {
 public:
  explicit Field(const image::Matte& matte) : matte_(matte) {}
  int operator()(const Vector2i& p) const {
    if (!matte_.region.contains(p.x(), p.y())) return 0;
    return (matte_.unknown(p.x(), p.y()) | matte_.occluders(p.x(), p.y())) != 0
               ? 255
               : matte_.alpha(p.x(), p.y());
  }

 private:
  const image::Matte& matte_;
};

// Where a row changes from background to foreground: every ring passes one of these going down.
class Starts {
 public:
  explicit Starts(const image::Matte& matte) {
    const image::Rect& region = matte.region;
    first_row_ = region.y;
    std::vector<std::uint8_t> row(static_cast<std::size_t>(region.width));
    for (int y = region.y; y < region.y + region.height; ++y) {
      offsets_.push_back(columns_.size());
      const std::uint8_t* const alpha = matte.alpha.row(y) + region.x;
      const std::uint8_t* const unknown = matte.unknown.row(y) + region.x;
      const std::uint8_t* const occluders = matte.occluders.row(y) + region.x;
      std::uint8_t any = 0;
      for (std::size_t x = 0; x < row.size(); ++x) {
        // The high bit: alpha of 128 and more, masks of 255.
        row[x] = static_cast<std::uint8_t>((alpha[x] | unknown[x] | occluders[x]) & kThreshold);
        any |= row[x];
      }
      if (any == 0) continue;
      // Eight pixels at a time; most words are all background or all foreground.
      std::uint64_t left = 0;  // the pixel before the word
      std::size_t x = 0;
      for (; x + 8 <= row.size(); x += 8) {
        std::uint64_t word = 0;
        std::memcpy(&word, row.data() + x, 8);
        std::uint64_t starts = word & ~((word << 8) | left);
        for (; starts != 0; starts &= starts - 1)
          add(region.x + static_cast<int>(x) + std::countr_zero(starts) / 8);
        left = word >> 56;
      }
      for (; x < row.size(); ++x) {
        if (row[x] > left) add(region.x + static_cast<int>(x));
        left = row[x];
      }
    }
    offsets_.push_back(columns_.size());
  }

  struct Column {
    int x = 0;
    bool seen = false;
  };
  // True the first time it is asked about a place.
  bool take(int x, int y) {
    const auto row = static_cast<std::size_t>(y - first_row_);
    const auto begin = columns_.begin() + static_cast<std::ptrdiff_t>(offsets_[row]);
    const auto end = columns_.begin() + static_cast<std::ptrdiff_t>(offsets_[row + 1]);
    const auto found =
        std::lower_bound(begin, end, x, [](const Column& column, int at) { return column.x < at; });
    if (found == end || found->x != x || found->seen) return false;
    found->seen = true;
    return true;
  }
  std::size_t rows() const { return offsets_.size() - 1; }
  int row(std::size_t index) const { return first_row_ + static_cast<int>(index); }
  std::size_t begin(std::size_t index) const { return offsets_[index]; }
  std::size_t end(std::size_t index) const { return offsets_[index + 1]; }
  int x(std::size_t column) const { return columns_[column].x; }

 private:
  void add(int x) { columns_.push_back({x, false}); }

  int first_row_ = 0;
  std::vector<std::size_t> offsets_;
  std::vector<Column> columns_;
};

// Walks along the boundary with the foreground on the left hand.
struct Walker {
  Vector2i left;   // the foreground pixel beside the boundary
  Vector2i right;  // the background pixel across it
  Vector2i ahead;  // direction of the walk
  bool operator==(const Walker&) const = default;
};

Vector2i turned_left(const Vector2i& d) { return {d.y(), -d.x()}; }  // seen with y down
Vector2i turned_right(const Vector2i& d) { return {-d.y(), d.x()}; }

Walker step(const Field& field, const Walker& at) {
  const Vector2i ahead_left = at.left + at.ahead;
  const Vector2i ahead_right = at.right + at.ahead;
  const int left = field(ahead_left);
  const int right = field(ahead_right);
  const bool left_on = left >= kThreshold;
  const bool right_on = right >= kThreshold;
  const bool joined = field(at.left) + field(at.right) + left + right >= 4 * kThreshold;
  if (right_on && (left_on || joined)) return {ahead_right, at.right, turned_right(at.ahead)};
  if (left_on) return {ahead_left, ahead_right, at.ahead};
  return {at.left, ahead_left, turned_left(at.ahead)};
}

Vector2f crossing(const Field& field, const Walker& at) {
  const auto inside = static_cast<float>(field(at.left));
  const auto outside = static_cast<float>(field(at.right));
  const float t = (kLevel - outside) / (inside - outside);
  return at.right.cast<float>() + t * (at.left - at.right).cast<float>();
}

Ring walk(const Field& field, Starts& starts, int x, int y) {
  const Walker start{{x, y}, {x - 1, y}, {0, 1}};
  Ring ring;
  Walker at = start;
  do {
    ring.push_back(crossing(field, at));
    at = step(field, at);
    if (at.ahead.y() == 1) starts.take(at.left.x(), at.left.y());
  } while (at != start);
  return ring;
}

float distance_squared(const Vector2f& p, const Vector2f& a, const Vector2f& b) {
  const Vector2f ab = b - a;
  const float length = ab.squaredNorm();
  const float t = length > 0 ? std::clamp((p - a).dot(ab) / length, 0.0f, 1.0f) : 0.0f;
  return (p - a - t * ab).squaredNorm();
}

// Marks which of ring[from..to] to keep, ends included; indices run modulo the ring's size.
void simplify(const Ring& ring, std::size_t from, std::size_t to, float limit,
              std::vector<bool>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{from, to}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    float worst = limit;
    std::size_t at = 0;
    for (std::size_t i = a + 1; i < b; ++i) {
      const float d = distance_squared(ring[i], ring[a], ring[b % ring.size()]);
      if (d > worst) {
        worst = d;
        at = i;
      }
    }
    if (at == 0) continue;
    keep[at] = true;
    open.emplace_back(a, at);
    open.emplace_back(at, b);
  }
}

Ring simplified(const Ring& ring, float tolerance) {
  std::size_t far = 0;
  for (std::size_t i = 1; i < ring.size(); ++i) {
    if ((ring[i] - ring[0]).squaredNorm() > (ring[far] - ring[0]).squaredNorm()) far = i;
  }
  std::vector<bool> keep(ring.size(), false);
  keep[0] = true;
  keep[far] = true;
  const float limit = tolerance * tolerance;
  simplify(ring, 0, far, limit, keep);
  simplify(ring, far, ring.size(), limit, keep);
  Ring out;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    if (keep[i]) out.push_back(ring[i]);
  }
  return out.size() < 3 ? ring : out;
}

// Twice the signed area; negative for rings that run counter-clockwise seen with y down.
double doubled_area(const Ring& ring) {
  double area = 0;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vector2f& a = ring[i];
    const Vector2f& b = ring[(i + 1) % ring.size()];
    area += double{a.x()} * double{b.y()} - double{b.x()} * double{a.y()};
  }
  return area;
}

}  // namespace

geometry::Partial trace_silhouettes(const image::Matte& matte, float simplify_px) {
  geometry::Partial partial;
  partial.tolerance_px = simplify_px;
  const Field field(matte);
  Starts starts(matte);
  for (std::size_t row = 0; row < starts.rows(); ++row) {
    const int y = starts.row(row);
    for (std::size_t i = starts.begin(row); i < starts.end(row); ++i) {
      if (!starts.take(starts.x(i), y)) continue;
      const Ring ring = walk(field, starts, starts.x(i), y);
      geometry::SilhouettePolygon polygon;
      polygon.hole = doubled_area(ring) > 0;
      polygon.ring = simplified(ring, simplify_px);
      partial.polygons.push_back(std::move(polygon));
    }
  }
  return partial;
}

}  // namespace touchline::encode
