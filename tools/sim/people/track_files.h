// Tracks of players from providers' files: TRACAB .dat, Metrica's FIFA EPTS text, Last Row CSV, PFF
// JSON lines. Only what a path needs is read. Any bytes are read or refused.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "tools/sim/people/cast_spec.h"

namespace touchline::sim::people {

struct PlayerTrack {
  double rate_hz = 25;
  // By row of the file, metres from the centre spot; none where the player is not seen.
  std::vector<std::optional<Eigen::Vector2d>> places;
};

// `player` counts the people of the file in order of appearance. Formats that give shares of a
// pitch are spread over 105 m x 68 m.
base::Result<PlayerTrack> parse_track(std::string_view text, TrackFormat format, int player,
                                      const std::string& where);

}  // namespace touchline::sim::people
