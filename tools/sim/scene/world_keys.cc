#include <sstream>

#include "tools/sim/scene/keys_internal.h"

namespace touchline::sim::scene {

namespace {

void read_turf(config::Table t, world::TurfSpec& s) {
  using world::Mowing;
  s.albedo = colour(t, "albedo", s.albedo);
  s.mowing = t.choice<Mowing>("mowing", s.mowing,
                              {{"none", Mowing::kNone},
                               {"across", Mowing::kAcross},
                               {"along", Mowing::kAlong},
                               {"chequer", Mowing::kChequer},
                               {"rings", Mowing::kRings}});
  s.stripe_m = t.number("stripe_m", s.stripe_m);
  s.stripe_contrast = t.number("stripe_contrast", s.stripe_contrast);
  s.texture = t.number("texture", s.texture);
  s.wear = t.number("wear", s.wear);
  s.artificial = t.boolean("artificial", s.artificial);
}

void read_lines(config::Table t, world::LinesSpec& s) {
  s.albedo = colour(t, "albedo", s.albedo);
  s.strength = t.number("strength", s.strength);
  s.wear = t.number("wear", s.wear);
  s.other_sport = t.boolean("other_sport", s.other_sport);
  s.other_albedo = colour(t, "other_albedo", s.other_albedo);
  s.other_width_m = t.number("other_width_m", s.other_width_m);
}

void read_goals(config::Table t, world::GoalsSpec& s) {
  s.nets = t.boolean("nets", s.nets);
  s.net_mesh_m = t.number("net_mesh_m", s.net_mesh_m);
  s.net_cord_m = t.number("net_cord_m", s.net_cord_m);
  s.net_albedo = colour(t, "net_albedo", s.net_albedo);
  s.post_albedo = colour(t, "post_albedo", s.post_albedo);
  s.pad_albedo = colour(t, "pad_albedo", s.pad_albedo);
  s.flag_albedo = colour(t, "flag_albedo", s.flag_albedo);
}

void read_boards(config::Table t, world::BoardsSpec& s) {
  const auto side = [&](std::string_view key, world::Boards& boards) {
    boards = t.choice<world::Boards>(key, boards,
                                     {{"none", world::Boards::kNone},
                                      {"printed", world::Boards::kPrinted},
                                      {"led", world::Boards::kLed}});
  };
  side("near_side", s.near_side);
  side("far_side", s.far_side);
  side("left_side", s.left_side);
  side("right_side", s.right_side);
  s.height_m = t.number("height_m", s.height_m);
  s.distance_m = t.number("distance_m", s.distance_m);
  s.led_speed_m_s = t.number("led_speed_m_s", s.led_speed_m_s);
  s.led_period_s = t.number("led_period_s", s.led_period_s);
  s.led_brightness = t.number("led_brightness", s.led_brightness);
}

void read_stands(config::Table t, world::StandsSpec& s) {
  const auto side = [&](std::string_view key, world::StandSide& stand) {
    config::Table part = t.table(key);
    stand.present = part.boolean("present", stand.present);
    stand.rows = static_cast<int>(part.integer("rows", stand.rows, {0, 1000}));
    stand.roof = part.boolean("roof", stand.roof);
  };
  side("near_side", s.near_side);
  side("far_side", s.far_side);
  side("left_side", s.left_side);
  side("right_side", s.right_side);
  s.distance_m = t.number("distance_m", s.distance_m);
  s.seat_albedo = colour(t, "seat_albedo", s.seat_albedo);
  s.dugouts = t.boolean("dugouts", s.dugouts);
}

void read_crowd(config::Table t, world::CrowdSpec& s) {
  s.occupancy = t.number("occupancy", s.occupancy);
  s.motion = t.number("motion", s.motion);
  s.home = colour(t, "home", s.home);
  s.away = colour(t, "away", s.away);
  s.loyal = t.number("loyal", s.loyal);
}

void read_sun(config::Table t, world::SunSpec& s) {
  s.present = t.boolean("present", s.present);
  s.azimuth_deg = t.number("azimuth_deg", s.azimuth_deg);
  s.elevation_deg = t.number("elevation_deg", s.elevation_deg);
  s.share = t.number("share", s.share);
  s.tint = colour(t, "tint", s.tint);
  s.sky_tint = colour(t, "sky_tint", s.sky_tint);
}

void read_clouds(config::Table t, world::CloudSpec& s) {
  for (const auto& row : rows(t, "light", 3, "time_s, sun, all")) {
    s.keys.push_back({row[0], row[1], row[2]});
  }
  s.drift = t.number("drift", s.drift);
  s.drift_scale_m = t.number("drift_scale_m", s.drift_scale_m);
  s.drift_x_m_s = t.number("drift_x_m_s", s.drift_x_m_s);
  s.drift_y_m_s = t.number("drift_y_m_s", s.drift_y_m_s);
}

void read_floodlights(config::Table t, world::FloodlightSpec& s) {
  using world::Floodlights;
  s.layout = t.choice<Floodlights>(
      "layout", s.layout,
      {{"none", Floodlights::kNone}, {"masts", Floodlights::kMasts}, {"roof", Floodlights::kRoof}});
  s.level = t.number("level", s.level);
  s.tint = colour(t, "tint", s.tint);
  s.lamp_m = t.number("lamp_m", s.lamp_m);
}

void read_weather(config::Table t, world::WeatherSpec& s) {
  s.rain = t.number("rain", s.rain);
  s.wetness = t.number("wetness", s.wetness);
  s.visibility_m = t.number("visibility_m", s.visibility_m);
}

}  // namespace

void read_world(config::Table& root, world::WorldSpec& world) {
  read_turf(root.table("turf"), world.turf);
  read_lines(root.table("lines"), world.lines);
  read_goals(root.table("goals"), world.goals);
  read_boards(root.table("boards"), world.boards);
  read_stands(root.table("stands"), world.stands);
  read_crowd(root.table("crowd"), world.crowd);
  read_sun(root.table("sun"), world.sun);
  read_clouds(root.table("clouds"), world.clouds);
  read_floodlights(root.table("floodlights"), world.floodlights);
  read_weather(root.table("weather"), world.weather);
  const base::Status status = world::validate(world);
  if (status) return;
  // "turf.stripe_m", whatever stands before it, is a key of [turf].
  std::istringstream words(status.error().where);
  config::Table at = root;
  std::string word, key = status.error().where;
  while (std::getline(words, word, '.')) {
    key = word;
    if (at.table(word).present() && words.peek() != std::char_traits<char>::eof()) {
      at = at.table(word);
    }
  }
  at.reject(key, status.error().what, status.error().cure);
}

}  // namespace touchline::sim::scene
