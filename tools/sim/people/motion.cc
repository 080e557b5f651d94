#include "tools/sim/people/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/people/random.h"

namespace touchline::sim::people {
namespace {

using Eigen::Vector2d;
using Q = Eigen::Quaternionf;
constexpr double kPi = std::numbers::pi;
constexpr double kRate = 50;
constexpr double kFadeIn = 0.16;
constexpr double kFadeOut = 0.28;
constexpr double kBridge = 0.45;  // from lying to the first frame of getting up

double ramp(double x, double from, double to) {
  const double u = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return u * u * u * (u * (6 * u - 15) + 10);
}

Vector2d turned(const Vector2d& v, double angle) {
  return {std::cos(angle) * v.x() - std::sin(angle) * v.y(),
          std::sin(angle) * v.x() + std::cos(angle) * v.y()};
}

Q about_x(float angle) { return Q(Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitX())); }
Q about_y(float angle) { return Q(Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitY())); }
Q about_z(float angle) { return Q(Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitZ())); }

}  // namespace

Pose Motion::Played::at(double time_s) const {
  Pose pose;
  if (time_s <= end || rise == nullptr) {
    pose = clip->at(time_s - start);
  } else if (time_s < rise_start) {
    pose = blend(clip->at(end - start), rise->at(0),
                 static_cast<float>(ramp(time_s, end, rise_start)));
  } else {
    pose = rise->at(time_s - rise_start);
  }
  return flip ? mirrored(pose) : pose;
}

float Motion::Played::share(double time_s) const {
  return static_cast<float>(ramp(time_s, start, start + kFadeIn) *
                            (1 - ramp(time_s, rise_end - kFadeOut, rise_end)));
}

Vector2d Motion::Played::travel(double time_s) const {
  constexpr double kStep = 0.02;
  const auto root = [&](double t) {
    const Eigen::Vector3f r = clip->at(t).root;
    return Vector2d(r.x(), r.y());
  };
  const double t = time_s - start;
  if (t < 0 || time_s > end) return Vector2d::Zero();
  Vector2d v = pace * (root(t + kStep / 2) - root(t - kStep / 2)) / kStep;
  if (flip) v.x() = -v.x();
  return v;
}

Motion::Motion(Input input)
    : spec_(*input.spec),
      clips_(input.clips),
      scale_(input.scale),
      seed_(input.seed),
      hold_(input.hold) {
  const Stream random(seed_, "manner " + spec_.id);
  ease_phase_ = random.uniform(0, 0, 100);
  ready_base_ = static_cast<float>(spec_.role == Role::kKeeper    ? random.uniform(1, 0.6, 0.95)
                                   : spec_.role == Role::kReferee ? 0.05
                                                                  : random.uniform(1, 0.05, 0.6));
  start_ = input.path.start_s;
  schedule(input.path);
  // Bend the path so that the ball is met where it is: twice over is enough, the plan being nearly
  // linear.
  PlacePath path = input.path;
  bool any = false;
  for (const ActionSpec& a : spec_.actions) any |= a.ball_m.has_value();
  run(path, input.ball);
  for (int round = 0; any && round < 3; ++round) {
    std::size_t p = 0;
    for (const ActionSpec& a : spec_.actions) {
      if (p >= played_.size()) break;
      const Played& played = played_[p++];
      if (!a.ball_m || !played.clip->has_ball()) continue;
      const Stance stance = at(a.time_s);
      Eigen::Vector3f reach =
          played.clip->ball_place() - played.clip->at(played.clip->ball_s()).root;
      if (played.flip) reach.x() = -reach.x();
      const Vector2d local = scale_ * Vector2d(reach.x(), reach.y());
      const Vector2d off = *a.ball_m - (stance.place + turned(local, stance.facing + kPi / 2));
      for (std::size_t i = 0; i < path.places.size(); ++i) {
        const double t = path.start_s + static_cast<double>(i) / path.rate_hz;
        path.places[i] += off * ramp(t, played.start - 2.0, played.start) *
                          (1 - ramp(t, played.rise_end, played.rise_end + 2.5));
      }
    }
    run(path, input.ball);
  }
}

