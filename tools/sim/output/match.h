// What a recording is made of: pictures and truth of a match at any time.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/mesh.h"
#include "shared/pitch/pitch_model.h"
#include "tools/sim/render/renderer.h"
#include "tools/sim/scene/scene.h"

namespace touchline::sim::output {

// A row of people.csv and the person's rows of joints.csv.
struct PersonTruth {
  std::string id, team, role;
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  std::vector<std::pair<std::string, Eigen::Vector3d>> joints;
};

// Thread-safe; the same answers whatever was asked before.
class Match {
 public:
  virtual ~Match() = default;

  virtual const pitch::PitchModel& pitch() const = 0;
  // Without people the ground is empty: survey stills.
  virtual render::Picture picture(const render::Exposure& exposure,
                                  const render::RenderOptions& options, bool with_people) const = 0;
  virtual std::vector<PersonTruth> people(double time_s) const = 0;  // the ball last
  virtual geometry::Mesh mesh(double time_s) const = 0;
  // "ball" or the id of a person: ball centre or ground point.
  virtual Eigen::Vector3d target(const std::string& id, double time_s) const = 0;
};

// By tools/sim/people, world and render. `assets`: the folder of bodies and motions.
base::Result<std::unique_ptr<Match>> simulated_match(const scene::Scene& scene,
                                                     const std::filesystem::path& assets);

}  // namespace touchline::sim::output
