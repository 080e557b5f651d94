// What one camera can say about geometry: its silhouettes as polygons on bounded viewing cones, and
// point features.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace touchline::geometry {

// One connected silhouette or a hole in one. Vertices are pixels of the frame as the video has it
// (distorted); the ring is closed from the last vertex to the first, counter-clockwise seen with y
// down for outlines, the other way for holes.
struct SilhouettePolygon {
  std::vector<Eigen::Vector2f> ring;
  bool hole = false;
  // Depth along the optical axis between which the cone can be occupied (it ends at the turf and at
  // the tallest person's height), metres; 0, 0 = unknown.
  float near_m = 0;
  float far_m = 0;
};

// A foreground feature for sparse matching between cameras.
struct Feature {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  // pixels
  float scale = 0;                                     // pixels
  float angle = 0;                                     // radians
  std::vector<std::uint8_t> descriptor;
};

struct Partial {
  std::vector<SilhouettePolygon> polygons;
  std::vector<Feature> features;  // at most 200
  // Largest distance between a polygon and the matte's 0.5 boundary it stands for, pixels.
  float tolerance_px = 0;
};

}  // namespace touchline::geometry
