// How well a camera fits the ridge points of a picture, and the local refinement of such a camera.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "edge/calibrate/lines/line_map.h"
#include "shared/geometry/camera_model.h"
#include "shared/geometry/mount.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// A camera while it is searched for.
struct Pose {
  geometry::CameraModel model;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // cam_from_world
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // in world
};

// Points along the centre lines of all markings but spots, as arrays of their coordinates.
struct MarkingSamples {
  struct Sample {
    Eigen::Vector3f point;    // in world, on the turf
    Eigen::Vector3f tangent;  // unit, along the marking
    float step = 0;           // metres of marking that it stands for
    float width = 0;          // painted, metres
    int marking = 0;          // index into the pitch's markings
  };
  std::vector<Sample> samples;
  std::vector<bool> dashed;  // one a marking of the pitch
  std::vector<pitch::Bar> bars;
};
// Sine between a ridge and a marking that still agree.
constexpr float kLeastAlong = 0.30F;

MarkingSamples sample_markings(const pitch::PitchModel& pitch, double spacing_m);

struct PoseScore {
  double confirmed = 0;  // share of the predicted line length that has a ridge on it
  double explained = 0;  // share of the ridge points on the pitch that have a marking on them
  double seen_m = 0;     // metres of marking confirmed
  double rms_px = 0;     // of confirmed samples, across the line
  int directions = 0;    // 2 where lines of clearly different image direction or arcs are confirmed
  double missing_px = 0;      // of the predicted lines: not seen where they should be, pixels
  double unexplained_px = 0;  // of the ridges in the picture, pixels; score_exact alone
  // What speaks against the pose. Clutter and people add the same to every pose of a picture.
  double against_px() const { return missing_px + unexplained_px; }
  double score() const {
    const double sum = confirmed + explained;
    return sum > 0 ? 2 * confirmed * explained / sum : 0;
  }
};

// Without `explained`.
PoseScore score_markings(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                         double tolerance_px);

// Fast: `explained` is the matched length over the number of ridge points. Samples at
// `tolerance_px` count nothing.
PoseScore score_fast(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                     double tolerance_px);

// Exact: every ridge point (or evenly chosen ones, at most `most_points`) is cast on the turf and
// compared with its nearest marking. Points on goals, on bars that are seen and on what is far
// wider than paint do not count, points off the pitch less.
PoseScore score_exact(const LineMap& map, const MarkingSamples& samples,
                      const pitch::PitchModel& pitch, const Pose& pose, double tolerance_px,
                      int most_points);

// A bar of a goal that is seen before the turf: its ends in the picture.
struct SeenBar {
  Eigen::Vector2f start, along;  // along: to the other end
  // Through `p`, in the direction of a line with that normal.
  bool passes(const Eigen::Vector2f& p, const Eigen::Vector2f& line_normal, float tolerance) const;
};
// The bars that the pose puts on ridges over most of their length before the turf. Only they
// account for ridges: a pose must not hide a line behind a post that is not there.
std::vector<SeenBar> seen_bars(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                               double tolerance_px);

// Whole lines that speak against a pose: markings that should be seen over a good part of the
// picture and are not, and straight lines of the picture that lie on no marking and no bar. Paint
// may be worn or hidden, and a pitch may carry other lines; both at once are a pose slipped from
// line to line.
struct LineConflict {
  int missing = 0;
  int unnamed = 0;
  bool any() const { return missing > 0 && unnamed > 0; }
};
LineConflict line_conflict(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                           double tolerance_px);

// A ridge point on a marking.
struct PointOnMarking {
  int marking = -1;
  double distance = 0;  // along the marking, metres
  double across_px = 0;
};
// The marking that a ridge point shows under a camera; marking -1 where none runs in its direction
// within `tolerance_px`.
PointOnMarking match_point(const pitch::PitchModel& pitch, const Pose& pose,
                           const RidgePoint& point, double tolerance_px);

struct RefineOptions {
  bool position = false;                   // also find the position
  bool lens = false;                       // also find k1
  const geometry::Mount* mount = nullptr;  // lens over zoom and levelling, where known
  double roll_sigma = 0.002;               // radians, of roll in the head's frame
  double shift_sigma = 0.01;  // of k1's shift at the picture corner, share of the radius
  std::span<const double> tolerances_px;  // one iteration each
};
// Rotation about the camera's axes (3), position (3), log focal, shift of k1 at the corner.
using PoseInformation = Eigen::Matrix<double, 8, 8>;
// Gauss-Newton on the distance from marking samples to the nearest ridges. False when it breaks
// down.
bool refine(const LineMap& map, const MarkingSamples& samples, const RefineOptions& options,
            Pose& pose, PoseInformation* information = nullptr);

// How surely the lines hold the picture in place: the largest standard deviation, over the
// picture's corners, of where a ray comes to lie, by the information of a refinement, when the
// position is known. Lines that err together over some length are allowed for. Pixels; large where
// the lines leave something free.
double picture_sigma(const PoseInformation& information, const Pose& pose);

// Largest displacement of picture points between two cameras' rotations and focal lengths, pixels.
double picture_distance(const Pose& a, const Pose& b);

// Measured over predicted width of the painted lines that the pose puts on ridges: paint is 0.12 m
// wide, and so tells the scale where nothing else does. Median; 0 where too little is wide enough.
double width_ratio(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                   double tolerance_px);
// False where the widths speak against the pose: lines are painted 0.08 to 0.15 m wide.
bool widths_agree(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                  double tolerance_px);

// Root mean square distance in the picture of `a`, over a grid of its pixels on the turf, between
// the places where `a` and `b` see the same turf; pixels.
double turf_distance(const pitch::PitchModel& pitch, const Pose& a, const Pose& b);

}  // namespace touchline::calibrate
