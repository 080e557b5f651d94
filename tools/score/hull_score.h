// How well a hull holds the true surfaces (formats.md).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mesh.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct PersonInside {
  std::string person;
  double share = 0;  // of their vertices seen by two cameras or more, inside or within reach
  std::size_t vertices = 0;
};

struct HullScore {
  std::int64_t frame = 0;
  std::vector<PersonInside> people;  // those with at least 100 such vertices; the ball with any
  double all_share = 0;              // over all vertices that two cameras or more see
  std::size_t vertices = 0;          // their number
  std::size_t components = 0;        // connected, hollows inside them apart
  std::size_t phantoms = 0;          // components with no true vertex inside or within reach
  double volume_m3 = 0;

  double least_share() const;
  double mean_share() const;
};

// `hull` is one closed mesh or several in one; `cameras` the true cameras of the frame. `reach_m`
// is a voxel's size, at most 0.1.
HullScore score_hull(const geometry::Mesh& hull, const geometry::Mesh& truth,
                     const std::vector<TruePerson>& people,
                     std::span<const geometry::CameraEstimate> cameras, double reach_m);

double volume_m3(const geometry::Mesh& mesh);  // of a closed mesh

// The connected parts of a mesh, in order of their first triangle.
std::vector<geometry::Mesh> split_components(const geometry::Mesh& mesh);

}  // namespace touchline::score
