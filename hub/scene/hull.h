// The conservative visual hull of one instant, by group of people, and people that only one camera
// sees.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>
#include <vector>

#include "shared/base/ids.h"
#include "shared/geometry/mesh.h"
#include "shared/image/image.h"

namespace touchline::scene {

// How the renderer shows a group; each later one is a step down.
enum class Rendition : std::uint8_t { kRefined, kHull, kBillboard, kAbsent };
std::string_view name(Rendition rendition);

// One connected component of the hull: a person, several in contact, or the ball.
struct HullGroup {
  std::uint32_t id = 0;        // unique within the instant
  geometry::Mesh surface;      // closed, world metres
  Eigen::AlignedBox3d bounds;  // of the surface
  double volume_m3 = 0;
  std::vector<base::CameraId>
      support;           // cameras that saw it with foreground and took part in carving it
  bool phantom = false;  // explained away: every silhouette it covers belongs to other groups too
};

// A silhouette that only one camera sees: shown as an upright card on the turf, facing that camera.
struct Billboard {
  std::uint32_t id = 0;
  base::CameraId camera;
  image::Rect region;             // of the silhouette in that camera's frame
  Eigen::Vector3d foot_in_world;  // where it stands
  double height_m = 0;
};

struct Hull {
  double voxel_m = 0.02;
  double dilation_px = 3;
  std::vector<HullGroup> groups;  // ordered by centre x, then y
  std::vector<Billboard> billboards;
};

}  // namespace touchline::scene