void Motion::schedule(const PlacePath& path) {
  for (const ActionSpec& a : spec_.actions) {
    std::string name = a.name;
    const double speed = (path.at(a.time_s) - path.at(a.time_s - 0.3)).norm() / 0.3;
    // Taken in stride when there is a stride.
    if (speed > 2.5) {
      if (name == "shot") name = "shot_run";
      if (name == "pass") name = "pass_run";
      if (name == "header" || name == "header_jump") name = "header_run";
    }
    Played p;
    p.action = clips_->find(name, &p.clip);
    if (p.action == nullptr) continue;
    p.flip = p.action->flip != a.mirror;
    p.start = a.time_s - p.clip->ball_s();
    p.end = p.start + p.clip->seconds();
    p.rise_start = p.rise_end = p.end;
    if (p.action->down != 0) {
      p.rise = &clips_->rise(p.action->down);
      p.rise_start = p.end + kBridge;
      p.rise_end = p.rise_start + p.rise->seconds();
    }
    if (p.action->running) {
      const double entry = (path.at(p.start) - path.at(p.start - 0.2)).norm() / 0.2 / scale_;
      const double own = p.clip->at(0.1).root.head<2>().norm() / 0.1;
      p.pace = std::clamp(entry / std::max(0.5, own), 0.45, 1.4);
    }
    // One thing after the other.
    if (!played_.empty() && p.start < played_.back().rise_end - kFadeOut) {
      Played& before = played_.back();
      if (before.rise == nullptr && p.start > before.start + kFadeIn) {
        before.rise_end = before.rise_start = before.end =
            std::max(before.start + kFadeIn + 0.05, p.start + kFadeIn);
      }
    }
    played_.push_back(p);
  }
}

void Motion::run(const PlacePath& path, const BallPlace& ball) {
  const std::size_t n = path.places.size();
  samples_.assign(n, Sample{});
  const double dt = 1 / kRate;
  const Stream random(seed_, "gait " + spec_.id);
  Vector2d place = path.places.front();
  double facing = 0;
  double turn_rate = 0;
  double step = random.uniform(0, 0, 2);
  double speed = 0;
  double turn = 0;
  double look = 0;
  double ready = ready_base_;
  const auto wanted = [&](const Vector2d& at, double t, const Vector2d& velocity) {
    const Vector2d to_ball = ball ? Vector2d(ball(t) - at) : Vector2d(1, 0);
    if (spec_.facing == Facing::kFixed) return spec_.facing_deg * kPi / 180;
    const bool moving = velocity.norm() > 0.7;
    if (spec_.facing == Facing::kTravel && moving) return std::atan2(velocity.y(), velocity.x());
    if (spec_.facing == Facing::kBall && velocity.norm() > 5) {
      return std::atan2(velocity.y(), velocity.x());
    }
    if (to_ball.norm() > 0.7) return std::atan2(to_ball.y(), to_ball.x());
    return facing;
  };
  const auto velocity_at = [&](std::size_t i) -> Vector2d {
    const std::size_t a = i > 0 ? i - 1 : 0;
    const std::size_t b = std::min(i + 1, n - 1);
    return (path.places[b] - path.places[a]) /
           (static_cast<double>(std::max<std::size_t>(1, b - a)) * dt);
  };
  {
    Vector2d first = Vector2d::Zero();
    for (std::size_t i = 0; i < std::min<std::size_t>(n, 50); ++i) first += velocity_at(i) / 50.0;
    facing = wanted(place, start_, first);
  }
  bool began = false;
  for (std::size_t i = 0; i < n; ++i) {
    const double t = start_ + static_cast<double>(i) * dt;
    // Velocity: the path's, drawn back to it, or the clip's while one plays.
    Vector2d velocity = velocity_at(i);
    const Vector2d lag = path.places[i] - place;
    const double most = 1.2 + 0.35 * velocity.norm();
    Vector2d back = 2.5 * lag;
    if (back.norm() > most) back *= most / back.norm();
    velocity += back;
    bool acting = false;
    for (const Played& p : played_) {
      if (t < p.start || t > p.rise_end) continue;
      acting = true;
      const double share =
          ramp(t, p.start, p.start + kFadeIn) * (1 - ramp(t, p.rise_end - kFadeOut, p.rise_end));
      velocity = (1 - share) * velocity + share * scale_ * turned(p.travel(t), facing + kPi / 2);
    }
    // Facing: a damped spring towards what is wanted, 0.25 s ahead; held while acting.
    const double goal = wanted(place, t, velocity);
    const double error = std::remainder(goal - facing, 2 * kPi);
    if (!acting) {
      const double stiff = 60;
      const double damp = 15;
      turn_rate += dt * (stiff * error - damp * turn_rate);
      turn_rate = std::clamp(turn_rate, -9.0, 9.0);
    } else {
      turn_rate *= 0.8;
    }
    facing += dt * turn_rate;
    const double now = velocity.norm() / scale_;
    speed += (began ? 0.25 : 1.0) * (now - speed);
    if (now > 0.15) {
      const double going = std::atan2(velocity.y(), velocity.x()) - facing;
      const double change = std::remainder(going - turn, 2 * kPi);
      turn += (began ? 0.2 : 1.0) * change;
    }
    step += dt * (now / ClipLibrary::step_length(speed, turn) +
                  0.5 * std::abs(turn_rate) * std::max(0.0, 1 - speed));
    double look_goal = 0;
    if (ball) {
      const Vector2d to_ball = ball(t) - place;
      if (to_ball.norm() > 1) {
        look_goal = std::clamp(
            std::remainder(std::atan2(to_ball.y(), to_ball.x()) - facing, 2 * kPi), -1.1, 1.1);
        if (std::abs(std::remainder(std::atan2(to_ball.y(), to_ball.x()) - facing, 2 * kPi)) > 2.2)
          look_goal = 0;
      }
    }
    look += 0.08 * (look_goal - look);
    began = true;
    Sample& s = samples_[i];
    s.place = place;
    s.facing = facing;
    s.step = step;
    s.speed = static_cast<float>(speed);
    s.turn = static_cast<float>(turn);
    s.look = static_cast<float>(look);
    s.ready = static_cast<float>(ready);
    s.spin = static_cast<float>(turn_rate);
    place += dt * velocity;
  }
}

