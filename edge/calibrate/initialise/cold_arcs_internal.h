// Arcs of the pitch with the lines beside their centres, as a search from nothing needs them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// Arcs, and a line across the pitch as far from their centres.
struct ArcBeside {
  double radius = 0;
  double offset = 0;                     // of the centre from the line towards +X, in radii
  std::vector<Eigen::Vector3d> centres;  // where the centre lies so
  std::vector<Eigen::Vector3d> turned;   // where it lies so on a pitch turned by 180 degrees
};

// All arcs but those of the corners, with the lines across the pitch that come near their centres.
std::vector<ArcBeside> arcs_beside_lines(const pitch::PitchModel& pitch);

}  // namespace touchline::calibrate
