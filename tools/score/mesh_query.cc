#include "tools/score/mesh_query.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace touchline::score {

namespace {

constexpr double kColumn = 0.1;  // metres

int column_of(double metres) { return static_cast<int>(std::floor(metres / kColumn)); }

// Twice the signed area of a, b, p in plan.
double side(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& p) {
  return (b.x() - a.x()) * (p.y() - a.y()) - (b.y() - a.y()) * (p.x() - a.x());
}

// Ericson, "Real-Time Collision Detection", 5.1.5.
Eigen::Vector3d closest_on_triangle(const std::array<Eigen::Vector3d, 3>& t,
                                    const Eigen::Vector3d& p) {
  const Eigen::Vector3d ab = t[1] - t[0];
  const Eigen::Vector3d ac = t[2] - t[0];
  const Eigen::Vector3d ap = p - t[0];
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return t[0];
  const Eigen::Vector3d bp = p - t[1];
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return t[1];
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return t[0] + ab * (d1 / (d1 - d3));
  const Eigen::Vector3d cp = p - t[2];
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return t[2];
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return t[0] + ac * (d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return t[1] + (t[2] - t[1]) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)));
  }
  const double scale = 1 / (va + vb + vc);
  return t[0] + ab * (vb * scale) + ac * (vc * scale);
}

}  // namespace

void MeshQuery::add(const geometry::Mesh& mesh) {
  for (const auto& corners : mesh.triangles) {
    Triangle t;
    for (std::size_t i = 0; i < 3; ++i) t[i] = mesh.vertices[corners[i]].cast<double>();
    const auto number = static_cast<std::uint32_t>(triangles_.size());
    const auto [x0, x1] = std::minmax({t[0].x(), t[1].x(), t[2].x()});
    const auto [y0, y1] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
    for (int x = column_of(x0); x <= column_of(x1); ++x) {
      for (int y = column_of(y0); y <= column_of(y1); ++y) columns_[{x, y}].push_back(number);
    }
    triangles_.push_back(std::move(t));
  }
}

bool MeshQuery::inside(const Eigen::Vector3d& point) const {
  // A shift off the lattice on which meshes from voxels have their edges.
  const Eigen::Vector3d p = point + Eigen::Vector3d(1.37e-7, 2.71e-7, 0);
  const auto column = columns_.find({column_of(p.x()), column_of(p.y())});
  if (column == columns_.end()) return false;
  int winding = 0;
  for (const std::uint32_t number : column->second) {
    const Triangle& t = triangles_[number];
    const double a = side(t[1], t[2], p);
    const double b = side(t[2], t[0], p);
    const double c = side(t[0], t[1], p);
    const bool up = a > 0 && b > 0 && c > 0;
    const bool down = a < 0 && b < 0 && c < 0;
    if (!up && !down) continue;
    const double z = (a * t[0].z() + b * t[1].z() + c * t[2].z()) / (a + b + c);
    if (z > p.z()) winding += up ? 1 : -1;
  }
  return winding > 0;
}

double MeshQuery::distance(const Eigen::Vector3d& point, double reach) const {
  double least = reach;
  for (int x = column_of(point.x() - reach); x <= column_of(point.x() + reach); ++x) {
    for (int y = column_of(point.y() - reach); y <= column_of(point.y() + reach); ++y) {
      const auto column = columns_.find({x, y});
      if (column == columns_.end()) continue;
      for (const std::uint32_t number : column->second) {
        const Triangle& t = triangles_[number];
        const auto [low, high] = std::minmax({t[0].z(), t[1].z(), t[2].z()});
        if (low > point.z() + least || high < point.z() - least) continue;
        least = std::min(least, (closest_on_triangle(t, point) - point).norm());
      }
    }
  }
  return least;
}

}  // namespace touchline::score
