#include "hub/track/people_tracker.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hub/track/assignment.h"
#include "hub/track/measurement_internal.h"
#include "shared/base/bounds.h"

namespace touchline::track {

namespace {

constexpr double kPersonSpeedSd = 4;  // of someone just seen, m/s
constexpr double kBallSpeedSd = 12;
constexpr double kMostPersonSpeed = 11;  // m/s
constexpr double kMostBallSpeed = 45;
constexpr double kMostDeviations = 5;
// Between the middle of a body and the point under its pelvis, metres: people lean.
constexpr double kLeanSd = 0.12;

// Position and velocity in plan.
struct Filter {
  Eigen::Vector4d state = Eigen::Vector4d::Zero();
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();

  void start(const Measurement& m, double speed_sd) {
    state << m.place.x(), m.place.y(), 0, 0;
    covariance.setZero();
    covariance.topLeftCorner<2, 2>() = m.covariance;
    covariance.bottomRightCorner<2, 2>() = speed_sd * speed_sd * Eigen::Matrix2d::Identity();
  }

  void predict(double seconds, double acceleration_sd) {
    Eigen::Matrix4d step = Eigen::Matrix4d::Identity();
    step.topRightCorner<2, 2>() = seconds * Eigen::Matrix2d::Identity();
    state = step * state;
    covariance = step * covariance * step.transpose();
    const double q = acceleration_sd * acceleration_sd;
    const double t2 = seconds * seconds;
    for (Eigen::Index i = 0; i < 2; ++i) {
      covariance(i, i) += q * t2 * t2 / 4;
      covariance(i, i + 2) += q * t2 * seconds / 2;
      covariance(i + 2, i) += q * t2 * seconds / 2;
      covariance(i + 2, i + 2) += q * t2;
    }
  }

  void correct(const Measurement& m, double most_speed) {
    const Eigen::Matrix2d innovation = covariance.topLeftCorner<2, 2>() + m.covariance;
    const Eigen::Matrix<double, 4, 2> gain = covariance.leftCols<2>() * innovation.inverse();
    state += gain * (m.place.head<2>() - state.head<2>());
    covariance -= gain * innovation * gain.transpose();
    covariance = (covariance + covariance.transpose()).eval() / 2;
    const double speed = state.tail<2>().norm();
    if (speed > most_speed) state.tail<2>() *= most_speed / speed;
  }

  // Squared deviations between a measurement and the prediction; large beyond the gate.
  double cost(const Measurement& m, double gate_m) const {
    constexpr double kBeyond = 1e6;
    const Eigen::Vector2d away = m.place.head<2>() - state.head<2>();
    if (away.norm() > gate_m) return kBeyond;
    // The gate is of distance; the deviations weigh directions, with a floor of a step's length.
    const Eigen::Matrix2d innovation =
        covariance.topLeftCorner<2, 2>() + m.covariance + 0.04 * Eigen::Matrix2d::Identity();
    return away.dot(innovation.inverse() * away);
  }
};

struct Track {
  int number = 0;  // of the id; 0 = not yet told
  Filter filter;
  double z = 0;
  int seen = 0;
  std::int64_t first_seen_ns = 0;
  std::int64_t last_seen_ns = 0;
  std::vector<std::uint32_t> groups;
};

}  // namespace

base::Status TrackOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("track.acceleration_sd", acceleration_sd, 0.1, 20),
        base::in_bounds("track.ball_acceleration_sd", ball_acceleration_sd, 1, 200),
        base::in_bounds("track.gate_m", gate_m, 0.2, 5),
        base::in_bounds("track.ball_gate_m", ball_gate_m, 0.2, 10),
        base::in_bounds("track.coast_s", coast_s, 0, 5),
        base::in_bounds("track.forget_s", forget_s, coast_s, 30),
        base::in_bounds("track.confirm_frames", confirm_frames, 1, 50),
        base::in_bounds("track.foot_sd_px", foot_sd_px, 0.1, 20),
        base::in_bounds("track.least_person_m3", least_person_m3, 0.005, 1)}) {
    if (!status) return status;
  }
  return {};
}

class PeopleTracker::Impl {
 public:
  Impl(pitch::PitchModel pitch, const TrackOptions& options)
      : pitch_(std::move(pitch)), options_(options) {}

  std::vector<scene::Person> update(const scene::Hull& hull,
                                    std::span<const codec::CameraView> views,
                                    base::MediaTime instant) {
    const bool first = !last_;
    const double seconds =
        last_ ? std::max(0.0, static_cast<double>(instant.ns - last_->ns) * 1e-9) : 0;
    last_ = instant;
    std::vector<Eigen::Vector2d> expected;
    for (Track& track : people_) {
      track.filter.predict(seconds, options_.acceleration_sd);
      if (track.number > 0) expected.push_back(track.filter.state.head<2>());
    }
    const Measurements found = measure(hull, views, expected, pitch_, options_);
    follow_people(found.people, instant, first);
    follow_ball(found.balls, instant, seconds);
    return told(instant);
  }

 private:
  double unseen_s(const Track& track, base::MediaTime now) const {
    return static_cast<double>(now.ns - track.last_seen_ns) * 1e-9;
  }

