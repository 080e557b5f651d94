// Cameras for a picture of the middle of the pitch, where the circle and the halfway line are all
// there is: for each horizon and focal length the turf is rectified, and a circle is looked for
// whose centre lies on the line. Its size tells the height of the camera, its place the position.
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
};

struct CircleProposal {
  double focal = 0;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  // cam_from_world
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // above the middle's turf at z = 0
  double share = 0;                                        // of the points that lie on the circle
};

// `halfway` is a x + b y + c = 0 with (a, b) unit and `points` are on lines, both in pixels from
// the picture's middle. Proposals for both directions along the halfway line, in the order of the
// grid.
std::vector<CircleProposal> circle_proposals(const Eigen::Vector3d& halfway,
                                             std::span<const Eigen::Vector2d> points,
                                             const CircleSearch& search);

}  // namespace touchline::calibrate
