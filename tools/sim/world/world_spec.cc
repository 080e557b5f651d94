#include "tools/sim/world/world_spec.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

namespace touchline::sim::world {
namespace {

// Notes the first value that lies outside its bounds.
class Checker {
 public:
  void number(const std::string& field, double value, double least, double most) {
    if (error_ || (value >= least && value <= most)) return;
    error_ = base::Error{base::ErrorKind::kConfiguration, "world." + field,
                         fmt::format("{} is outside {} to {}", value, least, most), ""};
  }
  void colour(const std::string& field, const Colour& value, double most = 1) {
    for (int i = 0; i < 3; ++i) number(field, static_cast<double>(value[i]), 0, most);
  }
  void refuse(const std::string& field, const std::string& what, const std::string& cure) {
    if (!error_)
      error_ = base::Error{base::ErrorKind::kConfiguration, "world." + field, what, cure};
  }
  base::Status status() const {
    if (error_) return base::fail(*error_);
    return {};
  }

 private:
  std::optional<base::Error> error_;
};

void check_stands(Checker& check, const StandsSpec& stands) {
  check.number("stands.near_side.rows", stands.near_side.rows, 4, 120);
  check.number("stands.far_side.rows", stands.far_side.rows, 4, 120);
  check.number("stands.left_side.rows", stands.left_side.rows, 4, 120);
  check.number("stands.right_side.rows", stands.right_side.rows, 4, 120);
  check.number("stands.distance_m", stands.distance_m, 5, 40);
  check.colour("stands.seat_albedo", stands.seat_albedo);
}

void check_clouds(Checker& check, const CloudSpec& clouds) {
  for (std::size_t i = 0; i < clouds.keys.size(); ++i) {
    const LightKey& key = clouds.keys[i];
    const std::string field = fmt::format("clouds.keys[{}]", i);
    check.number(field + ".time_s", key.time_s, -1e6, 1e6);
    check.number(field + ".sun", key.sun, 0, 1);
    check.number(field + ".all", key.all, 0.05, 2);
    if (i > 0 && !(key.time_s > clouds.keys[i - 1].time_s))
      check.refuse(field + ".time_s",
                   fmt::format("{} s does not follow {} s", key.time_s, clouds.keys[i - 1].time_s),
                   "order the keys by time");
  }
  check.number("clouds.drift", clouds.drift, 0, 1);
  check.number("clouds.drift_scale_m", clouds.drift_scale_m, 10, 1000);
  check.number("clouds.drift_x_m_s", clouds.drift_x_m_s, -50, 50);
  check.number("clouds.drift_y_m_s", clouds.drift_y_m_s, -50, 50);
}

}  // namespace

base::Status validate(const WorldSpec& spec) {
  Checker check;
  check.colour("turf.albedo", spec.turf.albedo);
  check.number("turf.stripe_m", spec.turf.stripe_m, 1, 30);
  check.number("turf.stripe_contrast", spec.turf.stripe_contrast, 0, 0.8);
  check.number("turf.texture", spec.turf.texture, 0, 3);
  check.number("turf.wear", spec.turf.wear, 0, 1);
  check.colour("lines.albedo", spec.lines.albedo);
  check.number("lines.strength", spec.lines.strength, 0.2, 1);
  check.number("lines.wear", spec.lines.wear, 0, 1);
  check.colour("lines.other_albedo", spec.lines.other_albedo);
  check.number("lines.other_width_m", spec.lines.other_width_m, 0.03, 0.15);
  check.number("goals.net_mesh_m", spec.goals.net_mesh_m, 0.03, 0.3);
  check.number("goals.net_cord_m", spec.goals.net_cord_m, 0.001, 0.02);
  check.colour("goals.net_albedo", spec.goals.net_albedo);
  check.colour("goals.post_albedo", spec.goals.post_albedo);
  check.colour("goals.pad_albedo", spec.goals.pad_albedo);
  check.colour("goals.flag_albedo", spec.goals.flag_albedo);
  check.number("boards.height_m", spec.boards.height_m, 0.3, 2);
  check.number("boards.distance_m", spec.boards.distance_m, 1, 15);
  check.number("boards.led_speed_m_s", spec.boards.led_speed_m_s, 0, 10);
  check.number("boards.led_period_s", spec.boards.led_period_s, 1, 600);
  check.number("boards.led_brightness", spec.boards.led_brightness, 0.1, 5);
  check_stands(check, spec.stands);
  if (spec.stands.distance_m < spec.boards.distance_m + 0.5)
    check.refuse("stands.distance_m",
                 fmt::format("{} m leaves no room for boards at {} m", spec.stands.distance_m,
                             spec.boards.distance_m),
                 "put the stands half a metre behind the boards or more");
  check.number("crowd.occupancy", spec.crowd.occupancy, 0, 1);
  check.number("crowd.motion", spec.crowd.motion, 0, 3);
  check.number("crowd.loyal", spec.crowd.loyal, 0, 1);
  check.colour("crowd.home", spec.crowd.home);
  check.colour("crowd.away", spec.crowd.away);
  check.number("sun.azimuth_deg", spec.sun.azimuth_deg, -360, 360);
  check.number("sun.elevation_deg", spec.sun.elevation_deg, 3, 89);
  check.number("sun.share", spec.sun.share, 0, 1);
  check.colour("sun.tint", spec.sun.tint, 3);
  check.colour("sun.sky_tint", spec.sun.sky_tint, 3);
  check_clouds(check, spec.clouds);
  check.number("floodlights.level", spec.floodlights.level, 0, 3);
  check.colour("floodlights.tint", spec.floodlights.tint, 3);
  check.number("floodlights.lamp_m", spec.floodlights.lamp_m, 0.2, 20);
  check.number("weather.rain", spec.weather.rain, 0, 1);
  check.number("weather.wetness", spec.weather.wetness, 0, 1);
  check.number("weather.visibility_m", spec.weather.visibility_m, 60, 100000);
  const bool lit = spec.sun.present ||
                   (spec.floodlights.layout != Floodlights::kNone && spec.floodlights.level > 0);
  if (!lit)
    check.refuse("sun.present", "false, and no floodlights are on",
                 "set floodlights.layout and floodlights.level");
  return check.status();
}

}  // namespace touchline::sim::world
