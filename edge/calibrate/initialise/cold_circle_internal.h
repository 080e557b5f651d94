// Cameras for a picture in which a circle, or an arc of one, and a straight line beside its centre
// are all there is: the centre circle and the halfway line, or a penalty arc and the front of its
// box. For each horizon and focal length the turf is rectified, and a circle is looked for whose
// centre lies where the line says. Its size tells the height of the camera, its place the position.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

namespace touchline::calibrate {

struct CircleSearch {
  double least_focal = 0;
  double most_focal = 0;  // pixels
  double radius_m = 9.09;
  double tolerance_px = 4;
  // Of the circle's centre from the line, in radii: positive to the right of the line, looking
  // along it away from the camera.
  double offset = 0;
  int least_sectors = 4;     // eighths of the circle that must hold points; 1..8
  double least_share = 0.3;  // of the points off the line, that lie on the circle
  bool any_horizon = false;  // a camera near the turf as well: from close above the points, up
};

struct CircleProposal {
  double focal = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // cam_from_world
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // from the circle's centre
  double share = 0;                                        // of the points that lie on the circle
  // The line runs along +Y, away from the camera; or along -Y: then the centre lies at the offset
  // towards -X.
  bool turned = false;
};

// `line` is a x + b y + c = 0 with (a, b) unit and `points` are on lines, both in pixels from
// the picture's middle. Proposals for both directions along the line, in the order of the grid.
std::vector<CircleProposal> circle_proposals(const Eigen::Vector3d& line,
                                             std::span<const Eigen::Vector2d> points,
                                             const CircleSearch& search);

}  // namespace touchline::calibrate
