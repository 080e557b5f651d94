#include "tools/sim/people/gait.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/people/asset_files.h"

namespace touchline::sim::people {
namespace {

using Q = Eigen::Quaternionf;
using Eigen::Vector3f;
constexpr double kPi = std::numbers::pi;
constexpr std::size_t kClipLimit = 1U << 20U;

Q about(const Vector3f& axis, float angle) { return Q(Eigen::AngleAxisf(angle, axis)); }
Q about_x(float angle) { return about(Vector3f::UnitX(), angle); }
Q about_y(float angle) { return about(Vector3f::UnitY(), angle); }
Q about_z(float angle) { return about(Vector3f::UnitZ(), angle); }

double ramp(double x, double from, double to) {
  const double u = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return u * u * (3 - 2 * u);
}

// The heading of a body that faces -Y when straight: its turn about Z.
float yaw_of(const Q& body) {
  const Vector3f ahead = body * Vector3f(0, -1, 0);
  return std::atan2(ahead.x(), -ahead.y());
}

// Joint angles of level walking over a gait cycle in tenths from heel strike, degrees: hip and knee
// flexion, ankle dorsiflexion (after Winter, Biomechanics and Motor Control of Human Movement).
constexpr std::array<float, 10> kHip{28, 25, 16, 6, -4, -10, -4, 12, 24, 30};
constexpr std::array<float, 10> kKnee{6, 18, 17, 11, 8, 14, 38, 60, 50, 20};
constexpr std::array<float, 10> kAnkle{0, -5, 3, 7, 9, 6, -16, -8, 0, 1};

float cyclic(const std::array<float, 10>& table, double cycle) {
  const double x = (cycle - std::floor(cycle)) * 10;
  const auto i = static_cast<std::size_t>(x) % 10;
  const auto at = [&](std::size_t k) { return table[k % 10]; };
  const float u = static_cast<float>(x - std::floor(x));
  const float p0 = at(i + 9);
  const float p1 = at(i);
  const float p2 = at(i + 1);
  const float p3 = at(i + 2);
  return p1 +
         0.5F * u * (p2 - p0 + u * (2 * p0 - 5 * p1 + 4 * p2 - p3 + u * (3 * (p1 - p2) + p3 - p0)));
}

Pose walk(double step) {
  Pose pose;
  const auto set = [&](Node n, const Q& q) { pose.node[static_cast<std::size_t>(n)] = q; };
  const float degree = static_cast<float>(kPi / 180);
  const double left = 0.3 + 0.5 * step;  // mid-stance of the left foot at even steps
  const float swing = static_cast<float>(std::sin(kPi * step));
  for (int side = 0; side < 2; ++side) {
    const double cycle = left + 0.5 * side;
    const float out = side == 0 ? 1.0F : -1.0F;
    set(side == 0 ? Node::kLeftThigh : Node::kRightThigh,
        about_x(-degree * cyclic(kHip, cycle)) * about_y(-out * 0.03F) * about_z(out * 0.08F));
    set(side == 0 ? Node::kLeftKnee : Node::kRightKnee, about_x(degree * cyclic(kKnee, cycle)));
    set(side == 0 ? Node::kLeftAnkle : Node::kRightAnkle, about_x(-degree * cyclic(kAnkle, cycle)));
    // Arms go with the other leg.
    const float arm = out * swing;
    set(side == 0 ? Node::kLeftShoulder : Node::kRightShoulder,
        about_x(-0.32F * arm + 0.08F) * about_y(-out * 0.16F) * about_z(-out * 0.2F));
    set(side == 0 ? Node::kLeftElbow : Node::kRightElbow, about_x(-0.32F - 0.15F * arm));
  }
  set(Node::kBody, about_z(-0.08F * swing) * about_x(0.04F));
  set(Node::kMiddle, about_z(0.16F * swing) * about_x(0.03F));
  set(Node::kNeck, about_z(-0.08F * swing) * about_x(0.03F));
  return pose;
}

}  // namespace

const std::vector<ClipLibrary::Action>& ClipLibrary::actions() {
  static const std::vector<Action> kActions{
      {"shot", "shot/idle/020", false, false, 0},
      {"shot_run", "shot/sprint/030", false, true, 0},
      {"pass", "pass/idle/000", false, false, 0},
      {"pass_run", "pass/walk/000", false, true, 0},
      {"header", "pass/idle/nonbase/000_header", false, false, 0},
      {"header_jump", "pass/idle/nonbase/000_header_jump_forwards", false, false, 0},
      {"header_run", "pass/sprint/nonbase/000_header_jump", false, true, 0},
      {"header_dive", "shot/sprint/000_headerdive", false, true, 'f'},
      {"bicycle", "shot/idle/180_bicycle", false, false, 'b'},
      {"slide", "sliding/sprint/000", false, true, 'b'},
      {"tackle", "interfere/walk/000_stretch", false, true, 0},
      {"throw", "pass/idle/special/000_throw", false, false, 0},
      {"dive_high", "deflect/idle/090_high_deflect_far", true, false, 'f'},
      {"dive_mid", "deflect/idle/090_midheight_deflect_far", true, false, 'f'},
      {"dive_low", "deflect/idle/090_ground_deflect_far", false, false, 'f'},
      {"catch", "deflect/idle/000_trunk_holdball", false, false, 0},
      {"catch_high", "deflect/idle/000_high_holdball", false, false, 0},
      {"trap", "trap/idle/000_IB000", false, false, 0},
      {"chest", "trap/idle/highballs/000_chest", false, false, 0},
      {"trip", "trip/trip_t2/idle/000_000", false, true, 0},
      {"fall", "trip/trip_t3/sprint/000", false, true, 'f'},
      {"celebrate", "celebration/happy_extreme/000_decel_decel", false, true, 0},
      {"applaud", "celebration/happy_normal/000", false, false, 0},
      {"dismay", "celebration/sad_normal/000", false, false, 0},
      {"card", "special/000_showcard", false, false, 0},
  };
  return kActions;
}

const std::vector<std::string>& action_names() {
  static const std::vector<std::string> kNames = [] {
    std::vector<std::string> out;
    for (const auto& action : ClipLibrary::actions()) out.emplace_back(action.name);
    return out;
  }();
  return kNames;
}

const ClipLibrary::Action* ClipLibrary::find(const std::string& name, const Clip** clip) const {
  const auto& all = actions();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (name == all[i].name) {
      *clip = &clips_[i];
      return &all[i];
    }
  }
  return nullptr;
}

