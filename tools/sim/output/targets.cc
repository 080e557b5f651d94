#include "tools/sim/output/targets.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace touchline::sim::output {

namespace {
constexpr double kPerSecond = 25;
}

Targets::Targets(const scene::Scene& scene, const Match& match) {
  const auto add = [&](const std::string& id) {
    if (!id.empty()) places_[id];
  };
  for (const camera::CameraSpec& camera : scene.cameras) {
    if (camera.motion.kind == camera::MotionKind::kFollow) add(camera.motion.target);
  }
  for (const camera::VirtualSpec& camera : scene.virtuals) {
    add(camera.target);
    add(camera.person);
  }
  const auto samples = static_cast<std::size_t>(std::ceil(scene.duration_s() * kPerSecond)) + 2;
  for (auto& [id, places] : places_) {
    places.resize(samples);
    tbb::parallel_for(std::size_t{0}, samples, [&, &who = id, &where = places](std::size_t i) {
      where[i] = match.target(who, static_cast<double>(i) / kPerSecond);
    });
  }
}

Eigen::Vector3d Targets::at(const std::string& id, double time_s) const {
  const auto found = places_.find(id);
  if (found == places_.end()) return Eigen::Vector3d::Zero();
  const std::vector<Eigen::Vector3d>& places = found->second;
  const double position =
      std::clamp(time_s * kPerSecond, 0.0, static_cast<double>(places.size() - 1));
  const std::size_t i = std::min(static_cast<std::size_t>(position), places.size() - 2);
  const double t = position - static_cast<double>(i);
  return (1 - t) * places[i] + t * places[i + 1];
}

}  // namespace touchline::sim::output
