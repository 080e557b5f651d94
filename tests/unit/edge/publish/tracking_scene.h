// A camera with every number different from 0, for tests of what is said of it.
#pragma once

#include "shared/codec/camera_view.h"
#include "shared/geometry/mount.h"

namespace touchline::publish {

inline geometry::CameraEstimate estimate_at(double pan, double tilt, double roll,
                                            const Eigen::Vector3d& position) {
  geometry::CameraEstimate out;
  out.model = {1920, 1080, 3000, 3000, 963, 538, -0.12, 0.03};
  out.cam_from_world.rotation = geometry::cam_from_reference(pan, tilt, roll);
  out.cam_from_world.translation = -(out.cam_from_world.rotation * position);
  out.evidence = geometry::Evidence::kLines;
  out.rms_px = 0.25;
  return out;
}

inline codec::EncodedView view_at(double pan, double tilt, double roll,
                                  const Eigen::Vector3d& position) {
  codec::EncodedView out;
  out.id = {{"m1"}, 3, 66'000};
  out.stamp.media_time.ns = 1'718'806'554'500'000'000;
  out.stamp.domain = base::ClockDomain::kPtp;
  out.stamp.timecode = base::Timecode{10, 0, 1, 16, false};
  out.estimate = estimate_at(pan, tilt, roll, position);
  return out;
}

}  // namespace touchline::publish