base::Result<ClipLibrary> ClipLibrary::load(const std::filesystem::path& assets,
                                            const Human& human) {
  const Figure average(human, ShapeSpec{}, Outfit{});
  const float straight = average.lowest(human, average.rig().motions(Pose{}));
  // How high the lowest point is over the turf, were the pelvis where the clip says.
  const auto height = [&](const Pose& pose) {
    return average.lowest(human, average.rig().motions(pose)) - straight + pose.root.z();
  };
  const auto read = [&](const std::string& file, bool cyclic_clip) -> base::Result<Clip> {
    const std::filesystem::path path = assets / "anim" / (file + ".anim");
    const auto text = read_text(path, kClipLimit);
    if (!text) return base::fail(text.error());
    auto parsed = parse_clip(*text, path.string());
    if (!parsed) return base::fail(parsed.error());
    Clip clip(std::move(*parsed));
    std::vector<float> lift;
    float least = 1e9F;
    for (int f = 0; f <= clip.frames(); ++f) {
      lift.push_back(height(clip.at(f / 100.0)));
      least = std::min(least, lift.back());
    }
    // Cycles touch the turf somewhere; others float by their own height less what is not to scale.
    for (float& h : lift) h = std::max(0.0F, h - (cyclic_clip ? least : 0.06F));
    if (cyclic_clip) {
      // Not every centimetre of the key frames is meant: a soft half of it.
      const auto raw = lift;
      const auto n = static_cast<int>(raw.size()) - 1;
      for (int f = 0; f <= n; ++f) {
        float sum = 0;
        for (int d = -3; d <= 3; ++d) sum += raw[static_cast<std::size_t>(((f + d) % n + n) % n)];
        lift[static_cast<std::size_t>(f)] = 0.5F * sum / 7;
      }
    }
    clip.set_lift(std::move(lift));
    return clip;
  };
  ClipLibrary library;
  const auto cycle = [&](const std::string& even, const std::string& odd) -> base::Result<Cycle> {
    Cycle out;
    auto clip = read(even, true);
    if (!clip) return base::fail(clip.error());
    out.even = std::move(*clip);
    if (!odd.empty()) {
      auto other = read(odd, true);
      if (!other) return base::fail(other.error());
      out.odd = std::move(*other);
      const auto yaw = [&](double step) {
        const double u = step - std::floor(step);
        return step < 1 ? yaw_of(out.even.at(u * out.even.seconds()).node[0])
                        : -yaw_of(out.odd.at(u * out.odd.seconds()).node[0]);
      };
      double sum = 0;
      for (int i = 0; i < 40; ++i) sum += yaw(i / 20.0);
      out.travel = static_cast<float>(-sum / 40);
    }
    return out;
  };
  for (const auto& [even, odd] : {std::pair<std::string, std::string>{"templates/walkD000", ""},
                                  {"templates/walkD045", "templates/walkD045_left"}}) {
    auto made = cycle(even, odd);
    if (!made) return base::fail(made.error());
    library.run_.push_back(std::move(*made));
  }
  auto sprint = cycle("templates/sprintD000", "");
  if (!sprint) return base::fail(sprint.error());
  library.sprint_ = std::move(*sprint);
  for (const Action& action : actions()) {
    auto clip = read(action.file, false);
    if (!clip) return base::fail(clip.error());
    library.clips_.push_back(std::move(*clip));
  }
  for (const char down : {'b', 'f'}) {
    auto clip = read(std::string("movement_special/idle/special/000_stand_up_from_") +
                         (down == 'b' ? "back" : "front"),
                     false);
    if (!clip) return base::fail(clip.error());
    (down == 'b' ? library.rise_back_ : library.rise_front_) = std::move(*clip);
  }
  const auto ready = read("templates/idleD000", true);
  if (!ready) return base::fail(ready.error());
  library.ready_ = ready->at(0);
  library.ready_.lift = 0;
  // At ease: nearly straight, arms hanging.
  Pose ease;
  const auto set = [&](Node n, const Q& q) { ease.node[static_cast<std::size_t>(n)] = q; };
  for (int side = 0; side < 2; ++side) {
    const float out = side == 0 ? 1.0F : -1.0F;
    set(side == 0 ? Node::kLeftShoulder : Node::kRightShoulder,
        about_x(0.05F) * about_y(-out * 0.17F) * about_z(-out * 0.2F));
    set(side == 0 ? Node::kLeftElbow : Node::kRightElbow, about_x(-0.25F));
    set(side == 0 ? Node::kLeftThigh : Node::kRightThigh,
        about_x(-0.06F) * about_y(-out * 0.09F) * about_z(out * 0.2F));
    set(side == 0 ? Node::kLeftKnee : Node::kRightKnee, about_x(0.10F));
    set(side == 0 ? Node::kLeftAnkle : Node::kRightAnkle, about_x(-0.05F) * about_y(out * 0.09F));
  }
  set(Node::kMiddle, about_x(0.03F));
  library.ease_ = ease;
  return library;
}

