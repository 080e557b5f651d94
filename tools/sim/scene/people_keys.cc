#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "tools/sim/camera/random.h"
#include "tools/sim/scene/keys_internal.h"

namespace touchline::sim::scene {

namespace {

using people::CastSpec;
using people::PersonSpec;

void read_kit(config::Table& t, people::KitSpec& kit) {
  if (const auto word = t.optional_text("pattern")) {
    if (const auto pattern = people::pattern_of(*word)) {
      kit.pattern = *pattern;
    } else {
      t.reject("pattern", "'" + *word + "' is not known",
               "one of: plain, stripes, hoops, halves, sash");
    }
  }
  kit.shirt = colour(t, "shirt", kit.shirt);
  kit.second = colour(t, "second", kit.second);
  kit.shorts = colour(t, "shorts", kit.shorts);
  kit.socks = colour(t, "socks", kit.socks);
  kit.number = colour(t, "number", kit.number);
}

void read_kits(config::Table& root, CastSpec& cast) {
  for (config::Table t : root.tables("kit")) {
    const std::string team = t.required_text("team");
    auto at = std::find_if(cast.kits.begin(), cast.kits.end(),
                           [&](const CastSpec::NamedKit& kit) { return kit.team == team; });
    if (at == cast.kits.end()) {
      cast.kits.push_back({team, {}, {}});
      at = cast.kits.end() - 1;
    }
    read_kit(t, at->kit);
    config::Table keeper = t.table("keeper");
    read_kit(keeper, at->keeper);
  }
}

// Looks and what everybody has, whoever they are.
void read_looks(config::Table& t, PersonSpec& p) {
  p.height_m = t.optional_number("height_m");
  p.muscle = t.optional_number("muscle");
  p.weight = t.optional_number("weight");
  if (t.has("skin")) p.skin = colour(t, "skin", people::Colour{0.5, 0.35, 0.25});
  if (const auto word = t.optional_text("hair")) {
    p.hair = people::hair_of(*word);
    if (!p.hair) {
      t.reject("hair", "'" + *word + "' is not known", "one of: bald, shaved, short, full, long");
    }
  }
  if (t.has("hair_colour")) p.hair_colour = colour(t, "hair_colour", people::Colour{0, 0, 0});
}

void read_path(config::Table& t, const std::filesystem::path& folder, PersonSpec& p) {
  using people::PathKind;
  p.position_m = pair(t, "at", p.position_m);
  for (const auto& row : rows(t, "way", 3, "time_s, x, y")) {
    p.way_points.push_back({row[0], {row[1], row[2]}});
  }
  config::Table track = t.table("track");
  if (track.present()) {
    p.path = PathKind::kTrack;
    p.track.file = folder / track.required_text("file");
    const std::string word = track.text("format", people::name(p.track.format));
    if (const auto format = people::track_format_of(word)) {
      p.track.format = *format;
    } else {
      track.reject("format", "'" + word + "' is not known", "one of: tracab, epts, lastrow, pff");
    }
    p.track.player = static_cast<int>(track.integer("player", p.track.player, {0, 1000}));
    p.track.start_s = track.number("start_s", p.track.start_s);
    p.track.rate_hz = track.number("rate_hz", p.track.rate_hz);
  } else if (!p.way_points.empty()) {
    p.path = PathKind::kScripted;
  }
  p.path = t.choice<PathKind>("path", p.path,
                              {{"standing", PathKind::kStanding},
                               {"auto", PathKind::kAuto},
                               {"scripted", PathKind::kScripted},
                               {"track", PathKind::kTrack}});
  p.roam_m = t.number("roam_m", p.roam_m);
  p.pace_mps = t.number("pace_mps", p.pace_mps);
  if (t.has("facing_deg")) p.facing = people::Facing::kFixed;
  p.facing_deg = t.number("facing_deg", p.facing_deg);
  p.facing = t.choice<people::Facing>("facing", p.facing,
                                      {{"travel", people::Facing::kTravel},
                                       {"ball", people::Facing::kBall},
                                       {"fixed", people::Facing::kFixed}});
  for (config::Table a : t.tables("action")) {
    people::ActionSpec action;
    action.name = a.required_text("name");
    const auto& names = people::action_names();
    if (!action.name.empty() && std::find(names.begin(), names.end(), action.name) == names.end()) {
      a.reject("name", "'" + action.name + "' is not known",
               fmt::format("one of: {}", fmt::join(names, ", ")));
    }
    action.time_s = a.required_number("time_s");
    action.mirror = a.boolean("mirror", action.mirror);
    if (a.has("ball")) action.ball_m = pair(a, "ball", Eigen::Vector2d::Zero());
    p.actions.push_back(action);
  }
}

void read_persons(config::Table& root, const std::filesystem::path& folder, CastSpec& cast) {
  for (config::Table t : root.tables("person")) {
    PersonSpec p;
    p.id = t.required_text("id");
    p.team = t.text("team", "home");
    p.number = static_cast<int>(t.integer("number", p.number, {0, 999}));
    if (const auto word = t.optional_text("role")) {
      if (const auto role = people::role_of(*word)) {
        p.role = *role;
      } else {
        t.reject("role", "'" + *word + "' is not known", "one of: player, keeper, referee");
      }
    }
    read_looks(t, p);
    read_path(t, folder, p);
    // Somebody of a [[team]] is named to be told more about.
    const auto known = std::find_if(cast.people.begin(), cast.people.end(),
                                    [&](const PersonSpec& q) { return q.id == p.id; });
    if (known == cast.people.end()) {
      cast.people.push_back(std::move(p));
      continue;
    }
    if (!t.has("team")) p.team = known->team;
    if (!t.has("role")) p.role = known->role;
    if (!t.has("number")) p.number = known->number;
    if (!t.has("at")) p.position_m = known->position_m;
    if (p.way_points.empty() && !t.has("track") && !t.has("path")) p.path = known->path;
    if (!t.has("facing") && !t.has("facing_deg")) p.facing = known->facing;
    if (!t.has("roam_m")) p.roam_m = known->roam_m;
    if (!t.has("pace_mps")) p.pace_mps = known->pace_mps;
    *known = std::move(p);
  }
}

// A team as a block of lines across the pitch, its keeper before its goal.
void read_teams(config::Table& root, const Scene& scene, double length_m, double width_m,
                CastSpec& cast) {
  for (config::Table t : root.tables("team")) {
    const std::string team = t.required_text("team");
    const std::string prefix = t.text("prefix", team.substr(0, 1));
    const auto count = t.integer("people", 11, {1, 30});
    const double goal = t.choice<double>("goal", -1, {{"left", -1.0}, {"right", 1.0}});
    const bool keeper = t.boolean("keeper", scene.sport == pitch::Sport::kSoccer);
    const Eigen::Vector2d centre = pair(t, "centre", {goal * length_m * 0.16, 0});
    const Eigen::Vector2d size = pair(t, "size", {length_m * 0.36, width_m * 0.66});
    PersonSpec usual;
    usual.team = team;
    usual.path = t.choice<people::PathKind>(
        "path", people::PathKind::kAuto,
        {{"standing", people::PathKind::kStanding}, {"auto", people::PathKind::kAuto}});
    usual.roam_m = t.number("roam_m", usual.roam_m);
    usual.pace_mps = t.number("pace_mps", usual.pace_mps);
    usual.facing = people::Facing::kBall;
    const camera::Stream random = camera::Stream(scene.seed, "team").sub(prefix);
    // Lines of four, nearest to the own goal first.
    const auto field = count - (keeper ? 1 : 0);
    const auto lines = std::max<std::int64_t>(1, (field + 3) / 4);
    for (std::int64_t i = 0; i < count; ++i) {
      PersonSpec p = usual;
      p.number = static_cast<int>(i + 1);
      p.id = fmt::format("{}{}", prefix, i + 1);
      if (keeper && i == 0) {
        p.role = people::Role::kKeeper;
        p.position_m = {goal * (length_m / 2 - 3), 0};
        p.roam_m = std::min(p.roam_m, 1.5);
        cast.people.push_back(p);
        continue;
      }
      const std::int64_t k = i - (keeper ? 1 : 0);
      const std::int64_t line = k * lines / field;
      std::int64_t first = k, last = k;
      while (first > 0 && (first - 1) * lines / field == line) --first;
      while (last + 1 < field && (last + 1) * lines / field == line) ++last;
      const double across =
          last > first ? static_cast<double>(k - first) / static_cast<double>(last - first) - 0.5
                       : 0;
      const double along =
          lines > 1 ? static_cast<double>(line) / static_cast<double>(lines - 1) - 0.5 : 0;
      const auto n = static_cast<std::uint64_t>(i) * 2;
      p.position_m = centre + Eigen::Vector2d(-goal * along * size.x(), across * size.y());
      p.position_m.x() += random.uniform(n, -0.06, 0.06) * size.x();
      p.position_m.y() += random.uniform(n + 1, -0.04, 0.04) * size.y();
      cast.people.push_back(p);
    }
  }
}

void read_groups(config::Table& root, CastSpec& cast) {
  for (config::Table t : root.tables("group")) {
    people::GroupSpec g;
    const std::string word = t.required_text("kind");
    if (const auto kind = people::group_of(word)) {
      g.kind = *kind;
    } else if (!word.empty()) {
      t.reject("kind", "'" + word + "' is not known", "one of: ruck, wall, goalmouth");
    }
    g.prefix = t.text("prefix", g.prefix);
    g.teams = t.texts("teams", g.teams);
    g.people = static_cast<int>(t.integer("people", g.people, {0, 100}));
    g.position_m = pair(t, "at", g.position_m);
    g.facing_deg = t.number("facing_deg", g.facing_deg);
    g.spread = t.number("spread", g.spread);
    cast.groups.push_back(g);
  }
}

void read_ball(config::Table t, people::BallSpec& ball) {
  if (!t.present()) {
    ball.path = people::BallPath::kNone;
    return;
  }
  ball.position_m = pair(t, "at", ball.position_m);
  for (const auto& row : rows(t, "way", 4, "time_s, x, y, z")) {
    ball.way_points.push_back({row[0], {row[1], row[2], row[3]}});
  }
  ball.carrier = t.text("carrier", "");
  ball.path = !ball.carrier.empty()      ? people::BallPath::kDribbled
              : !ball.way_points.empty() ? people::BallPath::kScripted
                                         : people::BallPath::kResting;
  for (config::Table k : t.tables("kick")) {
    people::KickSpec kick;
    kick.time_s = k.required_number("time_s");
    kick.velocity_mps = triple(k, "velocity_mps", kick.velocity_mps);
    kick.spin_rps = triple(k, "spin_rps", kick.spin_rps);
    ball.kicks.push_back(kick);
  }
  ball.radius_m = t.number("radius_m", ball.radius_m);
  ball.oval = t.boolean("oval", ball.oval);
  ball.panel = colour(t, "panel", ball.panel);
  ball.mark = colour(t, "mark", ball.mark);
}

}  // namespace

void read_people(config::Table& root, const std::filesystem::path& folder, const Scene& scene,
                 double length_m, double width_m, CastSpec& cast) {
  cast.duration_s = std::min(1200.0, std::ceil(scene.duration_s()));
  read_kits(root, cast);
  read_teams(root, scene, length_m, width_m, cast);
  read_persons(root, folder, cast);
  read_groups(root, cast);
  read_ball(root.table("ball"), cast.ball);
  if (cast.people.empty() && cast.groups.empty()) {
    if (root.has("ball")) {
      root.reject("ball", "a ball without people", "add a [[person]], or take [ball] out");
    }
  }
}

void check_people(config::Table& root, const CastSpec& cast) {
  if (cast.people.empty() && cast.groups.empty()) return;
  if (const auto status = people::validate(cast); !status) {
    // At whom it is about, where that can be told.
    const std::string& where = status.error().where;
    for (const char* kind : {"person", "team", "group", "kit"}) {
      for (config::Table t : root.tables(kind)) {
        const std::string id = t.text(kind == std::string_view("person")  ? "id"
                                      : kind == std::string_view("group") ? "prefix"
                                                                          : "team",
                                      "");
        if (!id.empty() && where.find(id) != std::string::npos) {
          t.reject(where.substr(where.find_last_of('.') + 1), where + ": " + status.error().what,
                   status.error().cure);
          return;
        }
      }
    }
    root.reject(where.find("ball") != std::string::npos ? "ball" : "person",
                where + ": " + status.error().what, status.error().cure);
  }
}

}  // namespace touchline::sim::scene
