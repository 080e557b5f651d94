#include <algorithm>
#include <cmath>

#include "edge/calibrate/initialise/pitch_pencil_internal.h"

namespace touchline::calibrate {

std::vector<PencilLine> pencil(const pitch::PitchModel& pitch, int axis) {
  std::vector<PencilLine> lines;
  const int other = 1 - axis;
  for (const pitch::Marking& marking : pitch.markings) {
    if (marking.shape != pitch::MarkingShape::kLine) continue;
    if (std::abs(marking.start[other] - marking.end[other]) > 0.01) continue;
    const double at = marking.start[other];
    auto line = std::find_if(lines.begin(), lines.end(), [&](const PencilLine& candidate) {
      return std::abs(candidate.at - at) < 0.05;
    });
    if (line == lines.end()) {
      lines.push_back({});
      line = lines.end() - 1;
      line->at = at;
      line->z = axis == 0 ? pitch.turf_z(at) : -pitch.crown_m / 3;
    }
    line->spans.push_back({std::min(marking.start[axis], marking.end[axis]),
                           std::max(marking.start[axis], marking.end[axis])});
  }
  return lines;
}

}  // namespace touchline::calibrate
