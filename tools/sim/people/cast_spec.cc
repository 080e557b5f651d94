#include "tools/sim/people/cast_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace touchline::sim::people {
namespace {

template <typename E, std::size_t n>
std::optional<E> lookup(const std::array<std::string_view, n>& names, std::string_view text) {
  for (std::size_t i = 0; i < n; ++i) {
    if (names[i] == text) return static_cast<E>(i);
  }
  return std::nullopt;
}

constexpr std::array<std::string_view, 3> kRoles{"player", "goalkeeper", "referee"};
constexpr std::array<std::string_view, 5> kPatterns{"plain", "stripes", "hoops", "halves", "sash"};
constexpr std::array<std::string_view, 5> kHair{"bald", "shaved", "short", "full", "long"};
constexpr std::array<std::string_view, 4> kTracks{"tracab", "epts", "lastrow", "pff"};
constexpr std::array<std::string_view, 3> kGroups{"ruck", "wall", "goalmouth"};

template <typename E>
std::size_t at(E e) {
  return static_cast<std::size_t>(e);
}

base::Status refuse(const std::string& where, std::string what) {
  return base::fail(base::ErrorKind::kConfiguration, where, std::move(what));
}

base::Status in_range(const std::string& where, const char* field, double value, double least,
                      double most) {
  if (value >= least && value <= most) return {};
  return refuse(where, fmt::format("{} = {}, must be {} .. {}", field, value, least, most));
}

base::Status on_ground(const std::string& where, const char* field, const Eigen::Vector2d& p) {
  if (p.allFinite() && p.cwiseAbs().maxCoeff() <= 200) return {};
  return refuse(where, fmt::format("{} = ({}, {}), must be within 200 m of the centre spot", field,
                                   p.x(), p.y()));
}

base::Status colour(const std::string& where, const char* field, const Colour& c) {
  for (const double v : c) {
    if (auto s = in_range(where, field, v, 0, 1); !s) return s;
  }
  return {};
}

base::Status identifier(const std::string& where, const char* field, const std::string& id) {
  const bool good = !id.empty() && id.size() <= 40 && std::all_of(id.begin(), id.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
           c == '_';
  });
  if (good) return {};
  return refuse(where,
                fmt::format("{} = '{}', must be 1 .. 40 letters, digits, '-' and '_'", field, id));
}

base::Status times(const std::string& where, const char* field, double before, double now) {
  if (!(std::abs(now) <= 1300)) {
    return refuse(where,
                  fmt::format("{} = {} s, must be within 1300 s of the first frame", field, now));
  }
  if (now > before) return {};
  return refuse(where, fmt::format("{} = {} s after {} s, must increase", field, now, before));
}

#define TOUCHLINE_CHECK(expression)                         \
  do {                                                      \
    if (auto status = (expression); !status) return status; \
  } while (false)

base::Status check(const PersonSpec& p, const std::string& where) {
  TOUCHLINE_CHECK(identifier(where, "id", p.id));
  if (p.id == "ball") return refuse(where, "id = 'ball' is the ball's");
  TOUCHLINE_CHECK(in_range(where, "number", p.number, 0, 99));
  TOUCHLINE_CHECK(on_ground(where, "position_m", p.position_m));
  TOUCHLINE_CHECK(in_range(where, "roam_m", p.roam_m, 0, 40));
  TOUCHLINE_CHECK(in_range(where, "pace_mps", p.pace_mps, 0.5, 8));
  TOUCHLINE_CHECK(in_range(where, "facing_deg", p.facing_deg, -360, 360));
  if (p.path == PathKind::kScripted) {
    if (p.way_points.empty() || p.way_points.size() > 10000) {
      return refuse(where, fmt::format("{} way points, must be 1 .. 10000", p.way_points.size()));
    }
    for (std::size_t i = 0; i < p.way_points.size(); ++i) {
      const WayPoint& w = p.way_points[i];
      TOUCHLINE_CHECK(on_ground(where, "way point", w.position_m));
      TOUCHLINE_CHECK(
          times(where, "way point's time", i > 0 ? p.way_points[i - 1].time_s : -1e9, w.time_s));
      if (i == 0) continue;
      const double speed = (w.position_m - p.way_points[i - 1].position_m).norm() /
                           (w.time_s - p.way_points[i - 1].time_s);
      TOUCHLINE_CHECK(in_range(where, "m/s to way point", speed, 0, 10.5));
    }
  }
  if (p.path == PathKind::kTrack) {
    if (p.track.file.empty()) return refuse(where, "track without a file");
    TOUCHLINE_CHECK(in_range(where, "track player", p.track.player, 0, 999));
    TOUCHLINE_CHECK(in_range(where, "track start_s", p.track.start_s, -1e5, 1e5));
    TOUCHLINE_CHECK(in_range(where, "track rate_hz", p.track.rate_hz, 0, 1000));
  }
  for (std::size_t i = 0; i < p.actions.size(); ++i) {
    const ActionSpec& a = p.actions[i];
    const auto& known = action_names();
    if (std::find(known.begin(), known.end(), a.name) == known.end()) {
      return refuse(where,
                    fmt::format("action '{}' is none of {}", a.name, fmt::join(known, ", ")));
    }
    TOUCHLINE_CHECK(
        times(where, "action's time", i > 0 ? p.actions[i - 1].time_s : -1e9, a.time_s));
    if (a.ball_m) TOUCHLINE_CHECK(on_ground(where, "action's ball_m", *a.ball_m));
  }
  if (p.height_m) TOUCHLINE_CHECK(in_range(where, "height_m", *p.height_m, 1.5, 2.1));
  if (p.muscle) TOUCHLINE_CHECK(in_range(where, "muscle", *p.muscle, 0, 1));
  if (p.weight) TOUCHLINE_CHECK(in_range(where, "weight", *p.weight, -1, 1));
  if (p.skin) TOUCHLINE_CHECK(colour(where, "skin", *p.skin));
  if (p.hair_colour) TOUCHLINE_CHECK(colour(where, "hair_colour", *p.hair_colour));
  return {};
}

