// True and found surfaces, projected into a camera.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mesh.h"
#include "tools/draw/canvas.h"

namespace touchline::score::page {

// 255 where a mesh covers the window of a camera's picture, `zoom` times as large.
draw::Mask silhouette(const geometry::Mesh& mesh, const geometry::CameraEstimate& camera,
                      const image::Rect& window, int zoom);

// What is wrong with a hull, as its score counts it.
struct HullFaults {
  std::vector<Eigen::Vector3f> outside;  // true vertices that the hull does not hold
  std::vector<geometry::Mesh> phantoms;  // parts that hold no true vertex
};
HullFaults find_faults(const geometry::Mesh& hull, const geometry::Mesh& truth, double reach_m);

// The frame in a window with the true outline, the hull's, red dots at true vertices outside the
// hull, and phantoms tinted.
draw::Picture hull_map(const draw::Picture& frame, const geometry::CameraEstimate& camera,
                       const geometry::Mesh& truth, const geometry::Mesh& hull,
                       const HullFaults& faults, const image::Rect& window, int zoom);

// Round the pixels of some points, `margin` times their extent wider; empty when the camera sees
// fewer than half of them.
image::Rect window_round(const geometry::CameraEstimate& camera,
                         const std::vector<Eigen::Vector3f>& points, double margin = 0.3);

// Round the foreground of a mask.
image::Rect window_round_mask(const draw::Mask& mask, int room = 16);

}  // namespace touchline::score::page
