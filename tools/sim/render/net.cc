#include <algorithm>
#include <cmath>

#include "tools/sim/render/net_internal.h"

namespace touchline::sim::render {

float bars_cover(float x, float period, float bar, float size) {
  const auto painted = [&](float p) {
    const float whole = std::floor(p / period);
    return whole * bar + std::min(p - whole * period, bar);
  };
  return std::clamp((painted(x + 0.5f * size) - painted(x - 0.5f * size)) / size, 0.0f, 1.0f);
}

Nets::Nets(const world::WorldData& world)
    : nets_(world.structure.nets),
      mesh_(static_cast<float>(world.spec.goals.net_mesh_m)),
      cord_(static_cast<float>(world.spec.goals.net_cord_m)) {
  if (nets_.size() > 32) nets_.resize(32);
}

std::vector<std::uint32_t> Nets::by_tile(const Exposure& exposure, int tile, int columns,
                                         int rows) const {
  std::vector<std::uint32_t> bits(
      static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (std::size_t n = 0; n < nets_.size(); ++n) {
    double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
    bool everywhere = false;
    for (const ShutterPose* pose : {&exposure.open, &exposure.close})
      for (const float a : {0.0f, 0.5f, 1.0f})
        for (const float b : {0.0f, 0.5f, 1.0f}) {
          const Eigen::Vector3f p = nets_[n].origin + a * nets_[n].u + b * nets_[n].v;
          const Eigen::Vector3d q = pose->cam_from_world * p.cast<double>();
          if (q.z() < 0.3) {
            // Wholly behind, or too near to tell.
            everywhere = everywhere || q.z() > -8;
            continue;
          }
          geometry::CameraModel plain = pose->model;
          if (const auto pixel = plain.project(q)) {
            x0 = std::min(x0, pixel->x());
            x1 = std::max(x1, pixel->x());
            y0 = std::min(y0, pixel->y());
            y1 = std::max(y1, pixel->y());
          } else {
            // Beyond the lens' fold: out of the picture, but the panel may reach in.
            const double u = q.x() / q.z(), v = q.y() / q.z();
            x0 = std::min(x0, u < 0 ? -1e6 : x0);
            x1 = std::max(x1, u > 0 ? 1e6 : x1);
            y0 = std::min(y0, v < 0 ? -1e6 : y0);
            y1 = std::max(y1, v > 0 ? 1e6 : y1);
          }
        }
    const double slack = 8 + 0.02 * (x1 - x0);  // edges bend with the lens
    for (int j = 0; j < rows; ++j)
      for (int i = 0; i < columns; ++i) {
        const bool inside = i * tile <= x1 + slack && (i + 1) * tile >= x0 - slack &&
                            j * tile <= y1 + slack && (j + 1) * tile >= y0 - slack;
        if (everywhere || inside) bits[static_cast<std::size_t>(j * columns + i)] |= 1u << n;
      }
  }
  return bits;
}

int Nets::cross(std::uint32_t bits, const Eigen::Vector3f& origin, const Eigen::Vector3f& direction,
                float farthest, float pixel, NetHit* hits) const {
  int count = 0;
  for (std::size_t n = 0; n < nets_.size() && count < 4; ++n) {
    if (!((bits >> n) & 1u)) continue;
    const world::Net& net = nets_[n];
    const Eigen::Vector3f eu = net.u / net.u_m, ev = net.v / net.v_m;
    const Eigen::Vector3f normal = eu.cross(ev).normalized();
    const float slope = direction.dot(normal);
    if (std::abs(slope) < 1e-5f) continue;
    const float t = (net.origin - origin).dot(normal) / slope;
    if (!(t > 0.05f && t < farthest)) continue;
    const Eigen::Vector3f p = origin + t * direction - net.origin;
    // Sides need not be square to each other.
    const float skew = eu.dot(ev), pu = p.dot(eu), pv = p.dot(ev);
    const float u = (pu - skew * pv) / (1 - skew * skew), v = (pv - skew * pu) / (1 - skew * skew);
    if (u < 0 || v < 0 || u > net.u_m || v > net.v_m) continue;
    const float oblique = std::max(std::abs(slope), 0.12f);
    const float size = std::max(t * pixel / std::sqrt(oblique), 1e-4f);
    const float cord = std::min(cord_ / std::sqrt(oblique), 0.6f * mesh_);
    const float across = bars_cover(u, mesh_, cord, size), up = bars_cover(v, mesh_, cord, size);
    NetHit hit{t, 1 - (1 - across) * (1 - up), normal};
    int at = count++;
    for (; at > 0 && hits[at - 1].t > hit.t; --at) hits[at] = hits[at - 1];
    hits[at] = hit;
  }
  return count;
}

}  // namespace touchline::sim::render
