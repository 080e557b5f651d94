// Where a head points by people: those who stand in its picture are paired with the places where
// other cameras see people stand. The last resort of a unit whose picture shows neither lines nor
// anything it has seen before; as sure as the places are, which is not very, and it says so.
//
// One person whose place is known tells pan and tilt by the foot and focal length by the height;
// every such guess is judged by how many others then stand where they should, against how many
// would by chance.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "edge/calibrate/lines/line_map.h"
#include "edge/state/track_result.h"
#include "shared/base/result.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

// Someone stands here on the turf: pitch frame, metres, with a standard deviation in each
// direction.
struct StandingPlace {
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  double sd_m = 0;
};

struct PeopleOptions {
  LineMapOptions turf;            // how turf is told from what stands on it
  double height_m = 1.78;         // of people as they stand and run, 1.2..2.2
  double log_height_sd = 0.1;     // of its logarithm, 0.02..0.5
  double foot_sd_px = 4;          // of a foot in the picture, pixels at 1080 lines, 0.5..50
  double least_focal = 0.5;       // picture widths, 0.1..20
  double most_focal = 25;         // the same, up to 100
  double seen_share = 0.7;        // of people in the picture, that are found in it, 0.1..0.99
  double least_evidence = 9;      // logarithm of the odds against chance, 1..100
  double least_margin = 6;        // by which another camera must be less likely, the same
  double pan_reach_deg = 4;       // how far from a prior is looked beyond its 3 sd, 0..180
  double log_focal_reach = 0.15;  // the same

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

// Evidence kPeers, with the covariance of pan, tilt and log f; the report counts the people. Lost,
// with a reason, where too few agree or another camera would do as well. `prior`: where the head
// may point, with its covariance; without one everywhere. Pure; options must be valid.
state::TrackResult register_people(const image::Frame& frame, const pitch::PitchModel& pitch,
                                   const geometry::Mount& mount,
                                   std::span<const StandingPlace> places,
                                   const std::optional<geometry::CameraEstimate>& prior,
                                   const PeopleOptions& options);

}  // namespace touchline::calibrate
