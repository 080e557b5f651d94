#include "tools/sim/people/cast.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "tools/sim/people/ball.h"
#include "tools/sim/people/figure.h"
#include "tools/sim/people/gait.h"
#include "tools/sim/people/group.h"
#include "tools/sim/people/motion.h"
#include "tools/sim/people/paint.h"
#include "tools/sim/people/random.h"

namespace touchline::sim::people {
namespace {

constexpr std::size_t kTriangles = 11000;
constexpr double kMargin = 2;  // planned before the first and after the last frame, s
constexpr std::array<std::string_view, kJoints> kJointNames{
    "lshoulder", "lelbow", "lwrist", "lhip",  "lknee",  "lankle", "rshoulder",
    "relbow",    "rwrist", "rhip",   "rknee", "rankle", "head",   "pelvis"};

Colour mixed(const Colour& a, const Colour& b, double u) {
  return {(1 - u) * a[0] + u * b[0], (1 - u) * a[1] + u * b[1], (1 - u) * a[2] + u * b[2]};
}

struct Appearance {
  ShapeSpec shape;
  Looks looks;
};

Appearance appearance(const PersonSpec& p, const CastSpec& cast, std::uint64_t seed) {
  const Stream random(seed, "looks " + p.id);
  Appearance out;
  out.shape.height_m = p.height_m.value_or(std::clamp(
      1.81 + 0.06 * random.normal(0) + (p.role == Role::kKeeper ? 0.06 : 0.0), 1.66, 1.99));
  out.shape.muscle = p.muscle.value_or(random.uniform(1, 0.25, 0.9));
  out.shape.weight =
      p.weight.value_or(random.uniform(2, -0.5, p.role == Role::kReferee ? 0.3 : 0.15));
  const double dark = random.uniform(3);
  out.shape.african = std::clamp(1.6 * dark - 0.4, 0.0, 1.0);
  out.looks.skin =
      p.skin.value_or(mixed({0.56, 0.36, 0.27}, {0.085, 0.045, 0.028}, std::pow(dark, 0.8)));
  static constexpr std::array<Colour, 6> kHairColours{{{0.012, 0.010, 0.009},
                                                       {0.025, 0.016, 0.011},
                                                       {0.06, 0.033, 0.017},
                                                       {0.14, 0.08, 0.035},
                                                       {0.33, 0.22, 0.09},
                                                       {0.2, 0.06, 0.02}}};
  const auto shade =
      static_cast<std::size_t>(dark > 0.5 ? 2 * random.uniform(4) : 6 * random.uniform(4));
  out.looks.hair = p.hair_colour.value_or(kHairColours[std::min<std::size_t>(shade, 5)]);
  static constexpr std::array<HairStyle, 8> kStyles{
      HairStyle::kBald,  HairStyle::kShaved, HairStyle::kShaved, HairStyle::kShort,
      HairStyle::kShort, HairStyle::kShort,  HairStyle::kFull,   HairStyle::kLong};
  out.looks.outfit.hair = p.hair.value_or(
      kStyles[std::min<std::size_t>(7, static_cast<std::size_t>(8 * random.uniform(5)))]);
  static constexpr std::array<Colour, 6> kBoots{{{0.02, 0.02, 0.02},
                                                 {0.7, 0.7, 0.7},
                                                 {0.7, 0.25, 0.03},
                                                 {0.55, 0.65, 0.05},
                                                 {0.6, 0.05, 0.2},
                                                 {0.03, 0.2, 0.55}}};
  out.looks.boots =
      p.role == Role::kReferee
          ? kBoots[0]
          : kBoots[std::min<std::size_t>(5, static_cast<std::size_t>(6 * random.uniform(6)))];
  for (const auto& kit : cast.kits) {
    if (kit.team == p.team) out.looks.kit = p.role == Role::kKeeper ? kit.keeper : kit.kit;
  }
  out.looks.number = p.number;
  out.looks.outfit.long_sleeves = p.role == Role::kKeeper || random.uniform(7) < 0.1;
  out.looks.outfit.gloves = p.role == Role::kKeeper;
  out.looks.grain = random.bits(8);
  return out;
}

}  // namespace

std::string_view name(Joint joint) { return kJointNames[static_cast<std::size_t>(joint)]; }

struct Cast::State {
  struct Person {
    Body body;
    Figure figure;
    Motion motion;
  };
  std::shared_ptr<const Human> human;
  ClipLibrary clips;
  pitch::PitchModel pitch;
  std::vector<Person> people;
  bool has_ball = false;
  double radius = 0.11;
  BallMesh ball_mesh;
  std::unique_ptr<BallMotion> ball;
};

Cast::Cast(std::unique_ptr<const State> state) : state_(std::move(state)) {}
Cast::Cast(Cast&&) noexcept = default;
Cast& Cast::operator=(Cast&&) noexcept = default;
Cast::~Cast() = default;

base::Result<Cast> Cast::create(const CastSpec& spec, const pitch::PitchModel& pitch,
                                std::uint64_t seed, const std::filesystem::path& assets) {
  if (auto status = validate(spec); !status) return base::fail(status.error());
  auto state = std::make_unique<State>();
  state->pitch = pitch;
  auto human = Human::load(assets, kTriangles);
  if (!human) return base::fail(human.error());
  state->human = std::make_shared<const Human>(std::move(*human));
  auto clips = ClipLibrary::load(assets, *state->human);
  if (!clips) return base::fail(clips.error());
  state->clips = std::move(*clips);

  std::vector<GroupMember> members;
  for (const PersonSpec& p : spec.people) members.push_back({p, Hold::kNone});
  for (const GroupSpec& g : spec.groups) {
    for (auto& m : members_of(g, spec.duration_s, seed)) members.push_back(std::move(m));
  }
  const double from = -kMargin;
  const double to = spec.duration_s + kMargin;
  std::vector<PlacePath> paths;
  std::vector<Appearance> looks;
  for (const GroupMember& m : members) {
    auto path = plan_path(m.person, from, to, seed);
    if (!path) return base::fail(path.error());
    paths.push_back(std::move(*path));
    looks.push_back(appearance(m.person, spec, seed));
  }
  const auto plan = [&](std::size_t i, const BallPlace& ball) {
    Motion::Input input;
    input.spec = &members[i].person;
    input.clips = &state->clips;
    input.path = paths[i];
    input.ball = ball;
    input.scale = looks[i].shape.height_m / 1.8;
    input.seed = seed;
    input.hold = members[i].hold;
    return Motion(std::move(input));
  };
  // Whoever dribbles is planned before the ball, the others after it.
  state->has_ball = spec.ball.path != BallPath::kNone;
  std::unique_ptr<Motion> carrier;
  std::size_t carrier_index = members.size();
  if (spec.ball.path == BallPath::kDribbled) {
    for (std::size_t i = 0; i < members.size(); ++i) {
      if (members[i].person.id == spec.ball.carrier) carrier_index = i;
    }
    carrier = std::make_unique<Motion>(plan(carrier_index, {}));
  }
  BallPlace ball_place = [](double) { return Eigen::Vector2d(Eigen::Vector2d::Zero()); };
  if (state->has_ball) {
    const double reach = carrier ? looks[carrier_index].shape.height_m / 1.8 : 1;
    const auto carried = [&](double t) { return Eigen::Vector2d(carrier->dribbled(t, reach)); };
    state->radius = spec.ball.radius_m;
    state->ball_mesh = make_ball(spec.ball);
    state->ball =
        std::make_unique<BallMotion>(spec.ball, pitch, from, to,
                                     carrier ? std::function<Eigen::Vector2d(double)>(carried)
                                             : std::function<Eigen::Vector2d(double)>());
    ball_place = [ball = state->ball.get()](double t) {
      return Eigen::Vector2d(ball->at(t).centre.head<2>());
    };
  }
  for (std::size_t i = 0; i < members.size(); ++i) {
    const PersonSpec& p = members[i].person;
    Body body;
    body.id = p.id;
    body.team = p.team;
    body.role = name(p.role);
    body.vertices = state->human->canonical.size();
    body.triangles = state->human->triangles;
    body.paint = person_paint(state->human, looks[i].looks);
    state->people.push_back({std::move(body),
                             Figure(*state->human, looks[i].shape, looks[i].looks.outfit),
                             i == carrier_index ? *carrier : plan(i, ball_place)});
  }
  return Cast(std::move(state));
}

std::size_t Cast::people() const { return state_->people.size(); }
const Body& Cast::body(std::size_t person) const { return state_->people[person].body; }

Posture Cast::posture(std::size_t person, double time_s) const {
  const State::Person& p = state_->people[person];
  const Stance stance = p.motion.at(time_s);
  const auto motions = p.figure.rig().motions(stance.pose);
  Posture out;
  out.ground = state_->pitch.on_turf(stance.place);
  // The lowest point of whatever touches is on the turf, or as high as the jump is.
  const float low = p.figure.lowest(*state_->human, motions);
  const Eigen::Vector3f pelvis(
      static_cast<float>(stance.place.x()), static_cast<float>(stance.place.y()),
      static_cast<float>(out.ground.z()) - low + p.figure.scale() * stance.pose.lift);
  const Eigen::Matrix3f heading =
      Eigen::AngleAxisf(static_cast<float>(stance.facing + std::numbers::pi / 2),
                        Eigen::Vector3f::UnitZ())
          .toRotationMatrix();
  p.figure.skin_all(*state_->human, motions, pelvis, heading, out.positions, out.normals);
  const auto at = [&](Bone bone, const Eigen::Vector3f& beyond) {
    const BoneMotion& m = motions[index(bone)];
    return Eigen::Vector3d((heading * (m.place + m.turn * beyond) + pelvis).cast<double>());
  };
  constexpr std::array<Bone, 12> kLimbs{
      Bone::kLeftUpperArm1, Bone::kLeftForearm1, Bone::kLeftHand,       Bone::kLeftThigh1,
      Bone::kLeftShin,      Bone::kLeftFoot,     Bone::kRightUpperArm1, Bone::kRightForearm1,
      Bone::kRightHand,     Bone::kRightThigh1,  Bone::kRightShin,      Bone::kRightFoot};
  for (std::size_t j = 0; j < kLimbs.size(); ++j)
    out.joints[j] = at(kLimbs[j], Eigen::Vector3f::Zero());
  out.joints[static_cast<std::size_t>(Joint::kHead)] =
      at(Bone::kHead, p.figure.scale() * Eigen::Vector3f(0, -0.02F, 0.08F));
  out.joints[static_cast<std::size_t>(Joint::kPelvis)] = at(Bone::kPelvis, Eigen::Vector3f::Zero());
  return out;
}

bool Cast::has_ball() const { return state_->has_ball; }
const Body& Cast::ball_body() const { return state_->ball_mesh.body; }

BallState Cast::ball(double time_s) const {
  BallState out;
  if (!state_->has_ball) return out;
  const BallMotion::State s = state_->ball->at(time_s);
  out.present = true;
  out.centre = s.centre;
  out.rotation = s.rotation;
  out.radius = state_->radius;
  return out;
}

Posture Cast::ball_posture(double time_s) const {
  Posture out;
  if (!state_->has_ball) return out;
  const BallMotion::State s = state_->ball->at(time_s);
  const Eigen::Matrix3f turn = s.rotation.toRotationMatrix().cast<float>();
  const Eigen::Vector3f centre = s.centre.cast<float>();
  for (const Eigen::Vector3f& v : state_->ball_mesh.vertices) {
    out.positions.push_back(turn * v + centre);
    out.normals.push_back((turn * v).normalized());
  }
  out.ground = state_->pitch.on_turf(s.centre.head<2>());
  return out;
}

}  // namespace touchline::sim::people
