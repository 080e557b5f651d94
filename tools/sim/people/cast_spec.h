// What a scene says about its people and its ball. Everything has a default; validate() names the
// field, the value and the bound of what does not hold.
//
// Positions are metres in the pitch frame, angles degrees from +X towards +Y, times seconds from
// the first frame; times may be negative (before the first frame).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"

namespace touchline::sim::people {

// Linear BT.709 reflectance, each 0..1.
using Colour = std::array<double, 3>;

enum class Role : std::uint8_t { kPlayer, kKeeper, kReferee };
enum class KitPattern : std::uint8_t { kPlain, kStripes, kHoops, kHalves, kSash };
enum class HairStyle : std::uint8_t { kBald, kShaved, kShort, kFull, kLong };

// "player", "goalkeeper" (read as "keeper" too), "referee"; "plain", "stripes", ...; "bald", ... as
// people.csv and scenes say.
std::string_view name(Role role);
std::string_view name(KitPattern pattern);
std::string_view name(HairStyle style);
std::optional<Role> role_of(std::string_view text);
std::optional<KitPattern> pattern_of(std::string_view text);
std::optional<HairStyle> hair_of(std::string_view text);

struct KitSpec {
  KitPattern pattern = KitPattern::kPlain;
  Colour shirt{0.55, 0.03, 0.03};
  Colour second{0.8, 0.8, 0.8};  // stripes, hoops, the other half, sash, collar and cuffs
  Colour shorts{0.8, 0.8, 0.8};
  Colour socks{0.55, 0.03, 0.03};
  Colour number{0.85, 0.85, 0.85};
};

// Where somebody is over time.
enum class PathKind : std::uint8_t {
  kStanding,  // at `position_m`, now and then shifting weight
  kScripted,  // through `way_points`; still before the first and after the last
  kTrack,     // from a tracking provider's file
  kAuto,      // wanders round `position_m` with the ball in view, by seed
};

struct WayPoint {
  double time_s = 0;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
};

enum class TrackFormat : std::uint8_t { kTracab, kEpts, kLastRow, kPff };
std::string_view name(TrackFormat format);  // "tracab", "epts", "lastrow", "pff"
std::optional<TrackFormat> track_format_of(std::string_view text);

struct TrackSource {
  std::filesystem::path file;  // TRACAB .dat, Metrica EPTS .txt, Last Row .csv, PFF .jsonl
  TrackFormat format = TrackFormat::kTracab;
  int player = 0;      // index among the people of the file, 0-based, in order of appearance
  double start_s = 0;  // file time at the scene's first frame, seconds from the file's first row
  double rate_hz = 0;  // rows a second; 0 = the format's own (25; Last Row 20; PFF 29.97)
};

// Something done at a time: the instant of contact with the ball (shot, pass, header, throw,
// deflect) or the start (everything else). Names: see action_names().
struct ActionSpec {
  std::string name;
  double time_s = 0;
  bool mirror = false;  // the other side or foot
  // Where the ball is at contact: the person's path is bent gently so that foot, head or hand gets
  // there.
  std::optional<Eigen::Vector2d> ball_m;
};
// shot, shot_run, pass, pass_run, header, header_jump, header_run, header_dive, bicycle, slide,
// tackle, throw, dive_high, dive_mid, dive_low, catch, catch_high, trap, chest, trip, fall,
// celebrate, applaud, dismay, card. Dives go to the person's own left. Who runs faster than 2.5 m/s
// takes shot, pass and header in stride. Who ends on the turf gets up.
const std::vector<std::string>& action_names();

enum class Facing : std::uint8_t {
  kTravel,  // where one goes; when still, towards the ball
  kBall,    // the ball, stepping sideways and backwards as needed
  kFixed,   // facing_deg
};

struct PersonSpec {
  std::string id;    // as in people.csv; unique; letters, digits, '-' and '_'
  std::string team;  // a kit of CastSpec::kits by name ("home", "away", "referees")
  Role role = Role::kPlayer;
  int number = 0;  // on the back; 0 = none

  PathKind path = PathKind::kStanding;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // standing and auto
  std::vector<WayPoint> way_points;                      // scripted, times increasing
  TrackSource track;                                     // track
  double roam_m = 6;                                     // auto: how far from position_m, 0..40
  double pace_mps = 3;                                   // auto: usual speed, 0.5..8
  Facing facing = Facing::kTravel;
  double facing_deg = 0;
  std::vector<ActionSpec> actions;  // times increasing

  // Looks; absent = by seed.
  std::optional<double> height_m;  // 1.5..2.1
  std::optional<double> muscle;    // 0..1
  std::optional<double> weight;    // -1 (thin)..1 (heavy)
  std::optional<Colour> skin;
  std::optional<HairStyle> hair;
  std::optional<Colour> hair_colour;
};

// People in contact. They are added to the cast: `prefix` + "1", "2", ... with the teams given in
// turn.
enum class GroupKind : std::uint8_t {
  kRuck,       // bent forward, bound to each other, over the ball
  kWall,       // side by side, facing facing_deg, hands in front
  kGoalMouth,  // keeper and a scrum of players jostling under a high ball
};
std::string_view name(GroupKind kind);  // "ruck", "wall", "goalmouth"
std::optional<GroupKind> group_of(std::string_view text);

struct GroupSpec {
  GroupKind kind = GroupKind::kWall;
  std::string prefix = "g";
  std::vector<std::string> teams{"home", "away"};  // wall: the first alone
  int people = 5;                                  // 2..16
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  double facing_deg = 180;
  double spread = 1;  // 0.7..2 times the usual spacing; under 1 bodies overlap more
};

enum class BallPath : std::uint8_t {
  kNone,      // no ball
  kResting,   // at position_m until kicked
  kScripted,  // through way_points (x, y, z of the centre), rolling where it touches the turf
  kDribbled,  // at `carrier`'s feet until kicked
};
struct BallWayPoint {
  double time_s = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};
// The ball leaves where it is, flies with drag, bounces, rolls to rest.
struct KickSpec {
  double time_s = 0;
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();  // up to 45
  Eigen::Vector3d spin_rps = Eigen::Vector3d::Zero();  // turns a second, axis in the pitch frame
};
struct BallSpec {
  BallPath path = BallPath::kResting;
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();
  std::vector<BallWayPoint> way_points;
  std::string carrier;          // id of a person
  std::vector<KickSpec> kicks;  // times increasing
  double radius_m = 0.11;       // 0.08..0.2
  bool oval = false;            // rugby: 0.28 m long, 0.19 m thick
  Colour panel{0.85, 0.85, 0.85};
  Colour mark{0.03, 0.03, 0.05};
};

struct CastSpec {
  std::vector<PersonSpec> people;
  std::vector<GroupSpec> groups;
  BallSpec ball;
  struct NamedKit {
    std::string team;
    KitSpec kit;
    KitSpec keeper;
  };
  std::vector<NamedKit> kits = default_kits();  // home, away, referees
  double duration_s =
      30;  // motion is planned from 2 s before 0 to 2 s after this; still beyond. 0..1200

  static std::vector<NamedKit> default_kits();
};

// 1 to 30 people, groups included; ids unique; teams known; numbers in their bounds.
base::Status validate(const CastSpec& spec);

}  // namespace touchline::sim::people
