// People who stand on the turf of a picture of which no camera is known.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "edge/calibrate/lines/line_map.h"

namespace touchline::calibrate {

// What is not turf and stands on it, taller than wide. Pixels.
struct Figure {
  Eigen::Vector2d foot = Eigen::Vector2d::Zero();  // middle of its lowest part
  std::optional<double> height;                    // none where the picture cuts it off above
};

struct Figures {
  std::vector<Figure> standing;
  // Share of the picture's cells (`cell` pixels) that are turf or stand in it, and those that are
  // something else than turf: somebody may be there.
  image::Image<std::uint8_t> covered;
  int cell = 4;
  int width = 0;
  int height = 0;

  // Whether someone whose foot and head lie at these pixels would be seen, and is not there.
  bool empty_at(const Eigen::Vector2d& foot, double height_px) const;

 private:
  friend Figures find_figures(const image::Frame& frame, const LineMapOptions& options);
  image::Image<std::uint8_t> turf_;
};

// Pure. Nothing stands in a picture without turf.
Figures find_figures(const image::Frame& frame, const LineMapOptions& options);

}  // namespace touchline::calibrate
