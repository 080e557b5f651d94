#include <algorithm>
#include <array>
#include <cstdint>

#include "tools/sim/render/lens_internal.h"

namespace touchline::sim::render {

LensTable::LensTable(const geometry::CameraModel& model) {
  double most = 0;
  for (const double x : {-1.0, static_cast<double>(model.width)})
    for (const double y : {-1.0, static_cast<double>(model.height)}) {
      const double u = (x - model.cx) / model.fx, v = (y - model.cy) / model.fy;
      most = std::max(most, u * u + v * v);
    }
  per_unit_ = static_cast<float>((kEntries - 2) / std::max(most, 1e-12));
  geometry::CameraModel plain = model;
  plain.fx = plain.fy = 1;
  plain.cx = plain.cy = 0;
  factors_.resize(kEntries + 1);
  for (int i = 0; i <= kEntries; ++i) {
    const double r = std::sqrt(i / static_cast<double>(per_unit_));
    factors_[static_cast<std::size_t>(i)] =
        r > 0 ? static_cast<float>(plain.unproject({r, 0}).x() / r) : 1.0f;
  }
}

std::vector<SamplePoint> sample_points(int count) {
  if (count <= 1) return {SamplePoint{}};
  // i/n, the radical inverse in base two, and the second dimension of Sobol's sequence.
  constexpr std::array<std::uint32_t, 6> kSobol = {0x80000000u, 0xc0000000u, 0xa0000000u,
                                                   0xf0000000u, 0x88000000u, 0xcc000000u};
  std::vector<SamplePoint> points;
  const float step = 1.0f / static_cast<float>(count);
  for (int i = 0; i < count; ++i) {
    std::uint32_t inverse = 0, sobol = 0;
    for (std::uint32_t bit = 0; bit < 6; ++bit)
      if ((static_cast<std::uint32_t>(i) >> bit) & 1u) {
        inverse |= 0x80000000u >> bit;
        sobol ^= kSobol[bit];
      }
    const auto fraction = [&](std::uint32_t bits) {
      return static_cast<float>(bits >> 8) * 0x1p-24f + 0.5f * step;
    };
    points.push_back(
        {(static_cast<float>(i) + 0.5f) * step - 0.5f, fraction(inverse) - 0.5f, fraction(sobol)});
  }
  return points;
}

geometry::CameraModel model_at(const Exposure& exposure, double time) {
  const geometry::CameraModel &a = exposure.open.model, &b = exposure.close.model;
  geometry::CameraModel m = a;
  m.fx = std::lerp(a.fx, b.fx, time);
  m.fy = std::lerp(a.fy, b.fy, time);
  m.cx = std::lerp(a.cx, b.cx, time);
  m.cy = std::lerp(a.cy, b.cy, time);
  m.k1 = std::lerp(a.k1, b.k1, time);
  m.k2 = std::lerp(a.k2, b.k2, time);
  return m;
}

geometry::Rigid3 pose_at(const Exposure& exposure, double time) {
  const geometry::Rigid3 &a = exposure.open.cam_from_world, &b = exposure.close.cam_from_world;
  geometry::Rigid3 pose;
  pose.rotation = a.rotation.slerp(time, b.rotation).normalized();
  const Eigen::Vector3d position = (1 - time) * geometry::origin(a) + time * geometry::origin(b);
  pose.translation = -(pose.rotation * position);
  return pose;
}

bool moves(const Exposure& exposure) {
  const geometry::Rigid3 &a = exposure.open.cam_from_world, &b = exposure.close.cam_from_world;
  return !(exposure.open.model == exposure.close.model) ||
         a.rotation.coeffs() != b.rotation.coeffs() || a.translation != b.translation;
}

}  // namespace touchline::sim::render
