// How the markings of a pitch move with its length, width and crown: what an error of a size does
// to a line in the picture.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

class PitchVariation {
 public:
  explicit PitchVariation(const pitch::PitchModel& pitch);

  // Change of a point of a marking, metres a metre: columns length, width, crown. `share` is where
  // on the marking it is, of its length. Zero for a size that cannot be larger.
  Eigen::Matrix3d by_size(pitch::MarkingId marking, double share,
                          const Eigen::Vector3d& point_in_world) const;

 private:
  std::array<std::optional<pitch::PitchModel>, 3> larger_;  // by a step in length, width, crown
};

}  // namespace touchline::calibrate
