#include "tools/sim/people/track_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/sim/people/text_scan_internal.h"

namespace touchline::sim::people {
namespace {

constexpr std::size_t kMostRows = 400000;

// Rows in the order of the file; a person's number is that of his first appearance.
class Collector {
 public:
  explicit Collector(int player) : player_(player) {}
  void row() { places_.emplace_back(); }
  bool full() const { return places_.size() > kMostRows; }
  void see(const std::string& key, const Eigen::Vector2d& place) {
    const auto [found, fresh] = number_.try_emplace(key, static_cast<int>(number_.size()));
    if (found->second == player_ && !places_.empty()) places_.back() = place;
  }
  base::Result<PlayerTrack> finish(double rate, const std::string& where) {
    std::size_t seen = 0;
    for (const auto& p : places_) seen += p.has_value() ? 1 : 0;
    if (seen == 0) {
      return base::fail(base::ErrorKind::kNotFound, where,
                        fmt::format("no player {}, there are {}", player_, number_.size()),
                        "count from 0 in order of appearance");
    }
    return PlayerTrack{rate, std::move(places_)};
  }

 private:
  int player_;
  std::map<std::string, int> number_;
  std::vector<std::optional<Eigen::Vector2d>> places_;
};

base::Error bad_row(const std::string& where, std::size_t line, const char* what) {
  return base::Error{base::ErrorKind::kFormat, fmt::format("{}:{}", where, line), what, {}};
}

// "frame:team,target,jersey,x,y,speed;...:ball...:" in centimetres; teams 0 and 1 play, 3 and 4 do
// not.
base::Result<PlayerTrack> parse_tracab(std::string_view text, int player,
                                       const std::string& where) {
  Collector people(player);
  std::size_t number = 0;
  while (auto line = next_line(text)) {
    ++number;
    if (trimmed(*line).empty()) continue;
    const auto frame = next_field(*line, ':');
    auto players = next_field(*line, ':');
    if (!frame || !to_long(*frame) || !players || people.full()) {
      return base::fail(bad_row(where, number, "not 'frame:players:ball:'"));
    }
    people.row();
    while (auto one = next_field(*players, ';')) {
      if (one->empty()) continue;
      std::array<std::string_view, 5> field;
      for (auto& f : field) {
        const auto part = next_field(*one, ',');
        if (!part) return base::fail(bad_row(where, number, "a player with too few fields"));
        f = *part;
      }
      const auto x = to_double(field[3]);
      const auto y = to_double(field[4]);
      if (!x || !y || std::abs(*x) > 1e5 || std::abs(*y) > 1e5) {
        return base::fail(bad_row(where, number, "a player's place is no number"));
      }
      if (field[0] == "0" || field[0] == "1" || field[0] == "3") {
        people.see(std::string(field[1]), {*x / 100, *y / 100});
      }
    }
  }
  return people.finish(25, where);
}

// "frame:x,y,id,speed;...:ball" in shares of the pitch.
base::Result<PlayerTrack> parse_epts(std::string_view text, int player, const std::string& where) {
  Collector people(player);
  std::size_t number = 0;
  while (auto line = next_line(text)) {
    ++number;
    if (trimmed(*line).empty()) continue;
    const auto frame = next_field(*line, ':');
    auto players = next_field(*line, ':');
    if (!frame || !to_long(*frame) || !players || people.full()) {
      return base::fail(bad_row(where, number, "not 'frame:players:ball'"));
    }
    people.row();
    int slot = 0;
    while (auto one = next_field(*players, ';')) {
      const std::string key = fmt::format("{}", slot++);
      const auto x_text = next_field(*one, ',');
      const auto y_text = next_field(*one, ',');
      if (!x_text || !y_text) return base::fail(bad_row(where, number, "a player without x,y"));
      if (*x_text == "NaN" || *y_text == "NaN") continue;
      const auto x = to_double(*x_text);
      const auto y = to_double(*y_text);
      if (!x || !y || std::abs(*x) > 10 || std::abs(*y) > 10) {
        return base::fail(bad_row(where, number, "a player's place is no share of the pitch"));
      }
      people.see(key, {(*x - 0.5) * 105, (0.5 - *y) * 68});
    }
  }
  return people.finish(25, where);
}

// CSV, a row a player and frame, x and y in 0..100 of the pitch; the row without a number is the
// ball.
base::Result<PlayerTrack> parse_last_row(std::string_view text, int player,
                                         const std::string& where) {
  std::map<int, std::map<std::string, Eigen::Vector2d>> frames;
  std::vector<std::string> order;
  const auto header = next_line(text);
  if (!header || header->rfind("player,frame,x,y", 0) != 0) {
    return base::fail(bad_row(where, 1, "not 'player,frame,x,y,...'"));
  }
  std::size_t number = 1;
  while (auto line = next_line(text)) {
    ++number;
    if (trimmed(*line).empty()) continue;
    const auto who = next_field(*line, ',');
    const auto frame_text = next_field(*line, ',');
    const auto x_text = next_field(*line, ',');
    const auto y_text = next_field(*line, ',');
    if (!who || !frame_text || !x_text || !y_text) {
      return base::fail(bad_row(where, number, "too few fields"));
    }
    const long frame = to_long(*frame_text).value_or(-1);
    const double x = to_double(*x_text).value_or(1e9);
    const double y = to_double(*y_text).value_or(1e9);
    if (frame < 0 || frame > static_cast<long>(kMostRows) || std::abs(x) > 1e4 ||
        std::abs(y) > 1e4) {
      return base::fail(bad_row(where, number, "bad player, frame, x or y"));
    }
    if (*who == "0") continue;  // the ball
    const std::string key(*who);
    if (std::find(order.begin(), order.end(), key) == order.end()) {
      if (order.size() > 100) return base::fail(bad_row(where, number, "more than 100 players"));
      order.push_back(key);
    }
    frames[static_cast<int>(frame)][key] = {(x / 100 - 0.5) * 105, (y / 100 - 0.5) * 68};
  }
  if (player < 0 || player >= static_cast<int>(order.size())) {
    return base::fail(base::ErrorKind::kNotFound, where,
                      fmt::format("no player {}, there are {}", player, order.size()),
                      "count from 0 in order of appearance");
  }
  PlayerTrack track;
  track.rate_hz = 20;
  const std::string& key = order[static_cast<std::size_t>(player)];
  for (const auto& [frame, places] : frames) {
    track.places.resize(static_cast<std::size_t>(frame) + 1);
    const auto found = places.find(key);
    if (found != places.end()) track.places.back() = found->second;
  }
  return track;
}

// JSON lines with homePlayers and awayPlayers of {jerseyNum, x, y}, metres from the centre.
base::Result<PlayerTrack> parse_pff(std::string_view text, int player, const std::string& where) {
  Collector people(player);
  std::size_t number = 0;
  while (auto line = next_line(text)) {
    ++number;
    if (trimmed(*line).empty()) continue;
    int depth = 0;
    for (const char c : *line) {
      depth += (c == '[' || c == '{') - (c == ']' || c == '}');
      if (depth > 64) return base::fail(bad_row(where, number, "nested too deeply"));
    }
    const auto row = nlohmann::json::parse(line->begin(), line->end(), nullptr, false);
    if (!row.is_object() || people.full()) {
      return base::fail(bad_row(where, number, "not a JSON object"));
    }
    people.row();
    for (const char* side : {"homePlayers", "awayPlayers"}) {
      const auto list = row.find(side);
      if (list == row.end() || !list->is_array()) continue;
      for (const auto& one : *list) {
        if (!one.is_object()) continue;
        const auto jersey = one.find("jerseyNum");
        const auto x = one.find("x");
        const auto y = one.find("y");
        if (jersey == one.end() || !jersey->is_string() || x == one.end() || y == one.end() ||
            !x->is_number() || !y->is_number()) {
          continue;
        }
        const Eigen::Vector2d place(x->get<double>(), y->get<double>());
        if (place.allFinite() && place.norm() < 1000) {
          people.see(std::string(side) + jersey->get<std::string>(), place);
        }
      }
    }
  }
  return people.finish(29.97, where);
}

}  // namespace

base::Result<PlayerTrack> parse_track(std::string_view text, TrackFormat format, int player,
                                      const std::string& where) {
  switch (format) {
    case TrackFormat::kTracab:
      return parse_tracab(text, player, where);
    case TrackFormat::kEpts:
      return parse_epts(text, player, where);
    case TrackFormat::kLastRow:
      return parse_last_row(text, player, where);
    case TrackFormat::kPff:
      return parse_pff(text, player, where);
  }
  return base::fail(base::ErrorKind::kUnsupported, where, "unknown track format");
}

}  // namespace touchline::sim::people
