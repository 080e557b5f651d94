#include "edge/calibrate/track/pitch_variation.h"

#include <utility>

namespace touchline::calibrate {
namespace {

constexpr double kStep = 0.05;  // metres

}  // namespace

PitchVariation::PitchVariation(const pitch::PitchModel& pitch) {
  for (std::size_t size = 0; size < larger_.size(); ++size) {
    pitch::PitchSizes sizes{pitch.length_m, pitch.width_m, std::nullopt, pitch.crown_m,
                            pitch.line_m};
    if (pitch.sport == pitch::Sport::kRugbyUnion) sizes.in_goal_m = pitch.in_goal_m;
    (size == 0 ? *sizes.length_m : size == 1 ? *sizes.width_m : *sizes.crown_m) += kStep;
    if (auto larger = pitch::make_pitch(pitch.sport, sizes)) larger_[size] = std::move(*larger);
  }
}

Eigen::Matrix3d PitchVariation::by_size(pitch::MarkingId marking, double share,
                                        const Eigen::Vector3d& point_in_world) const {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  for (int size = 0; size < 3; ++size) {
    const auto& larger = larger_[static_cast<std::size_t>(size)];
    const pitch::Marking* moved = larger ? larger->find(marking) : nullptr;
    if (moved == nullptr) continue;
    out.col(size) = (larger->on_turf(moved->at(share * moved->length())) - point_in_world) / kStep;
  }
  return out;
}

}  // namespace touchline::calibrate
