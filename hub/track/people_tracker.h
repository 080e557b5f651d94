// Who stands where: people and the ball found in the hull of each instant and followed over a shot.
//
// A person is measured by the part of a hull group that stands at body height, seen in plan; a
// group whose plan has several summits, or that holds several people who were followed until then,
// is divided. People that one camera sees are measured where their silhouette meets the turf. Each
// is followed by a Kalman filter of constant velocity; measurements and people are paired at least
// cost.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hub/scene/hull.h"
#include "hub/scene/people.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

struct TrackOptions {
  double acceleration_sd = 3;        // of people between frames, m/s^2, 0.1..20
  double ball_acceleration_sd = 30;  // of the ball, m/s^2, 1..200
  double gate_m = 1.5;            // farther from where someone is expected is someone else, 0.2..5
  double ball_gate_m = 3;         // the same of the ball, metres, 0.2..10
  double coast_s = 0.4;           // someone not seen is still told for this long, seconds, 0..5
  double forget_s = 1.0;          // and waited for this long, seconds, coast_s..30
  int confirm_frames = 4;         // newcomers must be seen this often before they are told, 1..50
  double foot_sd_px = 2;          // of where a silhouette meets the turf, pixels, 0.1..20
  double least_person_m3 = 0.03;  // smaller groups are no people, 0.005..1

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

class PeopleTracker {
 public:
  // `options` must be valid.
  explicit PeopleTracker(const pitch::PitchModel& pitch, const TrackOptions& options = {});
  PeopleTracker(PeopleTracker&&) noexcept;
  PeopleTracker& operator=(PeopleTracker&&) noexcept;
  ~PeopleTracker();

  // Instants must rise. People come in order of their ids: p01, p02, ... in order of first
  // appearance and, at one instant, of rising x; then the ball, "ball", where there is one. Team
  // and role stay empty, but for the ball's. Phantoms are passed over. sd is of the filter.
  std::vector<scene::Person> update(const scene::Hull& hull,
                                    std::span<const codec::CameraView> views,
                                    base::MediaTime instant);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::track
