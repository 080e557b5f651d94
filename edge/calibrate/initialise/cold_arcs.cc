#include <algorithm>
#include <cmath>

#include "edge/calibrate/initialise/cold_arcs_internal.h"
#include "edge/calibrate/initialise/pitch_pencil_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kLeastArcRadius = 3;  // metres: a corner's is too small to tell
constexpr double kSameOffset = 0.05;   // radii: arcs beside lines that are looked for as one

}  // namespace

std::vector<ArcBeside> arcs_beside_lines(const pitch::PitchModel& pitch) {
  std::vector<ArcBeside> arcs;
  for (const pitch::Marking& arc : pitch.markings) {
    if (arc.shape != pitch::MarkingShape::kArc || arc.radius < kLeastArcRadius) continue;
    const Eigen::Vector3d centre(arc.centre.x(), arc.centre.y(), pitch.turf_z(arc.centre.y()));
    for (const PencilLine& line : pencil(pitch, 1)) {
      const double offset = (arc.centre.x() - line.at) / arc.radius;
      if (std::abs(offset) > 1) continue;
      const auto same = [&](double other) {
        const auto found = std::find_if(arcs.begin(), arcs.end(), [&](const ArcBeside& a) {
          return std::abs(a.radius - arc.radius) < 0.01 && std::abs(a.offset - other) < kSameOffset;
        });
        if (found != arcs.end()) return found;
        arcs.push_back({arc.radius, other, {}, {}});
        return arcs.end() - 1;
      };
      same(offset)->centres.push_back(centre);
      same(-offset)->turned.push_back(centre);
    }
  }
  return arcs;
}

}  // namespace touchline::calibrate
