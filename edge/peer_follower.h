// People whom other cameras see, as the hub tells them, for a frame that shows neither lines nor
// anything known: the last resort of a head (design.md section 4, hub/people).
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "edge/calibrate/peers/people_registration.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::edge {

// The people whom one camera sees at an instant.
struct PeopleSeen {
  base::CameraId camera;
  base::MediaTime time;
  base::ClockDomain domain = base::ClockDomain::kUnknown;
  std::vector<calibrate::StandingPlace> places;
};

struct PeerOptions {
  calibrate::PeopleOptions people;
  double oldest_s = 0.6;        // people seen longer ago are passed over, seconds, 0.05..5
  double speed_m_s = 2.5;       // standard deviation of people's speed, 0.1..10
  double period_s = 0.2;        // between two attempts, seconds, 0..10
  double most_px = 6;           // people alone are believed when this sure, at 1080 lines, 0.1..100
  double pan_rate_deg = 15;     // standard deviation of what the head did since, a second, 0.1..180
  double tilt_rate_deg = 6;     // the same, 0.1..90
  double log_focal_rate = 0.3;  // the same, 0.01..5

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

class PeerFollower {
 public:
  // Options must be valid.
  explicit PeerFollower(const PeerOptions& options) : options_(options) {}

  // Of each camera the newest counts.
  void hear(PeopleSeen people);
  // A frame that was solved otherwise: where the head is looked for later.
  void learn(const image::Frame& frame, const geometry::CameraEstimate& estimate);
  // The camera of a frame by people, evidence kPeers; lost while nobody was heard of lately, or
  // where they do not tell. Tried once a period.
  geometry::CameraEstimate find(const image::Frame& frame, const pitch::PitchModel& pitch,
                                const geometry::Mount& mount);
  // Whether an estimate is sure enough to stand for its frame.
  bool believed(const geometry::CameraEstimate& estimate) const;
  // The mount is another from here on.
  void forget() { last_.reset(); }

 private:
  std::vector<calibrate::StandingPlace> places_at(const base::FrameStamp& stamp) const;
  std::optional<geometry::CameraEstimate> prior(double now_s) const;

  PeerOptions options_;
  std::map<std::string, PeopleSeen> seen_;  // by camera
  std::optional<geometry::CameraEstimate> last_;
  double last_s_ = 0;  // when that was
  double next_try_s_ = -1e300;
};

}  // namespace touchline::edge
