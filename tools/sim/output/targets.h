// Places of followed people over a scene, looked up rather than posed again and again.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tools/sim/camera/motion.h"
#include "tools/sim/output/match.h"
#include "tools/sim/scene/scene.h"

namespace touchline::sim::output {

class Targets {
 public:
  Targets(const scene::Scene& scene, const Match& match);

  // Linear between samples 1/25 s apart, held before 0 and beyond the end.
  Eigen::Vector3d at(const std::string& id, double time_s) const;
  camera::TargetAt function() const {
    return [this](const std::string& id, double time_s) { return at(id, time_s); };
  }

 private:
  std::map<std::string, std::vector<Eigen::Vector3d>> places_;
};

}  // namespace touchline::sim::output
