// Our camera model fitted to points that somebody clicked on named lines of a picture, from no
// start at all: cameras all round the pitch are tried, the best are refined by the pose fit of
// edge/calibrate with the clicks as its line points.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

// What was clicked on: a line in space as its vertices (straight lines are cut into pieces, so that
// a lens may bend them), or a single point.
struct ClickTarget {
  std::string name;
  std::vector<Eigen::Vector3d> vertices;
};

// The centre line of a marking in pieces of at most `piece_m`.
ClickTarget target_of(const pitch::PitchModel& pitch, const pitch::Marking& marking,
                      double piece_m);
// The axis of a bar.
ClickTarget target_of(const pitch::Bar& bar);

struct Click {
  std::size_t target = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct ClickFitOptions {
  int width = 960;  // of the picture, pixels
  int height = 540;
  double click_px = 1.5;      // standard deviation of a click
  double position_sd_m = 15;  // round the tried position that led to the result
  double roll_sd_deg = 1;     // round level
  double lens_sd = 0;         // of k1's and k2's shift at the picture corner, share of the radius
  double least_focal = 0.9;   // tried, in picture widths
  double most_focal = 7;      // the same
  int refined = 60;           // of the tried positions, the best that are refined
};

// The camera that the clicks agree with best; none for fewer than five clicks or where nothing
// fits.
std::optional<geometry::CameraEstimate> fit_clicks(std::span<const ClickTarget> targets,
                                                   std::span<const Click> clicks,
                                                   const pitch::PitchModel& pitch,
                                                   const ClickFitOptions& options);

// Distance of a pixel from the image of a target, pixels; none where the camera does not see it.
std::optional<double> click_distance(const geometry::CameraEstimate& camera,
                                     const ClickTarget& target, const Eigen::Vector2d& pixel);

// True where some of the target's image lies inside the picture.
bool sees(const geometry::CameraEstimate& camera, const ClickTarget& target);

// JaC of one frame (formats.md) at threshold `px`: a target is found when all its clicks lie within
// px of its image; TP / (TP + FP + FN), where a target clicked but not seen by the camera is FN and
// one seen but not clicked, or farther, is FP. Targets that only `others` were clicked on are left
// out. A frame without a camera has JaC 0.
double jaccard(const std::optional<geometry::CameraEstimate>& camera,
               std::span<const ClickTarget> targets, std::span<const Click> clicks,
               std::span<const Click> others, double px);

}  // namespace touchline::score