base::Status check(const BallSpec& b, const std::set<std::string>& ids) {
  const std::string where = "ball";
  TOUCHLINE_CHECK(on_ground(where, "position_m", b.position_m));
  TOUCHLINE_CHECK(in_range(where, "radius_m", b.radius_m, 0.08, 0.2));
  TOUCHLINE_CHECK(colour(where, "panel", b.panel));
  TOUCHLINE_CHECK(colour(where, "mark", b.mark));
  if (b.path == BallPath::kScripted) {
    if (b.way_points.empty()) return refuse(where, "0 way points, must be 1 at least");
    for (std::size_t i = 0; i < b.way_points.size(); ++i) {
      const auto& w = b.way_points[i];
      TOUCHLINE_CHECK(on_ground(where, "way point", w.position_m.head<2>()));
      TOUCHLINE_CHECK(in_range(where, "way point's height", w.position_m.z(), -5, 100));
      TOUCHLINE_CHECK(
          times(where, "way point's time", i > 0 ? b.way_points[i - 1].time_s : -1e9, w.time_s));
    }
  }
  if (b.path == BallPath::kDribbled && ids.count(b.carrier) == 0) {
    return refuse(where, fmt::format("carrier = '{}' is nobody's id", b.carrier));
  }
  for (std::size_t i = 0; i < b.kicks.size(); ++i) {
    const KickSpec& k = b.kicks[i];
    TOUCHLINE_CHECK(times(where, "kick's time", i > 0 ? b.kicks[i - 1].time_s : -1e9, k.time_s));
    TOUCHLINE_CHECK(in_range(where, "kick's speed", k.velocity_mps.norm(), 0, 45));
    TOUCHLINE_CHECK(in_range(where, "kick's spin", k.spin_rps.norm(), 0, 20));
  }
  return {};
}

base::Status check(const KitSpec& k, const std::string& where) {
  TOUCHLINE_CHECK(colour(where, "shirt", k.shirt));
  TOUCHLINE_CHECK(colour(where, "second", k.second));
  TOUCHLINE_CHECK(colour(where, "shorts", k.shorts));
  TOUCHLINE_CHECK(colour(where, "socks", k.socks));
  TOUCHLINE_CHECK(colour(where, "number", k.number));
  return {};
}

}  // namespace

std::string_view name(Role role) { return kRoles[at(role)]; }
std::string_view name(KitPattern pattern) { return kPatterns[at(pattern)]; }
std::string_view name(HairStyle style) { return kHair[at(style)]; }
std::string_view name(TrackFormat format) { return kTracks[at(format)]; }
std::string_view name(GroupKind kind) { return kGroups[at(kind)]; }
std::optional<Role> role_of(std::string_view text) {
  return text == "keeper" ? Role::kKeeper : lookup<Role>(kRoles, text);
}
std::optional<KitPattern> pattern_of(std::string_view text) {
  return lookup<KitPattern>(kPatterns, text);
}
std::optional<HairStyle> hair_of(std::string_view text) { return lookup<HairStyle>(kHair, text); }
std::optional<TrackFormat> track_format_of(std::string_view text) {
  return lookup<TrackFormat>(kTracks, text);
}
std::optional<GroupKind> group_of(std::string_view text) {
  return lookup<GroupKind>(kGroups, text);
}

