#include "tools/sim/world/line_paint.h"

#include <numbers>

namespace touchline::sim::world {
namespace {

constexpr float kCell = 1.0f;   // metres
constexpr float kReach = 1.0f;  // metres round a cell within which its strokes are listed
constexpr float kDash = 1.0f;   // metres painted, and as much left out

// Sides of the footprint along a unit normal.
struct Widths {
  float a, b;
};
Widths widths(const Footprint& f, float nx, float ny) {
  return {std::abs(f.ax * nx + f.ay * ny), std::abs(f.bx * nx + f.by * ny)};
}

bool is_partial(float c) { return c > 0.004f && c < 0.996f; }

}  // namespace

LinePaint::LinePaint(const pitch::PitchModel& pitch, const LinesSpec& spec) {
  for (const pitch::Marking& m : pitch.markings) {
    Stroke s;
    s.half_width = static_cast<float>(m.width / 2);
    s.dashed = m.dashed;
    if (m.shape == pitch::MarkingShape::kLine) {
      const Eigen::Vector2d middle = 0.5 * (m.start + m.end), along = m.tangent(0);
      s.x = static_cast<float>(middle.x());
      s.y = static_cast<float>(middle.y());
      s.tx = static_cast<float>(along.x());
      s.ty = static_cast<float>(along.y());
      s.half_length = static_cast<float>(m.length() / 2);
    } else {
      s.shape = m.shape == pitch::MarkingShape::kArc ? Shape::kRing : Shape::kDisc;
      s.x = static_cast<float>(m.centre.x());
      s.y = static_cast<float>(m.centre.y());
      s.radius = static_cast<float>(m.radius);
      s.tx = static_cast<float>(std::cos(m.start_angle));
      s.ty = static_cast<float>(std::sin(m.start_angle));
      s.ex = static_cast<float>(std::cos(m.end_angle));
      s.ey = static_cast<float>(std::sin(m.end_angle));
      s.whole = m.end_angle - m.start_angle > 2 * std::numbers::pi - 1e-6;
      s.reflex = m.end_angle - m.start_angle > std::numbers::pi;
    }
    strokes_.push_back(s);
  }
  if (spec.other_sport) {
    // Two small pitches across the big one, one in each half.
    const auto hl = static_cast<float>(pitch.length_m / 2),
               hw = static_cast<float>(pitch.width_m / 2);
    const auto strip = [&](float x0, float y0, float x1, float y1) {
      Stroke s;
      s.other = true;
      s.half_width = static_cast<float>(spec.other_width_m / 2);
      s.x = 0.5f * (x0 + x1);
      s.y = 0.5f * (y0 + y1);
      s.half_length = 0.5f * std::hypot(x1 - x0, y1 - y0);
      s.tx = (x1 - x0) / (2 * s.half_length);
      s.ty = (y1 - y0) / (2 * s.half_length);
      strokes_.push_back(s);
    };
    for (const float end : {-1.0f, 1.0f}) {
      const float x0 = end * 3.2f, x1 = end * (hl - 4.1f), y = hw - 5.3f;
      strip(x0, -y, x0, y);
      strip(x1, -y, x1, y);
      for (const float side : {-1.0f, 1.0f}) {
        strip(x0, side * y, x1, side * y);
        const float xm = 0.5f * (x0 + x1), box = 7.3f;
        strip(xm - box, side * (y - 8), xm + box, side * (y - 8));
        strip(xm - box, side * y, xm - box, side * (y - 8));
        strip(xm + box, side * y, xm + box, side * (y - 8));
      }
      strip(x0, 0, x1, 0);
    }
  }
  origin_x_ = -static_cast<float>(pitch.length_m / 2 + pitch.in_goal_m) - 4;
  origin_y_ = -static_cast<float>(pitch.width_m / 2) - 4;
  cells_x_ = static_cast<int>(-2 * origin_x_ / kCell) + 1;
  cells_y_ = static_cast<int>(-2 * origin_y_ / kCell) + 1;
  build_cells();
}

void LinePaint::build_cells() {
  for (int j = 0; j < cells_y_; ++j)
    for (int i = 0; i < cells_x_; ++i) {
      first_.push_back(static_cast<std::uint32_t>(near_.size()));
      const float x = origin_x_ + (static_cast<float>(i) + 0.5f) * kCell;
      const float y = origin_y_ + (static_cast<float>(j) + 0.5f) * kCell;
      const float reach = kReach + 0.7072f * kCell;
      for (std::size_t k = 0; k < strokes_.size(); ++k) {
        const Stroke& s = strokes_[k];
        const float dx = x - s.x, dy = y - s.y;
        float distance = 0;
        if (s.shape == Shape::kStrip) {
          const float along = std::abs(dx * s.tx + dy * s.ty), across = dy * s.tx - dx * s.ty;
          distance = std::hypot(std::max(along - s.half_length, 0.0f), across) - s.half_width;
        } else if (s.shape == Shape::kRing) {
          distance = std::abs(std::hypot(dx, dy) - s.radius) - s.half_width;
        } else {
          distance = std::hypot(dx, dy) - s.radius;
        }
        if (distance <= reach) near_.push_back(static_cast<std::uint16_t>(k));
      }
    }
  first_.push_back(static_cast<std::uint32_t>(near_.size()));
}

void LinePaint::add(const Stroke& s, LineCover& cover, int& partial, float x, float y,
                    const Footprint& f) const {
  const float dx = x - s.x, dy = y - s.y;
  float side = 0;  // along the normal
  float ends = 1;
  if (s.shape == Shape::kStrip) {
    const float across = dy * s.tx - dx * s.ty, along = dx * s.tx + dy * s.ty;
    const Widths n = widths(f, -s.ty, s.tx);
    const float reach = 0.5f * (n.a + n.b) + s.half_width;
    if (std::abs(across) > reach) return;
    const Widths t = widths(f, s.tx, s.ty);
    if (std::abs(along) > s.half_length + 0.5f * (t.a + t.b)) return;
    side =
        edge_cover(across - s.half_width, n.a, n.b) - edge_cover(across + s.half_width, n.a, n.b);
    ends = edge_cover(std::abs(along) - s.half_length, t.a, t.b);
    if (s.dashed) {
      const float phase = along / (2 * kDash);
      const float off = std::abs(phase - std::round(phase)) * 2 * kDash;  // from a dash's middle
      ends *= edge_cover(off - 0.5f * kDash, t.a, t.b);
    }
  } else {
    const float r = std::sqrt(dx * dx + dy * dy);
    const float nx = r > 1e-6f ? dx / r : 1, ny = r > 1e-6f ? dy / r : 0;
    const Widths n = widths(f, nx, ny);
    const float reach = 0.5f * (n.a + n.b) + s.half_width;
    if (s.shape == Shape::kDisc) {
      if (r > s.radius + 0.5f * (n.a + n.b)) return;
      side = edge_cover(r - s.radius, n.a, n.b);
      if (is_partial(side)) ++partial;  // a small disc has no straight edge
    } else {
      if (std::abs(r - s.radius) > reach) return;
      side = edge_cover(r - s.radius - s.half_width, n.a, n.b) -
             edge_cover(r - s.radius + s.half_width, n.a, n.b);
      // Where the arc bends within the footprint its edge is not straight.
      if (is_partial(side) &&
          0.16f * s.radius < std::abs(f.ax) + std::abs(f.bx) + std::abs(f.ay) + std::abs(f.by))
        ++partial;
      if (!s.whole) {
        // Beyond the start's half plane and before the end's.
        const Widths ws = widths(f, -s.ty, s.tx), we = widths(f, -s.ey, s.ex);
        const float after = edge_cover(-(s.tx * dy - s.ty * dx), ws.a, ws.b);
        const float before = edge_cover(s.ex * dy - s.ey * dx, we.a, we.b);
        ends = s.reflex ? std::max(after, before) : std::min(after, before);
      }
    }
  }
  const float c = side * ends;
  if (c <= 0) return;
  if (is_partial(side)) ++partial;
  if (is_partial(ends)) partial += 2;
  float& sum = s.other ? cover.other : cover.lines;
  sum = std::max(sum, c);
}

unsigned LinePaint::near_lines(Floats x, Floats y, Floats extent) const {
  const Floats i = (x - all(origin_x_)) * all(1 / kCell), j = (y - all(origin_y_)) * all(1 / kCell);
  const Floats width = all(static_cast<float>(cells_x_)),
               height = all(static_cast<float>(cells_y_));
  const Floats inside =
      both(both(at_most(all(0), i), at_most(all(0), j)), both(below(i, width), below(j, height)));
  const Floats far_reaching = below(all(kReach), extent);
  const Ints column = whole(both(inside, i)), row = whole(both(inside, j));
  const Ints cell = _mm256_add_epi32(_mm256_mullo_epi32(row, all_ints(cells_x_)), column);
  const int* first = reinterpret_cast<const int*>(first_.data());
  const Ints begin = _mm256_i32gather_epi32(first, cell, sizeof(int));
  const Ints end = _mm256_i32gather_epi32(first + 1, cell, sizeof(int));
  const Floats any = _mm256_castsi256_ps(_mm256_cmpgt_epi32(end, begin));
  return bits_of(_mm256_or_ps(far_reaching, both(inside, any)));
}

LineCover LinePaint::cover(float x, float y, const Footprint& f) const {
  LineCover cover;
  int partial = 0;
  const float extent =
      0.5f * (std::max(std::abs(f.ax) + std::abs(f.bx), std::abs(f.ay) + std::abs(f.by)));
  if (extent > kReach) {
    for (const Stroke& s : strokes_) add(s, cover, partial, x, y, f);
  } else {
    const float i = (x - origin_x_) * (1 / kCell), j = (y - origin_y_) * (1 / kCell);
    if (!(i >= 0 && j >= 0 && i < static_cast<float>(cells_x_) && j < static_cast<float>(cells_y_)))
      return cover;
    const auto cell =
        static_cast<std::size_t>(static_cast<int>(j) * cells_x_ + static_cast<int>(i));
    for (std::uint32_t k = first_[cell]; k < first_[cell + 1]; ++k)
      add(strokes_[near_[k]], cover, partial, x, y, f);
  }
  cover.detail = partial > 1;
  return cover;
}

}  // namespace touchline::sim::world
