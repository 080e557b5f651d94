#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

#include "tools/sim/render/blocks_internal.h"
#include "tools/sim/render/lens_internal.h"
#include "tools/sim/render/outline_internal.h"

namespace touchline::sim::render {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

struct Box {
  float u0 = 1e9f, v0 = 1e9f, u1 = -1e9f, v1 = -1e9f;
  void take(const Vector2f& p) {
    u0 = std::min(u0, p.x());
    v0 = std::min(v0, p.y());
    u1 = std::max(u1, p.x());
    v1 = std::max(v1, p.y());
  }
  bool meets(const Box& o) const { return u0 <= o.u1 && o.u0 <= u1 && v0 <= o.v1 && o.v0 <= v1; }
};

// The blocks of a picture without its lens, one unit before the camera, where edges are straight.
struct Grid {
  int columns, rows;
  std::vector<Box> blocks, by_column, by_row;

  Grid(const geometry::CameraModel& model, int block, float slack_px)
      : columns((model.width + block - 1) / block),
        rows((model.height + block - 1) / block),
        blocks(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)),
        by_column(static_cast<std::size_t>(columns)),
        by_row(static_cast<std::size_t>(rows)) {
    const LensTable lens(model);
    const auto corner = [&](int i, int j) {
      const float u = (static_cast<float>(i * block) - 0.5f - static_cast<float>(model.cx)) /
                      static_cast<float>(model.fx);
      const float v = (static_cast<float>(j * block) - 0.5f - static_cast<float>(model.cy)) /
                      static_cast<float>(model.fy);
      float factor, slope;
      lens.at(u * u + v * v, factor, slope);
      return Vector2f(u * factor, v * factor);
    };
    const float slack = slack_px / static_cast<float>(std::min(model.fx, model.fy)) * 1.5f;
    std::vector<Vector2f> above;
    for (int i = 0; i <= columns; ++i) above.push_back(corner(i, 0));
    for (int j = 0; j < rows; ++j) {
      std::vector<Vector2f> under;
      for (int i = 0; i <= columns; ++i) under.push_back(corner(i, j + 1));
      for (std::size_t i = 0; i < static_cast<std::size_t>(columns); ++i) {
        Box& box = blocks[static_cast<std::size_t>(j * columns) + i];
        for (const Vector2f& p : {above[i], above[i + 1], under[i], under[i + 1]}) box.take(p);
        box.u0 -= slack;
        box.v0 -= slack;
        box.u1 += slack;
        box.v1 += slack;
        for (Box* sum : {&by_column[i], &by_row[static_cast<std::size_t>(j)]}) {
          sum->take({box.u0, box.v0});
          sum->take({box.u1, box.v1});
        }
      }
      above = std::move(under);
    }
  }
};

constexpr float kNearest = 0.05f;  // where rays begin

// Marks the blocks that a triangle in the camera's frame may cover.
void mark(const Grid& grid, const std::array<Vector3f, 3>& triangle,
          std::vector<std::uint8_t>& marks) {
  std::array<Vector2f, 4> corners;
  std::size_t count = 0;
  Box bounds;
  const auto add = [&](const Vector3f& p) {
    corners[count] = {p.x() / p.z(), p.y() / p.z()};
    bounds.take(corners[count++]);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector3f &p = triangle[i], &q = triangle[(i + 1) % 3];
    if (p.z() >= kNearest) add(p);
    if ((p.z() >= kNearest) != (q.z() >= kNearest)) {
      const float t = (kNearest - p.z()) / (q.z() - p.z());
      Vector3f cut = p + t * (q - p);
      cut.z() = kNearest;
      add(cut);
    }
  }
  if (count == 0) return;
  // Lines along the sides, positive within.
  struct Side {
    float a, b, c, slack;
  };
  std::array<Side, 4> sides;
  std::size_t used = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2f &p = corners[i], edge = corners[(i + 1) % count] - p;
    Side side{-edge.y(), edge.x(), edge.y() * p.x() - edge.x() * p.y(),
              1e-5f * (std::abs(edge.x()) + std::abs(edge.y())) *
                  (1 + std::abs(p.x()) + std::abs(p.y()))};
    float inner = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const float s = side.a * corners[k].x() + side.b * corners[k].y() + side.c;
      if (std::abs(s) > std::abs(inner)) inner = s;
    }
    if (std::abs(inner) <= side.slack) continue;  // no side to speak of
    if (inner < 0) side = {-side.a, -side.b, -side.c, side.slack};
    sides[used++] = side;
  }
  const auto outside = [&](const Box& box) {
    const float u = 0.5f * (box.u0 + box.u1), v = 0.5f * (box.v0 + box.v1);
    const float half_u = box.u1 - u, half_v = box.v1 - v;
    for (std::size_t i = 0; i < used; ++i) {
      const Side& s = sides[i];
      const float reach = std::abs(s.a) * half_u + std::abs(s.b) * half_v;
      if (s.a * u + s.b * v + s.c + reach + s.slack < 0) return true;
    }
    return false;
  };
  for (int j = 0; j < grid.rows; ++j) {
    if (!grid.by_row[static_cast<std::size_t>(j)].meets(bounds)) continue;
    for (int i = 0; i < grid.columns; ++i) {
      if (!grid.by_column[static_cast<std::size_t>(i)].meets(bounds)) continue;
      const auto at = static_cast<std::size_t>(j * grid.columns + i);
      std::atomic_ref<std::uint8_t> found(marks[at]);
      if (found.load(std::memory_order_relaxed) != 0) continue;
      if (grid.blocks[at].meets(bounds) && !outside(grid.blocks[at]))
        found.store(1, std::memory_order_relaxed);
    }
  }
}

}  // namespace

std::vector<std::uint8_t> blocks_with_solids(const Exposure& exposure, const Ground& ground,
                                             std::uint32_t mask, int block) {
  const geometry::CameraModel& model = exposure.open.model;
  // Between its two poses the camera leaves neither by more than half of its way.
  float slack = 1;
  const bool moving = moves(exposure);
  if (moving) {
    for (const double x : {0.0, 0.5, 1.0})
      for (const double y : {0.0, 0.5, 1.0})
        slack = std::max(
            slack, 1 + 0.8f * picture_motion(exposure, {x * model.width, y * model.height}).norm());
    // What is near moves further where the camera itself moves.
    const double way = (geometry::origin(exposure.open.cam_from_world) -
                        geometry::origin(exposure.close.cam_from_world))
                           .norm();
    slack += static_cast<float>(way * std::max(model.fx, model.fy));  // at one metre
  }
  std::vector<std::uint8_t> marks;
  for (const ShutterPose* pose : {&exposure.open, &exposure.close}) {
    if (pose == &exposure.close && !moving) break;
    const Grid grid(pose->model, block, slack);
    marks.resize(grid.blocks.size(), 0);
    const Eigen::Matrix3f rotation = pose->cam_from_world.rotation.toRotationMatrix().cast<float>();
    const Vector3f origin = geometry::origin(pose->cam_from_world).cast<float>();
    tbb::parallel_for(0u, kFigureGeometry, [&](unsigned g) {
      if ((geometry_mask(g) & mask) == 0) return;
      const world::SolidMesh& mesh = ground.mesh(g);
      std::vector<Vector3f> seen;
      seen.reserve(mesh.vertices.size());
      for (const Vector3f& p : mesh.vertices) seen.push_back(rotation * (p - origin));
      for (const auto& t : mesh.triangles) mark(grid, {seen[t[0]], seen[t[1]], seen[t[2]]}, marks);
    });
  }
  return marks;
}

}  // namespace touchline::sim::render
