// Isolated straight edges and bars of a picture, each as samples across itself.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/image/image.h"

namespace touchline::compensate {

// Luma across one straight piece of an edge: means of the samples that lie within an eighth of a
// pixel of each other, in code values over the distance from the edge (or from the bar's middle).
struct EdgeProfile {
  bool bar = false;   // two opposite edges with level ground outside; else one step
  double cosine = 1;  // of the edge's normal, against the axes; both >= 0
  double sine = 0;
  double width = 0;           // of a bar, at half height, pixels
  double left = 0, top = 0;   // levels: of the side at negative distance, of the bar
  double right = 0;           // of the side at positive distance
  double noise = 0;           // of one sample, rms of the level ground
  double quality = 0;         // what it tells about detail: contrast to noise, sharper is better
  std::vector<float> at;      // distance, pixels
  std::vector<float> value;   // mean
  std::vector<float> number;  // of samples

  double step() const;  // height, code values
};

// Edges of at least `least` code values whose both sides are level over some 10 pixels and which
// stay straight over 11 rows (columns for edges closer to horizontal).
std::vector<EdgeProfile> find_edges(image::ImageView<const std::uint16_t> luma, double least);

}  // namespace touchline::compensate
