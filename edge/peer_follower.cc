#include "edge/peer_follower.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "edge/chain_internal.h"
#include "shared/base/bounds.h"

namespace touchline::edge {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kSamePerson = 1.0;  // metres: nearer ones of two cameras are one person

double seconds(base::MediaTime time) { return static_cast<double>(time.ns) * 1e-9; }

}  // namespace

base::Status PeerOptions::validate() const {
  if (base::Status status = people.validate(); !status) return status;
  for (const base::Status& status :
       {base::in_bounds("peers.oldest_s", oldest_s, 0.05, 5),
        base::in_bounds("peers.speed_m_s", speed_m_s, 0.1, 10),
        base::in_bounds("peers.period_s", period_s, 0, 10),
        base::in_bounds("peers.most_px", most_px, 0.1, 100),
        base::in_bounds("peers.pan_rate_deg", pan_rate_deg, 0.1, 180),
        base::in_bounds("peers.tilt_rate_deg", tilt_rate_deg, 0.1, 90),
        base::in_bounds("peers.log_focal_rate", log_focal_rate, 0.01, 5)}) {
    if (!status) return status;
  }
  return {};
}

void PeerFollower::hear(PeopleSeen people) {
  const auto before = seen_.find(people.camera.value);
  if (before != seen_.end() && before->second.domain == people.domain &&
      before->second.time > people.time)
    return;
  seen_[people.camera.value] = std::move(people);
}

void PeerFollower::learn(const image::Frame& frame, const geometry::CameraEstimate& estimate) {
  last_ = estimate;
  last_s_ = seconds(frame.stamp.media_time);
  next_try_s_ = -1e300;
}

// Everyone heard of lately, once; those who were seen longer ago are less surely there.
std::vector<calibrate::StandingPlace> PeerFollower::places_at(const base::FrameStamp& stamp) const {
  std::vector<calibrate::StandingPlace> out;
  for (const auto& [camera, people] : seen_) {
    const double age = std::abs(seconds(stamp.media_time) - seconds(people.time));
    if (people.domain != stamp.domain || age > options_.oldest_s) continue;
    for (calibrate::StandingPlace place : people.places) {
      place.sd_m = std::hypot(place.sd_m, options_.speed_m_s * age);
      const auto same = std::find_if(out.begin(), out.end(), [&](const auto& other) {
        return (other.at - place.at).norm() < kSamePerson;
      });
      if (same == out.end()) {
        out.push_back(place);
      } else if (place.sd_m < same->sd_m) {
        *same = place;
      }
    }
  }
  return out;
}

std::optional<geometry::CameraEstimate> PeerFollower::prior(double now_s) const {
  if (!last_) return std::nullopt;
  geometry::CameraEstimate out = *last_;
  const double since = std::abs(now_s - last_s_);
  out.covariance(0, 0) += std::pow(options_.pan_rate_deg * kRadians * since, 2);
  out.covariance(1, 1) += std::pow(options_.tilt_rate_deg * kRadians * since, 2);
  out.covariance(3, 3) += std::pow(options_.log_focal_rate * since, 2);
  return out;
}

geometry::CameraEstimate PeerFollower::find(const image::Frame& frame,
                                            const pitch::PitchModel& pitch,
                                            const geometry::Mount& mount) {
  geometry::CameraEstimate lost;
  lost.model.width = frame.width();
  lost.model.height = frame.height();
  const double now = seconds(frame.stamp.media_time);
  if (seen_.empty() || now < next_try_s_) return lost;
  const std::vector<calibrate::StandingPlace> places = places_at(frame.stamp);
  if (places.empty()) return lost;
  next_try_s_ = now + options_.period_s;
  return calibrate::register_people(frame, pitch, mount, places, prior(now), options_.people)
      .estimate;
}

bool PeerFollower::believed(const geometry::CameraEstimate& estimate) const {
  return !estimate.lost() && picture_sd_px(estimate) <= options_.most_px;
}

}  // namespace touchline::edge
