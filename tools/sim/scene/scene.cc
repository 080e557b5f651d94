#include "tools/sim/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <set>

#include "tools/sim/scene/keys_internal.h"

namespace touchline::sim::scene {

namespace {

pitch::PitchSizes read_sizes(config::Table& t, const pitch::PitchSizes& fallback) {
  pitch::PitchSizes sizes = fallback;
  const auto read = [&](const char* key, std::optional<double>& value) {
    if (const auto given = t.optional_number(key, {0, 200})) value = given;
  };
  read("length_m", sizes.length_m);
  read("width_m", sizes.width_m);
  read("in_goal_m", sizes.in_goal_m);
  read("crown_m", sizes.crown_m);
  read("line_m", sizes.line_m);
  return sizes;
}

std::set<std::string> people_of(const people::CastSpec& cast) {
  std::set<std::string> ids;
  for (const people::PersonSpec& person : cast.people) ids.insert(person.id);
  for (const people::GroupSpec& group : cast.groups) {
    for (int i = 1; i <= group.people; ++i) ids.insert(fmt::format("{}{}", group.prefix, i));
  }
  return ids;
}

}  // namespace

base::Status validate(const Scene& scene) {
  const auto refuse = [](std::string where, std::string what, std::string cure) {
    return base::fail(base::ErrorKind::kConfiguration, std::move(where), std::move(what),
                      std::move(cure));
  };
  if (scene.frames < 1 || scene.frames > 1000000) {
    return refuse("frames", fmt::format("{} is out of bounds", scene.frames),
                  "give a value from 1 to 1000000");
  }
  if (const auto pitch = pitch::make_pitch(scene.sport, scene.sizes); !pitch) {
    return base::fail(pitch.error());
  }
  if (scene.cameras.empty()) {
    return refuse("camera", "there is none", "add a [[camera]] or a [[rig]]");
  }
  if (scene.cameras.size() > 64) {
    return refuse("camera", fmt::format("{} cameras", scene.cameras.size()), "give at most 64");
  }
  const std::set<std::string> people = people_of(scene.cast);
  const auto exists = [&](const std::string& target) {
    return target == "ball" ? scene.cast.ball.path != people::BallPath::kNone
                            : people.contains(target);
  };
  std::set<std::string> ids;
  for (const camera::CameraSpec& camera : scene.cameras) {
    if (auto status = camera.validate(); !status) return status;
    if (!ids.insert(camera.id.value).second) {
      return refuse("camera." + camera.id.value, "this id is there twice", "rename one");
    }
    if (camera.motion.kind == camera::MotionKind::kFollow && !exists(camera.motion.target)) {
      return refuse("camera." + camera.id.value + ".motion.follow",
                    "'" + camera.motion.target + "' is nobody of the scene",
                    "give \"ball\" (with a [ball] table) or the id of a person");
    }
  }
  ids.clear();
  for (const camera::VirtualSpec& camera : scene.virtuals) {
    if (auto status = camera.validate(); !status) return status;
    if (!ids.insert(camera.id).second) {
      return refuse("virtual." + camera.id, "this id is there twice", "rename one");
    }
    for (const auto& [field, target] :
         {std::pair{"target", &camera.target}, std::pair{"person", &camera.person}}) {
      if (!target->empty() && !exists(*target)) {
        return refuse("virtual." + camera.id + "." + field,
                      "'" + *target + "' is nobody of the scene", "give the id of a person");
      }
    }
  }
  return {};
}

base::Result<Scene> load_scene(const std::filesystem::path& path) {
  // Through Document::load for its bounds on size and kind of the file.
  auto document = config::Document::load(path);
  if (!document) return base::fail(document.error());
  return read_scene(*document, path.string(), path.parent_path());
}

base::Result<Scene> parse_scene(std::string_view text, const std::string& file,
                                const std::filesystem::path& folder) {
  auto document = config::Document::parse(text, file);
  if (!document) return base::fail(document.error());
  return read_scene(*document, file, folder);
}

base::Result<Scene> read_scene(const config::Document& document, const std::string& file,
                               const std::filesystem::path& folder) {
  config::Table root = document.root();
  Scene scene;
  const auto version = root.required_integer("format_version");
  if (version != kSceneFormatVersion && root.has("format_version")) {
    root.reject("format_version", fmt::format("{} is not known", version),
                fmt::format("this program reads version {}", kSceneFormatVersion));
  }
  scene.name = root.text("name", scene.name);
  scene.sport = root.choice<pitch::Sport>(
      "sport", scene.sport,
      {{"soccer", pitch::Sport::kSoccer}, {"rugby", pitch::Sport::kRugbyUnion}});
  scene.seed = static_cast<std::uint64_t>(
      root.integer("seed", 1, {0, std::numeric_limits<std::int64_t>::max()}));
  scene.frames = root.integer("frames", scene.frames, {1, 1000000});
  if (const auto text = root.optional_text("frame_rate")) {
    const auto rate = base::parse_frame_rate(*text);
    if (rate && rate->hz() >= 1 && rate->hz() <= 1000) {
      scene.rate = *rate;
    } else {
      root.reject("frame_rate", rate ? "is out of bounds" : rate.error().what,
                  "give a fraction such as \"25/1\"");
    }
  }
  if (const auto text = root.optional_text("start_timecode")) {
    const auto start = base::parse_timecode(*text);
    if (start) {
      scene.start_timecode = *start;
    } else {
      root.reject("start_timecode", start.error().what, "give a timecode such as \"10:00:00:00\"");
    }
  }
  scene.exposure = root.number("exposure", scene.exposure, {0.01, 100});
  config::Table pitch_table = root.table("pitch");
  scene.sizes = read_sizes(pitch_table, {});
  const auto model = pitch::make_pitch(scene.sport, scene.sizes);
  if (!model) {
    note(pitch_table, base::fail(model.error()), "pitch.");
    if (auto status = document.finish(); !status) return base::fail(status.error());
    return base::fail(model.error());
  }
  config::Table stated = root.table("stated");
  if (stated.present()) {
    scene.stated = read_sizes(stated, {});
  } else {
    scene.stated.length_m = model->length_m;
    scene.stated.width_m = model->width_m;
    if (scene.sport == pitch::Sport::kRugbyUnion) scene.stated.in_goal_m = model->in_goal_m;
  }
  if (const auto said = pitch::make_pitch(scene.sport, scene.stated); !said) {
    note(stated, base::fail(said.error()), "pitch.");
  }
  config::Table truth = root.table("truth");
  scene.truth.mattes = truth.boolean("mattes", scene.truth.mattes);
  scene.truth.joints = truth.boolean("joints", scene.truth.joints);
  scene.truth.mesh_every =
      static_cast<int>(truth.integer("mesh_every", scene.truth.mesh_every, {0, 100000}));
  read_world(root, scene.world);
  read_people(root, folder, scene, model->length_m, model->width_m, scene.cast);
  read_cameras(root, scene, model->length_m, model->width_m);
  if (auto status = document.finish(); !status) return base::fail(status.error());
  check_people(root, scene.cast);
  if (auto status = document.finish(); !status) return base::fail(status.error());
  if (auto status = validate(scene); !status) {
    base::Error error = status.error();
    error.what = error.where + ": " + error.what;
    error.where = file;
    return base::fail(std::move(error));
  }
  return scene;
}

}  // namespace touchline::sim::scene
