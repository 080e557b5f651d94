// One person's plan over a scene: where the feet go, where the body faces and looks, which steps
// fall when, what is played over them. Made once; asked at any time.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <vector>

#include "tools/sim/people/gait.h"
#include "tools/sim/people/path.h"

namespace touchline::sim::people {

// Body and limbs at a time: ground place, facing (radians from +X), and the figure's pose.
struct Stance {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  double facing = 0;
  Pose pose;
};

using BallPlace = std::function<Eigen::Vector2d(double)>;

// How somebody stands in a group; empty = as anyone does.
enum class Hold : std::uint8_t { kNone, kWall, kRuck, kRuckDown };

class Motion {
 public:
  struct Input {
    const PersonSpec* spec = nullptr;
    const ClipLibrary* clips = nullptr;
    PlacePath path;
    BallPlace ball;    // where to look
    double scale = 1;  // height over 1.8 m
    std::uint64_t seed = 0;
    Hold hold = Hold::kNone;
  };
  explicit Motion(Input input);
  Stance at(double time_s) const;
  // Where a ball is that this person drives before his feet.
  Eigen::Vector2d dribbled(double time_s, double reach) const;

 private:
  struct Sample {
    Eigen::Vector2d place = Eigen::Vector2d::Zero();
    double facing = 0;  // unwrapped
    double step = 0;    // steps so far
    float speed = 0;    // of a 1.8 m person
    float turn = 0;     // from facing to going, unwrapped
    float look = 0;     // of the head, from facing
    float ready = 0;
    float spin = 0;  // rad/s, of the body
  };
  struct Played {
    const ClipLibrary::Action* action = nullptr;
    const Clip* clip = nullptr;
    const Clip* rise = nullptr;
    bool flip = false;
    double start = 0;
    double end = 0;  // of the clip
    double rise_start = 0;
    double rise_end = 0;  // = end without a rise
    double pace = 1;      // of the clip's travel
    Pose at(double time_s) const;
    float share(double time_s) const;             // 0..1 over the gait
    Eigen::Vector2d travel(double time_s) const;  // velocity in the figure's frame, m/s
  };
  void schedule(const PlacePath& path);
  void run(const PlacePath& path, const BallPlace& ball);
  Sample sample(double time_s) const;
  Pose held(double time_s, const Sample& s) const;

  const PersonSpec spec_;
  const ClipLibrary* clips_;
  double scale_;
  std::uint64_t seed_;
  Hold hold_;
  double start_ = 0;
  std::vector<Sample> samples_;
  std::vector<Played> played_;
  double ease_phase_ = 0;
  float ready_base_ = 0.3F;
};

}  // namespace touchline::sim::people
