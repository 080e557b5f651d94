#include <algorithm>
#include <map>
#include <optional>

#include "tools/sim/output/match.h"
#include "tools/sim/people/cast.h"
#include "tools/sim/world/world.h"

namespace touchline::sim::output {

namespace {

class SimulatedMatch final : public Match {
 public:
  SimulatedMatch(pitch::PitchModel pitch, world::World world, std::unique_ptr<people::Cast> cast)
      : pitch_(std::move(pitch)),
        world_(std::move(world)),
        cast_(std::move(cast)),
        empty_(world_, nullptr),
        full_(world_, cast_.get()) {
    for (std::size_t i = 0; cast_ && i < cast_->people(); ++i) number_[cast_->body(i).id] = i;
  }

  const pitch::PitchModel& pitch() const override { return pitch_; }

  render::Picture picture(const render::Exposure& exposure, const render::RenderOptions& options,
                          bool with_people) const override {
    return (with_people ? full_ : empty_).render(exposure, options);
  }

  std::vector<PersonTruth> people(double time_s) const override {
    std::vector<PersonTruth> all;
    if (!cast_) return all;
    for (std::size_t i = 0; i < cast_->people(); ++i) {
      const people::Body& body = cast_->body(i);
      const people::Posture posture = cast_->posture(i, time_s);
      PersonTruth person{body.id, body.team, body.role, posture.ground, {}};
      if (person.role == "keeper") person.role = "goalkeeper";
      for (std::size_t j = 0; j < people::kJoints; ++j) {
        person.joints.emplace_back(people::name(static_cast<people::Joint>(j)), posture.joints[j]);
      }
      all.push_back(std::move(person));
    }
    if (const auto ball = ball_at(time_s)) all.push_back({"ball", "", "ball", *ball, {}});
    return all;
  }

  geometry::Mesh mesh(double time_s) const override {
    return cast_ ? render::mesh_of(*cast_, time_s) : geometry::Mesh{};
  }

  Eigen::Vector3d target(const std::string& id, double time_s) const override {
    if (id == "ball") return ball_at(time_s).value_or(Eigen::Vector3d::Zero());
    const auto found = number_.find(id);
    if (found == number_.end()) return Eigen::Vector3d::Zero();
    return cast_->posture(found->second, time_s).ground;
  }

 private:
  std::optional<Eigen::Vector3d> ball_at(double time_s) const {
    if (!cast_ || !cast_->has_ball()) return std::nullopt;
    const people::BallState ball = cast_->ball(time_s);
    if (!ball.present) return std::nullopt;
    return ball.centre;
  }

  pitch::PitchModel pitch_;
  world::World world_;
  std::unique_ptr<people::Cast> cast_;
  render::Renderer empty_, full_;
  std::map<std::string, std::size_t> number_;
};

}  // namespace

base::Result<std::unique_ptr<Match>> simulated_match(const scene::Scene& scene,
                                                     const std::filesystem::path& assets) {
  auto pitch = pitch::make_pitch(scene.sport, scene.sizes);
  if (!pitch) return base::fail(pitch.error());
  auto world = world::World::create(scene.world, *pitch, scene.seed);
  if (!world) return base::fail(world.error());
  std::unique_ptr<people::Cast> cast;
  if (!scene.cast.people.empty() || !scene.cast.groups.empty()) {
    people::CastSpec spec = scene.cast;
    spec.duration_s = std::max(spec.duration_s, std::min(1200.0, scene.duration_s()));
    auto made = people::Cast::create(spec, *pitch, scene.seed, assets);
    if (!made) return base::fail(made.error());
    cast = std::make_unique<people::Cast>(std::move(*made));
  }
  return std::unique_ptr<Match>(
      new SimulatedMatch(std::move(*pitch), std::move(*world), std::move(cast)));
}

}  // namespace touchline::sim::output