  void follow_people(const std::vector<Measurement>& found, base::MediaTime now, bool first) {
    Eigen::MatrixXd cost(static_cast<Eigen::Index>(people_.size()),
                         static_cast<Eigen::Index>(found.size()));
    for (std::size_t t = 0; t < people_.size(); ++t) {
      // Who was not seen for a while may be farther off.
      const double gate = options_.gate_m + 2 * unseen_s(people_[t], now);
      for (std::size_t m = 0; m < found.size(); ++m) {
        cost(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(m)) =
            people_[t].filter.cost(found[m], gate);
      }
    }
    const std::vector<int> pair = assign(cost, kMostDeviations * kMostDeviations);
    std::vector<bool> taken(found.size(), false);
    for (std::size_t t = 0; t < people_.size(); ++t) {
      people_[t].groups.clear();
      if (pair[t] < 0) continue;
      const auto m = static_cast<std::size_t>(pair[t]);
      taken[m] = true;
      people_[t].filter.correct(found[m], kMostPersonSpeed);
      people_[t].groups = found[m].groups;
      people_[t].last_seen_ns = now.ns;
      ++people_[t].seen;
    }
    for (std::size_t m = 0; m < found.size(); ++m) {
      if (taken[m]) continue;
      Track track;
      track.filter.start(found[m], kPersonSpeedSd);
      track.groups = found[m].groups;
      track.first_seen_ns = now.ns;
      track.last_seen_ns = now.ns;
      track.seen = 1;
      people_.push_back(std::move(track));
    }
    std::erase_if(people_, [&](const Track& track) {
      const double wait = track.number > 0 ? options_.forget_s : options_.coast_s / 2;
      return unseen_s(track, now) > wait;
    });
    std::vector<Track*> newcomers;
    for (Track& track : people_) {
      if (track.number == 0 && (first || track.seen >= options_.confirm_frames)) {
        newcomers.push_back(&track);
      }
    }
    std::stable_sort(newcomers.begin(), newcomers.end(), [](const Track* a, const Track* b) {
      return a->filter.state.x() < b->filter.state.x();
    });
    for (Track* track : newcomers) track->number = ++last_number_;
  }

  void follow_ball(const std::vector<Measurement>& found, base::MediaTime now, double seconds) {
    if (ball_) {
      ball_->filter.predict(seconds, options_.ball_acceleration_sd);
      ball_->groups.clear();
      const Measurement* best = nullptr;
      double least = kMostDeviations * kMostDeviations;
      const double gate = options_.ball_gate_m * (1 + unseen_s(*ball_, now));
      for (const Measurement& m : found) {
        const double cost = ball_->filter.cost(m, gate);
        if (cost < least) {
          least = cost;
          best = &m;
        }
      }
      if (best) {
        ball_->filter.correct(*best, kMostBallSpeed);
        ball_->z = best->place.z();
        ball_->groups = best->groups;
        ball_->last_seen_ns = now.ns;
      } else if (unseen_s(*ball_, now) > options_.coast_s) {
        ball_.reset();
      }
    }
    if (!ball_ && !found.empty()) {
      ball_.emplace();
      ball_->filter.start(found.front(), kBallSpeedSd);
      ball_->z = found.front().place.z();
      ball_->groups = found.front().groups;
      ball_->last_seen_ns = now.ns;
    }
  }

  static scene::Person person_of(const Track& track) {
    scene::Person person;
    const double lean = track.number > 0 ? kLeanSd * kLeanSd : 0;
    person.sd_x_m = std::sqrt(std::max(0.0, track.filter.covariance(0, 0)) + lean);
    person.sd_y_m = std::sqrt(std::max(0.0, track.filter.covariance(1, 1)) + lean);
    person.groups = track.groups;
    return person;
  }

  std::vector<scene::Person> told(base::MediaTime now) const {
    std::vector<const Track*> tracks;
    for (const Track& track : people_) {
      // Someone seen briefly is not told for longer than that.
      const double known_s = static_cast<double>(track.last_seen_ns - track.first_seen_ns) * 1e-9;
      if (track.number > 0 && unseen_s(track, now) <= std::min(options_.coast_s, known_s)) {
        tracks.push_back(&track);
      }
    }
    std::sort(tracks.begin(), tracks.end(),
              [](const Track* a, const Track* b) { return a->number < b->number; });
    std::vector<scene::Person> people;
    for (const Track* track : tracks) {
      scene::Person person = person_of(*track);
      person.id = fmt::format("p{:02}", track->number);
      person.position_in_world = pitch_.on_turf(track->filter.state.head<2>());
      people.push_back(std::move(person));
    }
    if (ball_) {
      scene::Person ball = person_of(*ball_);
      ball.id = "ball";
      ball.role = "ball";
      ball.position_in_world = {ball_->filter.state.x(), ball_->filter.state.y(), ball_->z};
      people.push_back(std::move(ball));
    }
    return people;
  }

  pitch::PitchModel pitch_;
  TrackOptions options_;
  std::optional<base::MediaTime> last_;
  std::vector<Track> people_;
  std::optional<Track> ball_;
  int last_number_ = 0;
};

PeopleTracker::PeopleTracker(const pitch::PitchModel& pitch, const TrackOptions& options)
    : impl_(std::make_unique<Impl>(pitch, options)) {}
PeopleTracker::PeopleTracker(PeopleTracker&&) noexcept = default;
PeopleTracker& PeopleTracker::operator=(PeopleTracker&&) noexcept = default;
PeopleTracker::~PeopleTracker() = default;

std::vector<scene::Person> PeopleTracker::update(const scene::Hull& hull,
                                                 std::span<const codec::CameraView> views,
                                                 base::MediaTime instant) {
  return impl_->update(hull, views, instant);
}

}  // namespace touchline::track
