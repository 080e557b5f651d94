// What a simulated ground looks like: turf, lines, goals, boards, stands, crowd, light, weather.
// Metres, seconds from the first frame, degrees; colours are linear albedos (BT.709 primaries).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "shared/base/result.h"

namespace touchline::sim::world {

// Linear red, green, blue.
using Colour = Eigen::Vector3f;

enum class Mowing { kNone, kAcross, kAlong, kChequer, kRings };

struct TurfSpec {
  Colour albedo{0.075f, 0.150f, 0.028f};
  Mowing mowing = Mowing::kAcross;
  double stripe_m = 5.5;         // width of one stripe, 1-30
  double stripe_contrast = 0.2;  // relative difference between neighbours, 0-0.8
  double texture = 1.0;          // strength of the grain of the grass, 0-3
  double wear = 0.4;             // bare patches in goalmouths and centre, 0-1
  bool artificial = false;       // run-off of green carpet rather than grass
};

struct LinesSpec {
  Colour albedo{0.72f, 0.74f, 0.70f};
  double strength = 0.92;    // how much of the grass the chalk covers, 0.2-1
  double wear = 0.25;        // unevenness, 0-1
  bool other_sport = false;  // thin lines of another sport as well (handball-like boxes, halves)
  Colour other_albedo{0.60f, 0.48f, 0.05f};
  double other_width_m = 0.08;  // 0.03-0.15
};

struct GoalsSpec {
  bool nets = true;
  double net_mesh_m = 0.11;   // from cord to cord, 0.03-0.3
  double net_cord_m = 0.004;  // thickness, 0.001-0.02
  Colour net_albedo{0.75f, 0.75f, 0.75f};
  Colour post_albedo{0.80f, 0.80f, 0.80f};
  Colour pad_albedo{0.05f, 0.10f, 0.35f};  // rugby
  Colour flag_albedo{0.75f, 0.12f, 0.04f};
};

enum class Boards { kNone, kPrinted, kLed };

// Perimeter boards, side by side outside the touchlines and behind the goals.
struct BoardsSpec {
  Boards near_side = Boards::kNone;  // y < 0, in front of the main camera side
  Boards far_side = Boards::kLed;
  Boards left_side = Boards::kPrinted;
  Boards right_side = Boards::kPrinted;
  double height_m = 0.95;       // 0.3-2
  double distance_m = 4.0;      // outside the lines, 1-15
  double led_speed_m_s = 1.5;   // a band of letters that moves, 0-10
  double led_period_s = 8;      // another picture after so long, 1-600
  double led_brightness = 0.9;  // white of the LEDs in units of the key light, 0.1-5
};

struct StandSide {
  bool present = true;
  int rows = 30;  // 4-120
  bool roof = true;
};

struct StandsSpec {
  StandSide near_side{true, 36, true};
  StandSide far_side{true, 40, true};
  StandSide left_side{true, 26, true};
  StandSide right_side{true, 26, true};
  double distance_m = 8.5;  // foot of the stand from the lines, 5-40
  Colour seat_albedo{0.05f, 0.10f, 0.35f};
  bool dugouts = true;  // on the near side
};

struct CrowdSpec {
  double occupancy = 0.8;  // share of the seats, 0-1
  double motion = 1.0;     // sway, arms and standing up, 0-3
  Colour home{0.45f, 0.03f, 0.03f};
  Colour away{0.75f, 0.75f, 0.75f};
  double loyal = 0.3;  // share dressed in a team's colour, 0-1
};

struct SunSpec {
  bool present = true;
  double azimuth_deg = 215;   // where it stands, from +X towards +Y, -360..360
  double elevation_deg = 42;  // 3-89
  double share = 0.78;        // of the light of a level white surface under a clear sky, 0-1
  Colour tint{1.0f, 0.96f, 0.90f};
  Colour sky_tint{0.80f, 0.92f, 1.20f};
};

// Light on the whole ground at one time, linear between keys, constant beyond them.
struct LightKey {
  double time_s = 0;
  double sun = 1;  // share of the direct sun left, 0-1
  double all = 1;  // factor on all daylight, 0.05-2
};

struct CloudSpec {
  std::vector<LightKey> keys;  // times ascend
  double drift = 0;            // depth of cloud shadows that drift over the ground, 0-1
  double drift_scale_m = 90;   // size of the clouds, 10-1000
  double drift_x_m_s = 6;      // -50..50
  double drift_y_m_s = 2;
};

enum class Floodlights { kNone, kMasts, kRoof };

struct FloodlightSpec {
  Floodlights layout = Floodlights::kNone;
  double level = 1.0;  // light of a level white surface at the centre spot, 0-3
  Colour tint{0.97f, 1.0f, 1.03f};
  double lamp_m = 5.0;  // width of one bank of lamps (softness of shadows), 0.2-20
};

struct WeatherSpec {
  double rain = 0;             // streaks in the air, 0-1
  double wetness = 0;          // of turf and boards, 0-1
  double visibility_m = 8000;  // where haze hides 98 %, 60-100000
};

struct WorldSpec {
  TurfSpec turf;
  LinesSpec lines;
  GoalsSpec goals;
  BoardsSpec boards;
  StandsSpec stands;
  CrowdSpec crowd;
  SunSpec sun;  // absent at night; then the sky is dark
  CloudSpec clouds;
  FloodlightSpec floodlights;
  WeatherSpec weather;
};

// An error names field, value and bound. Some light is needed: a sun or floodlights.
base::Status validate(const WorldSpec& spec);

}  // namespace touchline::sim::world