Pose ClipLibrary::stand(float ready) const { return blend(ease_, ready_, ready); }

Pose ClipLibrary::Cycle::at(double step) const {
  const double whole = std::floor(step);
  const double u = step - whole;
  const bool is_odd = std::fmod(std::abs(whole), 2.0) > 0.5;
  const bool two = odd.frames() > 0;
  const auto half = [&](bool second, double at) {
    if (!second) return even.at(at * even.seconds());
    return mirrored(two ? odd.at(at * odd.seconds()) : even.at(at * even.seconds()));
  };
  Pose pose = half(is_odd, u);
  // Two halves made on their own do not quite meet.
  if (two && u < 0.35) pose = blend(half(!is_odd, 1), pose, static_cast<float>(ramp(u, 0, 0.35)));
  // The body's turn away from where it goes is the plan's, not the clip's.
  pose.node[0] = Q(Eigen::AngleAxisf(travel, Vector3f::UnitZ())) * pose.node[0];
  pose.root.setZero();
  return pose;
}

Pose ClipLibrary::directed(const std::vector<Cycle>& cycles, double turn, double step) const {
  // Clips turn to one side; the other side is their mirror image half a cycle on.
  double t = std::remainder(turn, 2 * kPi);
  const double sign = cycles[1].travel >= 0 ? 1.0 : -1.0;
  const bool flip = t * sign < 0;
  t = std::abs(t);
  const double shifted = flip ? step + 1 : step;
  // Straight back is as far from one side as from the other.
  const double w = std::min(1.0, t / std::abs(cycles[1].travel)) * (1 - ramp(t, 1.8, 3.0));
  const Pose pose = blend(cycles[0].at(shifted), cycles[1].at(shifted), static_cast<float>(w));
  return flip ? mirrored(pose) : pose;
}

double ClipLibrary::step_length(double speed, double turn) {
  const double across = std::abs(std::sin(turn));
  const double shorter = 1 - 0.45 * across - 0.25 * ramp(-std::cos(turn), 0, 1);
  constexpr std::array<std::array<double, 2>, 6> kRows{
      {{0.0, 0.0}, {1.4, 0.64}, {2.8, 1.16}, {4.8, 1.26}, {7.0, 1.68}, {12.0, 2.1}}};
  for (std::size_t i = 1; i < kRows.size(); ++i) {
    if (speed <= kRows[i][0] || i + 1 == kRows.size()) {
      const double u = (speed - kRows[i - 1][0]) / (kRows[i][0] - kRows[i - 1][0]);
      return std::max(0.05, shorter * (kRows[i - 1][1] + u * (kRows[i][1] - kRows[i - 1][1])));
    }
  }
  return 1;
}

