// What a picture says about white lines on turf, without any knowledge of the camera: where the
// turf is, points on the centres of white ridges, straight line hypotheses from a Hough transform
// of those points (chapter 4.2, figure 4), and a map of the nearest ridge point for fast scoring of
// poses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/base/result.h"
#include "shared/image/frame.h"

namespace touchline::calibrate {

struct LineMapOptions {
  double turf_hue_deg = 24;      // half width of the accepted chroma angle round the turf's own
  double turf_saturation = 0.3;  // least chroma magnitude, share of the turf's own
  double least_contrast = 20;    // of a ridge over both its sides, 10-bit code values
  double noise_factor = 4.5;     // a ridge also stands this many sigma of the turf's texture out
  int least_chain_px = 14;       // shortest run of linked ridge points, at 1080 lines
  double line_tolerance_px = 3;  // points this near belong to a straight line hypothesis
  int least_line_points = 24;    // weakest line hypothesis
  int most_lines = 24;           // strongest hypotheses that are kept
  double reach_px = 24;          // of the nearest-point map, at 1080 lines

  base::Status validate() const;
};

// A point on the centre of a white ridge.
struct RidgePoint {
  Eigen::Vector2f position = Eigen::Vector2f::Zero();  // pixels, to a fraction of one
  Eigen::Vector2f normal = Eigen::Vector2f::Zero();    // unit, across the line
  float contrast = 0;                                  // code values over its sides
  float width = 0;                                     // of the ridge across the line, pixels
  int chain = -1;                                      // points of one chain were linked
};

// A straight line: normal . p = offset for its points p, fitted to ridge points between start and
// end. Where the chapter splits its Hough space into halves of the picture, each hypothesis here
// keeps its own span.
struct LineHypothesis {
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  // unit
  double offset = 0;                                 // pixels
  Eigen::Vector2d start = Eigen::Vector2d::Zero();
  Eigen::Vector2d end = Eigen::Vector2d::Zero();
  int points = 0;
  double rms_px = 0;  // of its points across it
};

struct LineMap {
  int width = 0;  // of the picture, pixels
  int height = 0;
  static constexpr int kTurfStep = 8;  // pixels of the picture a cell of the turf mask
  static constexpr int kMapStep = 4;   // pixels of the picture a cell of the nearest-point map
  image::Image<std::uint8_t> turf;     // 1 = turf, with what stands on it filled in
  double turf_share = 0;               // of the picture
  // Contrast of a line of full width there over the least that is found, a cell of the turf mask;
  // by how the picture's strongest lines stand out of their turf. Empty: not known.
  image::Image<float> strength;
  std::vector<RidgePoint> points;
  std::vector<LineHypothesis> lines;   // by falling number of points
  image::Image<std::int32_t> nearest;  // index of the nearest ridge point, -1 beyond reach
  double reach_px = 0;

  // Index of the ridge point nearest to a pixel (to about half a map cell); -1 when none is in
  // reach or the pixel is outside the picture.
  int nearest_to(const Eigen::Vector2d& pixel) const {
    if (!inside(pixel)) return -1;
    return nearest(static_cast<int>((pixel.x() + 0.5) * (1.0 / kMapStep)),
                   static_cast<int>((pixel.y() + 0.5) * (1.0 / kMapStep)));
  }
  // True when the pixel lies in the picture and on turf.
  bool on_turf(const Eigen::Vector2d& pixel) const {
    return inside(pixel) && turf(static_cast<int>((pixel.x() + 0.5) * (1.0 / kTurfStep)),
                                 static_cast<int>((pixel.y() + 0.5) * (1.0 / kTurfStep))) != 0;
  }
  // What `strength` says at a pixel in the picture; large where it is not known.
  float strength_at(float x, float y) const {
    if (strength.width() == 0) return 100;
    return strength(static_cast<int>((x + 0.5F) * (1.0F / kTurfStep)),
                    static_cast<int>((y + 0.5F) * (1.0F / kTurfStep)));
  }
  bool inside(const Eigen::Vector2d& pixel) const {  // false for what is not a number
    return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < width - 0.5 &&
           pixel.y() < height - 0.5;
  }
};

// Pure; an empty map (no points, turf_share 0) where there is no turf. Options must be valid.
LineMap detect_lines(const image::Frame& frame, const LineMapOptions& options);

// One map of what stands still in the pictures of a camera that does not move: ridge points that
// at least two fifths of them show. Rain, people and the ball go. At least one map, all of one
// size.
LineMap merge_still(std::vector<LineMap> maps, const LineMapOptions& options);

}  // namespace touchline::calibrate