std::vector<CastSpec::NamedKit> CastSpec::default_kits() {
  NamedKit home{"home", {}, {}};
  home.kit = {KitPattern::kStripes, {0.50, 0.02, 0.03}, {0.75, 0.75, 0.75},
              {0.02, 0.02, 0.03},   {0.50, 0.02, 0.03}, {0.02, 0.02, 0.03}};
  home.keeper = {KitPattern::kPlain, {0.65, 0.55, 0.03}, {0.05, 0.05, 0.05},
                 {0.04, 0.04, 0.04}, {0.65, 0.55, 0.03}, {0.03, 0.03, 0.03}};
  NamedKit away{"away", {}, {}};
  away.kit = {KitPattern::kPlain, {0.02, 0.06, 0.35}, {0.75, 0.75, 0.75},
              {0.70, 0.70, 0.70}, {0.02, 0.06, 0.35}, {0.80, 0.80, 0.80}};
  away.keeper = {KitPattern::kPlain, {0.70, 0.22, 0.02}, {0.75, 0.75, 0.75},
                 {0.60, 0.18, 0.02}, {0.70, 0.22, 0.02}, {0.80, 0.80, 0.80}};
  NamedKit referees{"referees", {}, {}};
  referees.kit = {KitPattern::kPlain, {0.025, 0.025, 0.028}, {0.6, 0.55, 0.05},
                  {0.02, 0.02, 0.02}, {0.025, 0.025, 0.025}, {0.7, 0.7, 0.7}};
  referees.keeper = referees.kit;
  return {home, away, referees};
}

base::Status validate(const CastSpec& spec) {
  TOUCHLINE_CHECK(in_range("cast", "duration_s", spec.duration_s, 0, 1200));
  std::set<std::string> teams;
  for (const auto& kit : spec.kits) {
    TOUCHLINE_CHECK(identifier("kit", "team", kit.team));
    if (!teams.insert(kit.team).second)
      return refuse("kit", fmt::format("team '{}' twice", kit.team));
    TOUCHLINE_CHECK(check(kit.kit, "kit '" + kit.team + "'"));
    TOUCHLINE_CHECK(check(kit.keeper, "keeper's kit '" + kit.team + "'"));
  }
  std::set<std::string> ids;
  std::size_t people = spec.people.size();
  for (std::size_t i = 0; i < spec.people.size(); ++i) {
    const PersonSpec& p = spec.people[i];
    const std::string where = fmt::format("person {} '{}'", i, p.id);
    TOUCHLINE_CHECK(check(p, where));
    if (teams.count(p.team) == 0)
      return refuse(where, fmt::format("team = '{}' has no kit", p.team));
    if (!ids.insert(p.id).second) return refuse(where, "id twice");
  }
  for (std::size_t i = 0; i < spec.groups.size(); ++i) {
    const GroupSpec& g = spec.groups[i];
    const std::string where = fmt::format("group {} '{}'", i, g.prefix);
    TOUCHLINE_CHECK(identifier(where, "prefix", g.prefix));
    TOUCHLINE_CHECK(in_range(where, "people", g.people, 2, 16));
    TOUCHLINE_CHECK(on_ground(where, "position_m", g.position_m));
    TOUCHLINE_CHECK(in_range(where, "facing_deg", g.facing_deg, -360, 360));
    TOUCHLINE_CHECK(in_range(where, "spread", g.spread, 0.7, 2));
    if (g.teams.empty()) return refuse(where, "no teams");
    for (const std::string& team : g.teams) {
      if (teams.count(team) == 0) return refuse(where, fmt::format("team = '{}' has no kit", team));
    }
    for (int k = 1; k <= g.people; ++k) {
      if (!ids.insert(g.prefix + std::to_string(k)).second) {
        return refuse(where, fmt::format("id '{}{}' twice", g.prefix, k));
      }
    }
    people += static_cast<std::size_t>(g.people);
  }
  if (people < 1 || people > 30)
    return refuse("cast", fmt::format("{} people, must be 1 .. 30", people));
  return check(spec.ball, ids);
}

}  // namespace touchline::sim::people
