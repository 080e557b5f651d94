// Where a camera of known position may point, by the straight lines of a picture: the proposals
// that the initialiser refines. A line of the picture taken for a line of the pitch leaves the
// field of view open, for pan and tilt follow in closed form; a crossing of two lines taken for a
// crossing on the pitch does so as well, and says more surely where along the lines it is.
#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <vector>

#include "edge/calibrate/initialise/hough_initialiser.h"
#include "edge/calibrate/initialise/pose_score_internal.h"

namespace touchline::calibrate {

constexpr double kProposalSpacing = 2.5;  // metres, of samples that proposals are scored by

struct PoseProposal {
  double pan = 0, tilt = 0, focal = 0;
  double score = 0;
};

class PoseProposer {
 public:
  PoseProposer(const pitch::PitchModel& pitch, const geometry::Mount& mount,
               const InitialiseOptions& options);

  // By falling score, one a place; `tried` counts the poses that were scored.
  std::vector<PoseProposal> propose(const LineMap& map, int& tried) const;

  Pose pose(double pan, double tilt, double focal) const;

 private:
  // A straight marking, or a tangent of an arc over the part where the arc is nearly straight.
  struct ModelLine {
    Eigen::Vector3d normal_in_head;  // unit, of the plane through the camera and the line
    Eigen::Vector3d start, end;      // in the head's frame, from the camera's position
  };
  // Where a marking along the pitch meets one across it.
  struct ModelCrossing {
    Eigen::Vector3d point;              // in the head's frame, from the camera's position
    std::array<Eigen::Vector3d, 2> of;  // directions of the two there, on the turf
  };
  // Where two lines of the picture meet.
  struct PictureCrossing {
    Eigen::Vector2d pixel;
    std::array<const LineHypothesis*, 2> of;
  };
  // The best proposal of each place: pan, tilt and log focal in cells.
  using PlaceKey = std::array<int, 3>;
  using Places = std::map<PlaceKey, PoseProposal>;

  static bool within_span(const Eigen::Vector3d& direction, const ModelLine& line, double slack);
  void add_lines(const pitch::PitchModel& pitch);
  void add_crossings(const pitch::PitchModel& pitch);
  void propose_line(const LineMap& map, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                    double focal, double tolerance, Places& places, int& tried) const;
  void propose_crossing(const LineMap& map, const PictureCrossing& crossing, double focal,
                        double tolerance, Places& places, int& tried) const;
  void try_pose(const LineMap& map, double pan, double tilt, double focal, double tolerance,
                Places& places, int& tried) const;

  geometry::Mount mount_;
  InitialiseOptions options_;
  Eigen::Matrix3d head_from_world_;
  MarkingSamples sparse_;
  std::vector<ModelLine> lines_;
  std::vector<ModelCrossing> crossings_;
};

}  // namespace touchline::calibrate
