// How well people were found and followed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "shared/base/result.h"
#include "tools/score/truth.h"

namespace touchline::score {

// A row of an exported people.csv.
struct ToldPerson {
  TruePerson person;
  std::optional<Eigen::Vector2d> sd_m;  // stated, where there are the columns sd_x and sd_y
};
using ToldPeople = std::map<std::int64_t, std::vector<ToldPerson>>;

// By frame; columns beyond those of formats.md are passed over.
base::Result<ToldPeople> read_told_people(const std::filesystem::path& path);
// The same without what they state about themselves.
base::Result<std::map<std::int64_t, std::vector<TruePerson>>> read_people(
    const std::filesystem::path& path);

// A true person and who was told there.
struct PersonPair {
  std::size_t truth = 0;
  std::size_t told = 0;
  double distance_m = 0;  // in plan; of balls in space
};

// People (balls: true) within `reach_m` of each other, nearest first, each once.
std::vector<PersonPair> pair_people(const std::vector<TruePerson>& truth,
                                    const std::vector<ToldPerson>& told, bool balls,
                                    double reach_m);

}  // namespace touchline::score