Motion::Sample Motion::sample(double time_s) const {
  const double x =
      std::clamp((time_s - start_) * kRate, 0.0, static_cast<double>(samples_.size()) - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), samples_.size() - 1);
  const std::size_t j = std::min(i + 1, samples_.size() - 1);
  const double u = x - static_cast<double>(i);
  const auto f = static_cast<float>(u);
  const Sample& a = samples_[i];
  const Sample& b = samples_[j];
  Sample s;
  s.place = (1 - u) * a.place + u * b.place;
  s.facing = (1 - u) * a.facing + u * b.facing;
  s.step = (1 - u) * a.step + u * b.step;
  s.speed = (1 - f) * a.speed + f * b.speed;
  s.turn = (1 - f) * a.turn + f * b.turn;
  s.look = (1 - f) * a.look + f * b.look;
  s.ready = (1 - f) * a.ready + f * b.ready;
  s.spin = (1 - f) * a.spin + f * b.spin;
  return s;
}

Pose Motion::held(double time_s, const Sample& s) const {
  Pose pose = clips_->gait(s.speed, s.turn, s.step, s.ready, s.spin);
  const auto at = [&](Node n) -> Q& { return pose.node[static_cast<std::size_t>(n)]; };
  const auto wave = [&](double hz, double shift) {
    return static_cast<float>(std::sin(2 * kPi * (hz * time_s + ease_phase_ + shift)));
  };
  if (hold_ == Hold::kWall) {
    // Hands before the body, feet close.
    for (int side = 0; side < 2; ++side) {
      const float out = side == 0 ? 1.0F : -1.0F;
      at(side == 0 ? Node::kLeftShoulder : Node::kRightShoulder) =
          about_x(-0.30F + 0.02F * wave(0.3, 0.1)) * about_z(-out * 0.75F) * about_y(-out * 0.10F);
      at(side == 0 ? Node::kLeftElbow : Node::kRightElbow) = about_x(-0.75F) * about_z(-out * 0.2F);
    }
    at(Node::kMiddle) = about_x(0.10F + 0.02F * wave(0.4, 0)) * at(Node::kMiddle);
  } else if (hold_ == Hold::kRuck) {
    // Bent over with the back level, arms bound round the next one, feet driving.
    const float push = 0.05F * wave(0.5, 0);
    at(Node::kBody) = about_x(0.75F + push);
    at(Node::kMiddle) = about_x(0.55F - push) * about_z(0.08F * wave(0.23, 0.4));
    at(Node::kNeck) = about_x(-0.55F) * about_z(0.12F * wave(0.31, 0.2));
    for (int side = 0; side < 2; ++side) {
      const float out = side == 0 ? 1.0F : -1.0F;
      const float stagger = 0.30F * out * (std::fmod(ease_phase_, 1.0) < 0.5 ? 1.0F : -1.0F);
      at(side == 0 ? Node::kLeftShoulder : Node::kRightShoulder) =
          about_x(-1.15F + 0.06F * wave(0.4, 0.3 * side)) * about_y(-out * 0.75F);
      at(side == 0 ? Node::kLeftElbow : Node::kRightElbow) = about_x(-0.8F) * about_z(out * 0.3F);
      at(side == 0 ? Node::kLeftThigh : Node::kRightThigh) =
          about_x(-1.05F + stagger) * about_y(-out * 0.16F);
      at(side == 0 ? Node::kLeftKnee : Node::kRightKnee) = about_x(0.75F - 0.15F * stagger - push);
      at(side == 0 ? Node::kLeftAnkle : Node::kRightAnkle) = about_x(-0.45F - 0.6F * stagger);
    }
  } else if (hold_ == Hold::kRuckDown) {
    pose = clips_->rise('f').at(0.02 + 0.02 * (1 + static_cast<double>(wave(0.2, 0))));
  }
  pose.root.setZero();
  return pose;
}