namespace {

// Legs that walk by reaching for the places where the feet stand: a foot on the turf moves back as
// fast as the body goes on, in whatever direction, so it does not slide. Both leg bones of the
// average body are taken as 0.44 m.
void place_feet(Pose& pose, double speed, double turn, double step, float ready, double spin) {
  constexpr float kBone = 0.44F;
  const auto at = [&](Node n) -> Q& { return pose.node[static_cast<std::size_t>(n)]; };
  const double stride = 2 * ClipLibrary::step_length(speed, turn) * std::min(1.0, speed / 0.05);
  const double ahead = std::cos(turn);
  const double across = std::abs(std::sin(turn));
  const double duty = 0.62 - 0.06 * std::min(2.5, speed) - 0.05 * across;
  const float lively = static_cast<float>(std::min(1.0, speed / 0.8 + std::abs(spin) / 3));
  const float height = lively * static_cast<float>(0.05 + 0.035 * std::min(3.0, speed));
  const float knees = 0.866F - 0.055F * ready - 0.022F * static_cast<float>(std::min(2.5, speed)) -
                      0.02F * static_cast<float>(across) * lively;
  for (int side = 0; side < 2; ++side) {
    const float out = side == 0 ? 1.0F : -1.0F;
    // Mid-stance of the left foot at even steps.
    double cycle = 0.5 * step + 0.5 * duty + 0.5 * side;
    cycle -= std::floor(cycle);
    double reach = 0;
    float lift = 0;
    float heel = 0;
    if (cycle < duty) {
      reach = stride * (0.5 * duty - cycle);
      heel = static_cast<float>(ramp(cycle / duty, 0.7, 1.0));
    } else {
      // Swing: leaves and lands at the speed of the turf.
      const double u = (cycle - duty) / (1 - duty);
      const double from = -0.5 * duty * stride;
      const double slope = -stride * (1 - duty);
      const double u2 = u * u;
      const double u3 = u2 * u;
      reach = (2 * u3 - 3 * u2 + 1) * from + (u3 - 2 * u2 + u) * slope - (3 * u2 - 2 * u3) * from +
              (u3 - u2) * slope;
      const double arc = std::sin(kPi * u);
      lift = height * static_cast<float>(arc * arc);
      heel = static_cast<float>(1 - ramp(u, 0.0, 0.55));
    }
    heel *= 0.5F * lively *
            static_cast<float>(std::clamp(speed / 1.5, 0.0, 1.0) * std::max(0.15, ahead));
    const float wide = 0.015F + 0.05F * ready + 0.03F * static_cast<float>(across);
    Vector3f ankle(out * wide + static_cast<float>(reach * std::sin(turn)),
                   -static_cast<float>(reach * ahead) + 0.02F, -knees + lift + 0.10F * heel);
    const Q body = at(Node::kBody);
    const Vector3f seen = body.conjugate() * ankle;
    const float length = std::min(seen.norm(), 1.99F * kBone);
    const float bend = 2 * std::acos(std::clamp(length / (2 * kBone), 0.0F, 1.0F));
    const float toe_out = out * (0.14F + 0.10F * ready);
    const Q thigh = Q::FromTwoVectors(Vector3f(0, 0, -1), seen.normalized()) *
                    about_z(0.6F * toe_out) * about_x(-0.5F * bend);
    const Q knee = about_x(bend);
    at(side == 0 ? Node::kLeftThigh : Node::kRightThigh) = thigh;
    at(side == 0 ? Node::kLeftKnee : Node::kRightKnee) = knee;
    at(side == 0 ? Node::kLeftAnkle : Node::kRightAnkle) =
        (body * thigh * knee).conjugate() * about_z(toe_out) * about_x(heel);
  }
  pose.lift = 0;
}

}  // namespace

Pose ClipLibrary::gait(double speed, double turn, double step, float ready, double spin) const {
  const double away = std::abs(std::remainder(turn, 2 * kPi));
  Pose pose;
  if (speed < 1.4) {
    pose = blend(stand(ready), walk(step), static_cast<float>(std::clamp(speed / 1.4, 0.0, 1.0)));
  } else if (speed < 2.8) {
    pose = blend(walk(step), directed(run_, turn, step), static_cast<float>((speed - 1.4) / 1.4));
  } else if (speed < 4.8) {
    pose = directed(run_, turn, step);
  } else {
    pose = blend(directed(run_, turn, step), sprint_.at(step),
                 static_cast<float>(std::min(1.0, (speed - 4.8) / 2.2)));
  }
  const double stepping = std::max(1 - ramp(speed, 1.7, 2.6), ramp(away, 0.25, 0.6));
  if (stepping <= 0) return pose;
  Pose placed = pose;
  place_feet(placed, speed, turn, step, ready, spin);
  return blend(pose, placed, static_cast<float>(stepping));
}

}  // namespace touchline::sim::people
