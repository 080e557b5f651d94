#include "tools/sim/camera/camera_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tools/sim/camera/random.h"

namespace touchline::sim::camera {
namespace {

base::Status refuse(std::string_view field, std::string what, std::string cure) {
  return base::fail(base::ErrorKind::kConfiguration, std::string(field), std::move(what),
                    std::move(cure));
}

struct Check {
  std::string_view field;
  double value;
  double least;
  double most;
};

base::Status all(std::initializer_list<Check> checks) {
  for (const Check& c : checks) {
    if (!(c.value >= c.least && c.value <= c.most)) {
      return refuse(c.field, fmt::format("{} is out of bounds", c.value),
                    fmt::format("give a value from {} to {}", c.least, c.most));
    }
  }
  return {};
}

template <typename V>
base::Status finite(std::string_view field, const V& v, double most) {
  if (v.array().isFinite().all() && (v.array().abs() <= most).all()) return {};
  return refuse(field, "lies too far out", fmt::format("give metres within {} of the pitch", most));
}

base::Status within(std::string_view part, base::Status status) {
  if (status) return status;
  base::Error error = status.error();
  error.where = std::string(part) + "." + error.where;
  return base::fail(std::move(error));
}

}  // namespace

base::Status LensSpec::validate() const {
  if (auto s = all({{"wide_mm", wide_mm, 3, 3000},
                    {"tele_mm", tele_mm, 3, 3000},
                    {"corner_wide", corner_wide, -0.08, 0.08},
                    {"corner_tele", corner_tele, -0.08, 0.08},
                    {"fourth_share", fourth_share, -0.5, 0.5},
                    {"centre_px", centre_px.x(), -40, 40},
                    {"centre_px", centre_px.y(), -40, 40},
                    {"pupil_wide_m", pupil_wide_m, -0.5, 0.5},
                    {"pupil_tele_m", pupil_tele_m, -0.5, 0.5}});
      !s) {
    return s;
  }
  if (tele_mm < wide_mm) {
    return refuse("tele_mm", fmt::format("{} is less than wide_mm, {}", tele_mm, wide_mm),
                  "give tele_mm of at least wide_mm");
  }
  return {};
}

base::Status MotionSpec::validate() const {
  if (auto s = all({{"aim_height_m", aim_height_m, 0, 3},
                    {"focal_mm", focal_mm.value_or(10), 3, 3000},
                    {"view_m", view_m, 0.5, 300},
                    {"delay_s", delay_s, 0, 2},
                    {"response_hz", response_hz, 0.05, 5},
                    {"damping", damping, 0.2, 2},
                    {"zoom_response_hz", zoom_response_hz, 0.05, 5},
                    {"wander_deg", wander_deg, 0, 5},
                    {"jitter_deg", jitter_deg, 0, 0.2},
                    {"most_speed_deg", most_speed_deg, 1, 360},
                    {"most_accel_deg", most_accel_deg, 10, 2000}});
      !s) {
    return s;
  }
  if (auto s = finite("aim", aim, 1000); !s) return s;
  if (kind == MotionKind::kFollow && target.empty()) {
    return refuse("target", "is empty", "give \"ball\" or the id of a person");
  }
  if (kind == MotionKind::kKeys && keys.empty()) {
    return refuse("key", "there is none", "give at least one [[camera.motion.key]]");
  }
  double last = -1e9;
  for (const MotionKey& key : keys) {
    if (!(key.time_s > last)) {
      return refuse("key", fmt::format("time_s {} does not rise", key.time_s),
                    "give the keys by rising time");
    }
    last = key.time_s;
    if (auto s = finite("key", key.aim, 1000); !s) return s;
    if (auto s = all({{"key", key.focal_mm.value_or(10), 3, 3000},
                      {"key", key.view_m.value_or(10), 0.5, 300}});
        !s) {
      return s;
    }
  }
  return {};
}

base::Status MountSpec::validate() const {
  if (auto s = finite("position", position, 400); !s) return s;
  return all({{"level_deg", level_deg.x(), -5, 5},
              {"level_deg", level_deg.y(), -5, 5},
              {"roll_deg", roll_deg, -10, 10},
              {"sway_m", sway_m, 0, 0.1},
              {"sway_deg", sway_deg, 0, 0.5},
              {"sway_hz", sway_hz, 0.3, 2}});
}

base::Status HeadSpec::validate() const {
  return all({{"counts_per_deg", counts_per_deg, 1, 1e6},
              {"backlash_deg", backlash_deg, 0, 0.5},
              {"zoom_counts", zoom_counts, 16, 1e7},
              {"focus_counts", focus_counts, 16, 1e7}});
}

base::Status DetailSpec::validate() const {
  return all({{"level", level, 0, 1.5},
              {"frequency", frequency, 0.26, 0.5},
              {"v_level", v_level, 0, 2},
              {"coring", coring, 0, 0.1},
              {"clip", clip, 0.01, 1}});
}

base::Status SensorSpec::validate() const {
  if (auto s = all({{"exposure_stops", exposure_stops, -4, 4},
                    {"gain", gain.x(), 0.5, 2},
                    {"gain", gain.y(), 0.5, 2},
                    {"gain", gain.z(), 0.5, 2},
                    {"knee", knee, 0.3, 1},
                    {"knee_slope", knee_slope, 0, 1},
                    {"read_noise", read_noise, 0, 0.1},
                    {"shot_noise", shot_noise, 0, 0.2},
                    {"softness_px", softness_px, 0, 3}});
      !s) {
    return s;
  }
  return within("detail", detail.validate());
}

base::Status VideoSpec::validate() const {
  if (auto s = all({{"quality", static_cast<double>(quality), 0, 40}}); !s) return s;
  if (bits != 8 && bits != 10) {
    return refuse("bits", fmt::format("{} is not known", bits), "give 8 or 10");
  }
  return {};
}

base::Status TimingSpec::validate() const {
  if (auto s = all({{"shutter", shutter, 0, 1},
                    {"offset_ms", offset_ms, -1000, 1000},
                    {"drop_share", drop_share, 0, 0.5},
                    {"repeat_share", repeat_share, 0, 0.5},
                    {"jitter_us", jitter_us, 0, 10000}});
      !s) {
    return s;
  }
  if (rate && (rate->num < 1 || rate->den < 1 || rate->hz() > 1000 || rate->hz() < 1)) {
    return refuse("frame_rate", base::to_string(*rate) + " is out of bounds",
                  "give 1 to 1000 frames a second, such as \"50/1\"");
  }
  for (const auto& [field, list] : {std::pair{"drop", &drop}, std::pair{"repeat", &repeat}}) {
    for (const std::int64_t number : *list) {
      if (number < 0) return refuse(field, "a negative frame", "count frames from 0");
      if (number == 0 && field == std::string_view("repeat")) {
        return refuse(field, "frame 0 has none before it", "repeat later frames");
      }
    }
  }
  return {};
}

base::Status CameraSpec::validate() const {
  const std::string at = "camera." + id.value;
  if (!base::is_valid(id)) {
    return refuse(at + ".id", "'" + id.value + "' is no camera id",
                  "use 1 to 32 letters, digits, '-' and '_'");
  }
  if (id.value.starts_with("virtual") || id.value == "mesh") {
    return refuse(at + ".id", "'" + id.value + "' is taken by the truth", "use another id");
  }
  if (width < 64 || height < 64 || width > 8192 || height > 8192 || width % 4 != 0 ||
      height % 4 != 0) {
    return refuse(at + ".size", fmt::format("{}x{} cannot be recorded", width, height),
                  "give a width and height of 64 to 8192 pixels in steps of 4");
  }
  if (survey_stills != 0 && (survey_stills < 3 || survey_stills > 40)) {
    return refuse(at + ".survey_stills", fmt::format("{} is out of bounds", survey_stills),
                  "give 0 or a value from 3 to 40");
  }
  if (auto s = within(at, all({{"survey_view_m", survey_view_m.x(), 3, 300},
                               {"survey_view_m", survey_view_m.y(), 3, survey_view_m.x()},
                               {"vary", vary, 0, 2}}));
      !s) {
    return s;
  }
  if (auto s = within(at, mount.validate()); !s) return s;
  if (auto s = within(at + ".lens", lens.validate()); !s) return s;
  if (auto s = within(at + ".motion", motion.validate()); !s) return s;
  if (auto s = within(at + ".sensor", sensor.validate()); !s) return s;
  if (auto s = within(at + ".video", video.validate()); !s) return s;
  if (auto s = within(at + ".timing", timing.validate()); !s) return s;
  return within(at + ".head", head.validate());
}

base::Status VirtualSpec::validate() const {
  const std::string at = "virtual." + id;
  if (id.size() != 9 || !id.starts_with("virtual") || id[7] < '0' || id[7] > '9' || id[8] < '0' ||
      id[8] > '9') {
    return refuse(at + ".id", "'" + id + "' is no name of a virtual camera",
                  "use \"virtual01\" to \"virtual99\"");
  }
  if (width < 64 || height < 64 || width > 8192 || height > 8192) {
    return refuse(at + ".size", fmt::format("{}x{} is out of bounds", width, height),
                  "give 64 to 8192 pixels");
  }
  if (auto s = within(at, finite("position", position, 400)); !s) return s;
  if (auto s = within(at, finite("aim", aim, 400)); !s) return s;
  const bool eye =
      kind == PathKind::kReferee || kind == PathKind::kGoalkeeper || kind == PathKind::kOffside;
  if (eye && person.empty()) {
    return refuse(at + ".person", "is missing", "give the id of the person whose view this is");
  }
  return within(at, all({{"focal_px", focal_px, 100, 20000},
                         {"radius_m", radius_m, 0.5, 200},
                         {"height_m", height_m, 0.1, 100},
                         {"deg_per_s", deg_per_s, -360, 360},
                         {"start_deg", start_deg, -720, 720},
                         {"eye_m", eye_m, 0.1, 3},
                         {"ahead_m", ahead_m, 0, 3},
                         {"smooth_s", smooth_s, 0, 5},
                         {"clean_every", static_cast<double>(clean_every), 0, 1000},
                         {"matte_every", static_cast<double>(matte_every), 0, 1000}}));
}

CameraSpec resized(CameraSpec spec, int width, int height) {
  const double scale = static_cast<double>(width) / spec.width;
  spec.lens.centre_px *= scale;
  spec.sensor.softness_px *= scale;
  spec.width = width;
  spec.height = height;
  return spec;
}

CameraSpec varied(CameraSpec spec, std::uint64_t seed) {
  if (spec.vary <= 0) return spec;
  const Stream random = Stream(seed, "faults").sub(spec.id.value);
  const double v = spec.vary;
  std::uint64_t n = 0;
  const auto swing = [&](double most) { return v * random.uniform(n++, -most, most); };
  for (int i = 0; i < 3; ++i) spec.sensor.gain[i] *= 1 + swing(0.03);
  spec.sensor.exposure_stops += swing(0.08);
  spec.lens.centre_px.x() += swing(8) * spec.width / 1920;
  spec.lens.centre_px.y() += swing(8) * spec.width / 1920;
  spec.lens.corner_wide += swing(0.006);
  spec.lens.corner_tele += swing(0.002);
  spec.mount.level_deg.x() += swing(0.4);
  spec.mount.level_deg.y() += swing(0.4);
  spec.mount.roll_deg += swing(0.2);
  spec.sensor.detail.level += std::abs(swing(0.45));
  if (random.uniform(n++) < 0.4) spec.sensor.detail.frequency = random.uniform(n++, 0.3, 0.4);
  return spec;
}

CameraSpec usual(Role role) {
  CameraSpec spec;
  spec.role = role;
  switch (role) {
    case Role::kMatch:
      spec.lens.pupil_wide_m = 0.12;
      spec.lens.pupil_tele_m = 0.02;
      break;
    case Role::kFixed:
      spec.motion.kind = MotionKind::kFixed;
      spec.motion.view_m = 45;
      spec.survey_stills = 0;
      break;
    case Role::kCloseup:
      spec.lens.tele_mm = 800;
      spec.motion.view_m = 4.6;
      spec.motion.aim_height_m = 0.95;
      spec.motion.response_hz = 1.0;
      spec.motion.wander_deg = 0.05;
      spec.motion.jitter_deg = 0.001;
      spec.survey_stills = 0;
      break;
  }
  return spec;
}

Side side_of(const Eigen::Vector3d& position, double length_m, double width_m) {
  const double x = position.x() / length_m, y = position.y() / width_m;
  if (std::abs(y) >= std::abs(x)) return y < 0 ? Side::kMain : Side::kReverse;
  return x < 0 ? Side::kLeft : Side::kRight;
}

}  // namespace touchline::sim::camera