Vector2d Motion::dribbled(double time_s, double reach) const {
  const Sample s = sample(time_s);
  // A touch every second step sends it on; it comes back to the foot as he catches up.
  const double since = s.step / 2 - std::floor(s.step / 2);
  const double ahead = 0.34 + 0.10 * std::min(1.0F, s.speed) +
                       0.10 * static_cast<double>(s.speed) * since * (1 - since) * 4 * 0.6;
  const double going =
      s.facing + std::clamp(std::remainder(static_cast<double>(s.turn), 2 * kPi), -0.5, 0.5) *
                     std::min(1.0F, s.speed);
  const Vector2d forward(std::cos(going), std::sin(going));
  const Vector2d right(forward.y(), -forward.x());
  return s.place + reach * (ahead * forward + 0.10 * right);
}

Stance Motion::at(double time_s) const {
  const Sample s = sample(time_s);
  Stance out;
  out.place = s.place;
  out.facing = s.facing;
  out.pose = held(time_s, s);
  const auto at_node = [&](Node n) -> Q& { return out.pose.node[static_cast<std::size_t>(n)]; };
  // Breath and sway of somebody who stands; the head towards the ball.
  const auto wave = [&](double hz, double shift) {
    return static_cast<float>(std::sin(2 * kPi * (hz * time_s + ease_phase_ * 7 + shift)));
  };
  const float still = std::clamp(1 - s.speed, 0.0F, 1.0F);
  at_node(Node::kMiddle) = at_node(Node::kMiddle) * about_x(0.012F * wave(0.27, 0)) *
                           about_z(still * 0.06F * wave(0.11, 0.3));
  at_node(Node::kBody) = at_node(Node::kBody) * about_y(still * 0.02F * wave(0.13, 0.7));
  at_node(Node::kLeftThigh) = about_y(-still * 0.02F * wave(0.13, 0.7)) * at_node(Node::kLeftThigh);
  at_node(Node::kRightThigh) =
      about_y(-still * 0.02F * wave(0.13, 0.7)) * at_node(Node::kRightThigh);
  if (hold_ != Hold::kRuckDown)
    at_node(Node::kNeck) = about_z(0.75F * s.look) * at_node(Node::kNeck);
  for (const Played& p : played_) {
    if (time_s <= p.start || time_s >= p.rise_end) continue;
    Pose act = p.at(time_s);
    act.root.setZero();
    out.pose = blend(out.pose, act, p.share(time_s));
  }
  return out;
}

}  // namespace touchline::sim::people
