// A simulated match as a short TOML file describes it (tools/sim/README.md has all keys).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/pitch/pitch_model.h"
#include "tools/sim/camera/camera_spec.h"
#include "tools/sim/people/cast_spec.h"
#include "tools/sim/world/world_spec.h"

namespace touchline::sim::scene {

inline constexpr int kSceneFormatVersion = 1;

// What is written under truth/ beside the tables of cameras and people.
struct TruthSpec {
  bool mattes = true;
  bool joints = true;
  int mesh_every = 10;  // frames; 0 = no meshes
};

struct Scene {
  std::string name = "scene";
  pitch::Sport sport = pitch::Sport::kSoccer;
  std::uint64_t seed = 1;
  std::int64_t frames = 50;
  base::FrameRate rate;
  base::Timecode start_timecode{10, 0, 0, 0, false};
  double exposure = 1.1;     // of every camera: light of 1 / exposure is white
  pitch::PitchSizes sizes;   // true ones; absent = the sport's default
  pitch::PitchSizes stated;  // what recording.toml says, which need not be true
  people::CastSpec cast;     // may be empty: nobody and no ball
  world::WorldSpec world;
  std::vector<camera::CameraSpec> cameras;
  std::vector<camera::VirtualSpec> virtuals;
  TruthSpec truth;

  double duration_s() const { return static_cast<double>(frames) * rate.period_s(); }
};

// Errors are of kind kConfiguration and name file:line, the key and what to do. Files a scene names
// (tracks) are relative to its own folder.
base::Result<Scene> load_scene(const std::filesystem::path& path);
// The same from text; `file` names it in errors, `folder` is where its files lie.
base::Result<Scene> parse_scene(std::string_view text, const std::string& file,
                                const std::filesystem::path& folder);

// Everybody's and everything's id once, targets that exist, sizes that make a pitch.
base::Status validate(const Scene& scene);

}  // namespace touchline::sim::scene
