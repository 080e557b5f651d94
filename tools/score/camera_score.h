// How well cameras were found: distances between true and estimated pictures of turf and markings,
// angles, positions, and whether the stated uncertainty is true (formats.md).
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

// Over a 1 m grid of turf points of the pitch and 4 m round it that the true camera sees, the root
// mean square distance between their true and estimated pixels; none when it sees no such point. A
// point that the estimate cannot project, or farther off, counts as a picture's width.
std::optional<double> grid_rms_px(const geometry::CameraEstimate& truth,
                                  const geometry::CameraEstimate& estimate,
                                  const pitch::PitchModel& pitch);

// Markings as true or false positives and false negatives at a distance.
struct MarkingCount {
  int right = 0;   // seen by both cameras, every visible true point within the distance
  int wrong = 0;   // seen by both, some point farther off; or by the estimate alone
  int missed = 0;  // seen by the true camera alone

  int all() const { return right + wrong + missed; }
  // TP / (TP + FP + FN); none when no camera sees a marking.
  std::optional<double> jaccard() const;
};

inline constexpr std::array<double, 3> kJaccardPx = {5, 10, 20};

// Centre lines of the markings, in pixels of a picture 960 wide (formats.md, JaC@t; Magera et al.
// 2024): one count for each distance of kJaccardPx. Points of a marking lie 0.25 m apart; the
// distance is to the whole estimated marking, also beyond the picture.
std::array<MarkingCount, 3> count_markings(const geometry::CameraEstimate& truth,
                                           const geometry::CameraEstimate& estimate,
                                           const pitch::PitchModel& pitch);

// Estimate minus truth; angles of the optical axis (design section 2), wrapped.
struct CameraError {
  double pan_deg = 0;
  double tilt_deg = 0;
  double focal_rel = 0;   // estimate / truth - 1
  double position_m = 0;  // distance
};
CameraError camera_error(const geometry::CameraEstimate& truth,
                         const geometry::CameraEstimate& estimate);

// What is left of `values` at rising `times_s` after taking away the mean over the 1 s round each;
// none of those with fewer than five values in that second. The mean holds its own value: of white
// noise sqrt(1 - 1/m) is left for m values in the second.
std::vector<std::optional<double>> without_slow_part(std::span<const double> times_s,
                                                     std::span<const double> values);

// Within which the mean of `count` squared standard normal variables lies with 90 %: chi-square
// over its degrees of freedom, by Wilson and Hilferty (1931); good to 1 % from three on.
std::array<double, 2> mean_square_band(int count);

}  // namespace touchline::score
