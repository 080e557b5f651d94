// The pitch: its sizes, every marking by name, goal frames and the crown. World frame: origin at
// the centre spot, X along the length, Y across, Z up, metres; the main camera side is y < 0. Sizes
// and lines as formats.md has them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "shared/base/result.h"

namespace touchline::pitch {

enum class Sport : std::uint8_t { kSoccer, kRugbyUnion };

// Measured sizes in metres; absent = the sport's default (and to be found by the survey where that
// is possible).
struct PitchSizes {
  std::optional<double> length_m;
  std::optional<double> width_m;
  std::optional<double> in_goal_m;  // rugby
  std::optional<double> crown_m;
  std::optional<double> line_m;
};

// "near" is y < 0, "left" x < 0. The same names serve both sports where they mean the same.
enum class MarkingId : std::uint8_t {
  kNearTouchline,
  kFarTouchline,
  kLeftGoalLine,
  kRightGoalLine,
  kHalfwayLine,
  kCentreCircle,
  kCentreSpot,
  // soccer
  kLeftPenaltyFront,
  kLeftPenaltyNear,
  kLeftPenaltyFar,
  kLeftGoalAreaFront,
  kLeftGoalAreaNear,
  kLeftGoalAreaFar,
  kLeftPenaltySpot,
  kLeftPenaltyArc,
  kRightPenaltyFront,
  kRightPenaltyNear,
  kRightPenaltyFar,
  kRightGoalAreaFront,
  kRightGoalAreaNear,
  kRightGoalAreaFar,
  kRightPenaltySpot,
  kRightPenaltyArc,
  kLeftNearCorner,
  kLeftFarCorner,
  kRightNearCorner,
  kRightFarCorner,
  // rugby; the goal lines are the try lines
  kLeftDeadBall,
  kRightDeadBall,
  kLeft22,
  kRight22,
  kLeft10,
  kRight10,
  kNear5,
  kFar5,
  kNear15,
  kFar15,
  kLeft5,
  kRight5,
};

std::string_view name(MarkingId id);

enum class MarkingShape : std::uint8_t { kLine, kArc, kSpot };

// The centre line of a painted marking. Lines run from `start` to `end`; arcs round `centre` from
// `start_angle` to `end_angle` (radians from +X towards +Y, start < end; a full circle spans 2 pi);
// spots are discs round `centre`.
struct Marking {
  MarkingId id{};
  MarkingShape shape = MarkingShape::kLine;
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0;  // arcs: of the centre line; spots: of the disc
  double start_angle = 0;
  double end_angle = 0;
  double width = 0.12;  // painted, metres
  bool dashed = false;

  double length() const;                           // along the centre line, metres
  Eigen::Vector2d at(double distance) const;       // point of the centre line, 0..length()
  Eigen::Vector2d tangent(double distance) const;  // unit
};

// A straight round bar: goal posts, cross bar, net stanchions, H posts, corner flag poles.
struct Bar {
  Eigen::Vector3d start;
  Eigen::Vector3d end;
  double diameter = 0.12;
};

// A flat quadrilateral of net.
struct NetPanel {
  std::array<Eigen::Vector3d, 4> corners;
};

struct PitchModel {
  Sport sport = Sport::kSoccer;
  double length_m = 105;  // outer edge to outer edge (rugby: between the centres of the try lines)
  double width_m = 68;
  double in_goal_m = 0;
  double crown_m = 0;
  double line_m = 0.12;
  std::vector<Marking> markings;
  std::vector<Bar> bars;        // goal frames first
  std::vector<NetPanel> nets;   // where a goal's net may hang; an estimate
  double goal_width_m = 7.32;   // between posts
  double goal_height_m = 2.44;  // under the bar

  // Height of the turf: -crown (y / half width)^2 inside the touchlines, -crown beyond.
  double turf_z(double y) const;
  Eigen::Vector3d on_turf(const Eigen::Vector2d& p) const { return {p.x(), p.y(), turf_z(p.y())}; }
  const Marking* find(MarkingId id) const;
};

// The model for a sport with the sizes given; names the size that is out of its bounds.
base::Result<PitchModel> make_pitch(Sport sport, const PitchSizes& sizes);

// What may be wrapped round the feet of rugby's goal posts, over the posts themselves: none in
// soccer. World Rugby, Law 1: padding reaches at most 0.3 m from the goal line.
std::vector<Bar> post_pads(const PitchModel& pitch);

// First hit of a ray with the turf (crown included), within 1000 m; none above the horizon.
std::optional<Eigen::Vector3d> intersect_turf(const PitchModel& pitch,
                                              const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction);

}  // namespace touchline::pitch
