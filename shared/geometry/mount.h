// A camera on a pan/tilt head at a fixed place: what stays constant over a match (chapter 4.2).
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "shared/geometry/camera_model.h"
#include "shared/geometry/rigid3.h"

namespace touchline::geometry {

// Distortion at one zoom. Between knots k1 and k2 are interpolated so that the shift at the picture
// corners is linear in log focal; beyond the ends it is held.
struct LensKnot {
  double focal_px = 0;
  double k1 = 0;
  double k2 = 0;
};

struct Mount {
  Eigen::Vector3d position_in_world =
      Eigen::Vector3d::Zero();  // where pan and tilt axes meet, metres
  // Levelling of the head: world_from_head is a rotation about X then Y by these small angles; pan
  // is about the head's own vertical.
  double level_x = 0;  // radians
  double level_y = 0;
  // Entrance pupil ahead of the axes along the optical axis where the focal length is the picture's
  // width in pixels, and what is added to it as log focal length rises by 1.
  double pupil_offset_m = 0;
  double pupil_by_log_focal_m = 0;
  int width = 0;  // picture, pixels
  int height = 0;
  double cx = 0;  // principal point, pixels; constant over zoom
  double cy = 0;
  std::vector<LensKnot> lens;  // by rising focal length; empty = no distortion
  // Of what all frames share and a survey found jointly: (position x, y, z, level_x, level_y, cx,
  // cy, pupil offset and its change, the pitch's length, width and crown on which it stands), then,
  // where the lens was found too, k1 r^2 and k2 r^4 at the picture's corner, r = half its diagonal
  // over the focal length, of each knot. Metres, radians, pixels, shares of the radius. 12 or
  // 12 + 2 * lens.size() rows.
  static constexpr int kShared = 12;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kShared, kShared);
};

// Where a head points. Roll about the optical axis is 0 on a good head and small otherwise.
struct HeadPose {
  double pan = 0;  // radians in the head's frame: atan2(d_x, d_y) of the optical axis
  double tilt = 0;
  double roll = 0;
  double focal_px = 0;
};

// Rotation of a camera with this pan, tilt and roll in its reference frame (Z up): at 0, 0, 0 it
// looks along +Y with +X to its right. Positive roll turns the camera clockwise seen from behind.
Eigen::Quaterniond cam_from_reference(double pan, double tilt, double roll);
// The inverse: pan, tilt, roll of a rotation.
Eigen::Vector3d pan_tilt_roll(const Eigen::Quaterniond& cam_from_reference);

Eigen::Quaterniond world_from_head(const Mount& mount);
LensKnot lens_at(const Mount& mount, double focal_px);
double pupil_offset(const Mount& mount, double focal_px);  // metres
CameraModel camera_model(const Mount& mount, double focal_px);
Rigid3 cam_from_world(const Mount& mount, const HeadPose& pose);

}  // namespace touchline::geometry
