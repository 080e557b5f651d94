#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "tools/sim/scene/keys_internal.h"

namespace touchline::sim::scene {

namespace {

using camera::CameraSpec;
using camera::Role;
using camera::Side;

std::pair<int, int> size(config::Table& t, int width, int height) {
  const Eigen::Vector2d made = pair(t, "size", {width, height});
  if (made.x() < 64 || made.y() < 64 || made.x() > 8192 || made.y() > 8192) {
    t.reject("size", fmt::format("{} by {} is out of bounds", made.x(), made.y()),
             "give 64 to 8192 pixels");
    return {width, height};
  }
  return {static_cast<int>(made.x()), static_cast<int>(made.y())};
}

void read_lens(config::Table t, camera::LensSpec& s) {
  s.wide_mm = t.number("wide_mm", s.wide_mm);
  s.tele_mm = t.number("tele_mm", s.tele_mm);
  s.corner_wide = t.number("corner_wide", s.corner_wide);
  s.corner_tele = t.number("corner_tele", s.corner_tele);
  s.fourth_share = t.number("fourth_share", s.fourth_share);
  s.centre_px = pair(t, "centre_px", s.centre_px);
  s.pupil_wide_m = t.number("pupil_wide_m", s.pupil_wide_m);
  s.pupil_tele_m = t.number("pupil_tele_m", s.pupil_tele_m);
  note(t, s.validate());
}

void read_motion(config::Table t, camera::MotionSpec& s) {
  using camera::MotionKind;
  s.focal_mm = t.optional_number("focal_mm");
  s.view_m = t.number("view_m", s.view_m);
  if (t.has("aim") && t.has("follow")) {
    t.reject("aim", "a camera either follows or has a fixed aim", "take one of the two out");
  }
  if (t.has("aim")) s.kind = MotionKind::kFixed;
  s.aim = triple(t, "aim", s.aim);
  if (const auto target = t.optional_text("follow")) {
    s.kind = MotionKind::kFollow;
    s.target = *target;
  }
  for (config::Table k : t.tables("key")) {
    s.kind = MotionKind::kKeys;
    camera::MotionKey key;
    key.time_s = k.required_number("time_s");
    key.aim = triple(k, "aim", key.aim);
    key.focal_mm = k.optional_number("focal_mm");
    key.view_m = k.optional_number("view_m");
    s.keys.push_back(key);
  }
  s.aim_height_m = t.number("aim_height_m", s.aim_height_m);
  s.delay_s = t.number("delay_s", s.delay_s);
  s.response_hz = t.number("response_hz", s.response_hz);
  s.damping = t.number("damping", s.damping);
  s.zoom_response_hz = t.number("zoom_response_hz", s.zoom_response_hz);
  s.wander_deg = t.number("wander_deg", s.wander_deg);
  s.jitter_deg = t.number("jitter_deg", s.jitter_deg);
  s.most_speed_deg = t.number("most_speed_deg", s.most_speed_deg);
  s.most_accel_deg = t.number("most_accel_deg", s.most_accel_deg);
  note(t, s.validate());
}

void read_sensor(config::Table t, camera::SensorSpec& s) {
  s.exposure_stops = t.number("exposure_stops", s.exposure_stops);
  s.gain = triple(t, "gain", s.gain);
  s.knee = t.number("knee", s.knee);
  s.knee_slope = t.number("knee_slope", s.knee_slope);
  s.read_noise = t.number("read_noise", s.read_noise);
  s.shot_noise = t.number("shot_noise", s.shot_noise);
  s.softness_px = t.number("softness_px", s.softness_px);
  config::Table d = t.table("detail");
  s.detail.level = d.number("level", s.detail.level);
  s.detail.frequency = d.number("frequency", s.detail.frequency);
  s.detail.v_level = d.number("v_level", s.detail.v_level);
  s.detail.coring = d.number("coring", s.detail.coring);
  s.detail.clip = d.number("clip", s.detail.clip);
  note(d, s.detail.validate());
  note(t, s.validate());
}

void read_video(config::Table t, camera::VideoSpec& s) {
  using camera::Codec;
  using camera::Sampling;
  s.codec = t.choice<Codec>(
      "codec", s.codec,
      {{"h264", Codec::kH264}, {"ffvhuff", Codec::kFfvhuff}, {"ffv1", Codec::kFfv1}});
  s.quality = static_cast<int>(t.integer("quality", s.quality, {0, 40}));
  s.bits = static_cast<int>(t.integer("bits", s.bits, {8, 10}));
  s.sampling = t.choice<Sampling>("sampling", s.sampling,
                                  {{"422", Sampling::k422}, {"420", Sampling::k420}});
  note(t, s.validate());
}

std::vector<std::int64_t> frames(config::Table& t, std::string_view key) {
  std::vector<std::int64_t> made;
  for (const double v : t.numbers(key, {}, {0, 1e9})) {
    if (v != std::floor(v)) t.reject(key, fmt::format("{} is no frame", v), "give whole numbers");
    made.push_back(static_cast<std::int64_t>(v));
  }
  return made;
}

void read_timing(config::Table& t, camera::TimingSpec& s) {
  if (const auto text = t.optional_text("frame_rate")) {
    if (const auto rate = base::parse_frame_rate(*text)) {
      s.rate = *rate;
    } else {
      t.reject("frame_rate", rate.error().what, "give a fraction such as \"50/1\"");
    }
  }
  s.scan = t.choice<image::Scan>("scan", s.scan,
                                 {{"progressive", image::Scan::kProgressive},
                                  {"tff", image::Scan::kTopFirst},
                                  {"bff", image::Scan::kBottomFirst}});
  s.shutter = t.number("shutter", s.shutter);
  s.offset_ms = t.number("offset_ms", s.offset_ms);
  s.offset_stated = t.boolean("offset_stated", s.offset_stated);
  if (t.has("drop")) s.drop = frames(t, "drop");
  if (t.has("repeat")) s.repeat = frames(t, "repeat");
  s.drop_share = t.number("drop_share", s.drop_share);
  s.repeat_share = t.number("repeat_share", s.repeat_share);
  s.jitter_us = t.number("jitter_us", s.jitter_us);
  note(t, s.validate());
}

void read_head(config::Table t, camera::HeadSpec& s) {
  if (t.present()) s.encoders = true;
  s.encoders = t.boolean("encoders", s.encoders);
  s.counts_per_deg = t.number("counts_per_deg", s.counts_per_deg);
  s.backlash_deg = t.number("backlash_deg", s.backlash_deg);
  s.zoom_counts = t.number("zoom_counts", s.zoom_counts);
  s.focus_counts = t.number("focus_counts", s.focus_counts);
  note(t, s.validate());
}

// All keys but id, position and side, which one camera and a rig give in their own ways.
CameraSpec read_common(config::Table& t, int width, int height) {
  const auto role = t.choice<Role>(
      "role", Role::kMatch,
      {{"match", Role::kMatch}, {"fixed", Role::kFixed}, {"closeup", Role::kCloseup}});
  CameraSpec spec = camera::usual(role);
  std::tie(spec.width, spec.height) = size(t, width, height);
  spec.mount.level_deg = pair(t, "level_deg", spec.mount.level_deg);
  spec.mount.roll_deg = t.number("roll_deg", spec.mount.roll_deg);
  spec.mount.sway_m = t.number("sway_m", spec.mount.sway_m);
  spec.mount.sway_deg = t.number("sway_deg", spec.mount.sway_deg);
  spec.mount.sway_hz = t.number("sway_hz", spec.mount.sway_hz);
  note(t, spec.mount.validate());
  read_lens(t.table("lens"), spec.lens);
  read_motion(t.table("motion"), spec.motion);
  if (spec.motion.kind == camera::MotionKind::kFollow && role == Role::kFixed) {
    t.reject("role", "a fixed camera does not follow", "give motion an aim, or another role");
  }
  read_sensor(t.table("sensor"), spec.sensor);
  read_video(t.table("video"), spec.video);
  read_timing(t, spec.timing);
  read_head(t.table("head"), spec.head);
  spec.survey_stills = static_cast<int>(t.integer("survey_stills", spec.survey_stills, {0, 40}));
  spec.survey_view_m = pair(t, "survey_view_m", spec.survey_view_m);
  spec.vary = t.number("vary", spec.vary);
  return spec;
}

Side read_side(config::Table& t, Side fallback) {
  return t.choice<Side>("side", fallback,
                        {{"main", Side::kMain},
                         {"reverse", Side::kReverse},
                         {"left", Side::kLeft},
                         {"right", Side::kRight}});
}

void read_virtual(config::Table& t, std::size_t number, camera::VirtualSpec& s) {
  using camera::PathKind;
  s.id = t.text("id", fmt::format("virtual{:02}", number));
  s.kind = t.choice<PathKind>("path", s.kind,
                              {{"fixed", PathKind::kFixed},
                               {"orbit", PathKind::kOrbit},
                               {"referee", PathKind::kReferee},
                               {"goalkeeper", PathKind::kGoalkeeper},
                               {"offside", PathKind::kOffside}});
  std::tie(s.width, s.height) = size(t, s.width, s.height);
  s.focal_px = t.number("focal_px", s.focal_px);
  s.position = triple(t, "position", s.position);
  s.aim = triple(t, "aim", s.aim);
  s.target = t.text("target", s.target);
  s.person = t.text("person", s.person);
  s.radius_m = t.number("radius_m", s.radius_m);
  s.height_m = t.number("height_m", s.height_m);
  s.start_deg = t.number("start_deg", s.start_deg);
  s.deg_per_s = t.number("deg_per_s", s.deg_per_s);
  s.eye_m = t.number("eye_m", s.eye_m);
  s.ahead_m = t.number("ahead_m", s.ahead_m);
  s.smooth_s = t.number("smooth_s", s.smooth_s);
  s.clean_every = static_cast<int>(t.integer("clean_every", s.clean_every, {0, 1000}));
  s.matte_every = static_cast<int>(t.integer("matte_every", s.matte_every, {0, 1000}));
  note(t, s.validate(), "virtual." + s.id + ".");
}

}  // namespace

void read_cameras(config::Table& root, Scene& scene, double length_m, double width_m) {
  const auto [width, height] = size(root, 1920, 1080);
  for (config::Table t : root.tables("camera")) {
    CameraSpec spec = read_common(t, width, height);
    spec.id.value = t.required_text("id");
    if (!t.has("position")) t.required_text("position");
    spec.mount.position = triple(t, "position", spec.mount.position);
    spec.side = read_side(t, camera::side_of(spec.mount.position, length_m, width_m));
    note(t, spec.validate(), "camera." + spec.id.value + ".");
    scene.cameras.push_back(std::move(spec));
  }
  for (config::Table t : root.tables("rig")) {
    CameraSpec spec = read_common(t, width, height);
    const std::string prefix = t.text("prefix", "r");
    const auto count = t.integer("count", 8, {1, 64});
    const double from = t.number("from_deg", 0, {-720, 720});
    const double to = t.number("to_deg", 360, {-720, 720});
    const double margin = t.number("margin_m", 25, {2, 200});
    const double least = t.number("height_m", 12, {0.5, 100});
    for (std::int64_t i = 0; i < count; ++i) {
      const double angle =
          (from + (to - from) * (static_cast<double>(i) + 0.5) / static_cast<double>(count)) *
          std::numbers::pi / 180;
      CameraSpec one = spec;
      one.id.value = fmt::format("{}{}", prefix, i + 1);
      // Every other one stands higher.
      one.mount.position = {(length_m / 2 + margin) * std::cos(angle),
                            (width_m / 2 + margin) * std::sin(angle),
                            least * (i % 2 == 0 ? 1.0 : 1.4)};
      one.side = camera::side_of(one.mount.position, length_m, width_m);
      if (i == 0) note(t, one.validate(), "camera." + one.id.value + ".");
      scene.cameras.push_back(std::move(one));
    }
  }
  std::size_t number = 0;
  for (config::Table t : root.tables("virtual")) {
    camera::VirtualSpec spec;
    read_virtual(t, ++number, spec);
    scene.virtuals.push_back(std::move(spec));
  }
}

}  // namespace touchline::sim::scene
