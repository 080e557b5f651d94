// Where the painted lines are in a picture, measured in windows round where a predicted camera puts
// them (chapter 4.2, "Tracking"): each window lies across one marking and holds every white ridge
// of the expected width found in it, as hypotheses; which is the marking is decided by the fit.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// A white ridge in a window.
struct LineCandidate {
  double offset_px = 0;  // of its centre from the prediction, along the window's normal
  double contrast = 0;   // of the paint over the turf, 10-bit code values
  double match = 0;      // correlation with the expected profile, 0..1
  double sigma_px = 0;   // expected standard deviation of offset_px
};

// What a window shows.
enum class WindowState : std::uint8_t {
  kFound,   // at least one candidate
  kBare,    // turf all over and no line, though a line would be seen there
  kHidden,  // something other than turf covers it
  kFaint,   // the line would be too thin or the turf too rough to tell
};

// A window across the centre line of a marking.
struct LinePoint {
  static constexpr int kMostCandidates = 4;

  pitch::MarkingId marking{};
  Eigen::Vector3d point_in_world = Eigen::Vector3d::Zero();  // on the marking's centre line
  double share = 0;                                          // of its length, where the point is
  // How the point moves with the pitch's length, width and crown (columns), metres a metre.
  Eigen::Matrix3d by_size = Eigen::Matrix3d::Zero();
  Eigen::Vector2d predicted = Eigen::Vector2d::Zero();  // its pixel for the prediction
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();     // unit, across the line, in the image
  double width_px = 0;                                  // of the paint along the normal
  double length_px = 0;                                 // of line that the window stands for
  double search_px = 0;                                 // half width of the window
  WindowState state = WindowState::kHidden;
  int count = 0;  // of candidates, by falling contrast * match
  std::array<LineCandidate, kMostCandidates> candidates;

  Eigen::Vector2d pixel(const LineCandidate& candidate) const {
    return predicted + candidate.offset_px * normal;
  }
};

struct LinePointOptions {
  double step_px = 8;            // between windows along a marking, pixels at 1080 lines
  int most_windows = 900;        // a frame; the step grows to keep to it
  double search_px = 12;         // half width of a window, pixels at 1080 lines
  double search_sigmas = 3;      // a window also reaches this many sigma of the prediction
  double most_search_px = 48;    // and never beyond this
  double blur_px = 0.7;          // sigma of the picture's point spread
  double least_width_px = 0.25;  // thinner paint is not looked for
  double most_width_px = 60;     // wider neither
  double least_contrast = 60;    // of paint over turf, 10-bit code values
  double noise_factor = 4;       // a candidate also stands this many sigma of the turf out
  double least_match = 0.72;     // correlation of a candidate with the expected profile
  double turf_chroma = 0.06;     // least green of turf: -(Cb - 512) - (Cr - 512) over luma
  double sigma_floor_px = 0.12;  // least sigma_px of a candidate

  base::Status validate() const;
};

// One LinePoint a window, marking by marking in the pitch's order, along each. Spots are left out,
// and places where another marking crosses. Options must be valid.
std::vector<LinePoint> measure_lines(const image::Frame& frame, const pitch::PitchModel& pitch,
                                     const geometry::CameraEstimate& predicted,
                                     const LinePointOptions& options);

}  // namespace touchline::calibrate
