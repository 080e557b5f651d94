#include "tools/score/people_score.h"

#include <algorithm>
#include <array>
#include <optional>

#include "tools/score/camera_score.h"
#include "tools/score/csv.h"

namespace touchline::score {

namespace {

constexpr double kReach = 1.5;  // metres
constexpr double kBallReach = 1.0;
constexpr double kHips = 0.9;

bool is_seen(const TruePerson& person, std::int64_t frame, const Truth& truth,
             std::span<const base::CameraId> cameras) {
  const Eigen::Vector3d hips =
      person.position_in_world + Eigen::Vector3d(0, 0, person.is_ball() ? 0 : kHips);
  return std::any_of(cameras.begin(), cameras.end(), [&](const base::CameraId& id) {
    const auto camera = truth.camera(id, frame);
    if (!camera) return false;
    const auto pixel = geometry::project(*camera, hips);
    return pixel && camera->model.sees(*pixel);
  });
}

struct Pair {
  double distance;
  std::size_t truth;
  std::size_t told;
};

// Nearest first, each person once.
std::vector<Pair> pair_up(const std::vector<TruePerson>& truth, const std::vector<TruePerson>& told,
                          bool balls, double reach) {
  std::vector<Pair> all;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t p = 0; p < told.size(); ++p) {
      if (truth[t].is_ball() != balls || told[p].is_ball() != balls) continue;
      const double distance =
          (truth[t].position_in_world - told[p].position_in_world).head<2>().norm();
      if (distance <= reach) all.push_back({distance, t, p});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
  std::vector<bool> truth_taken(truth.size(), false);
  std::vector<bool> told_taken(told.size(), false);
  std::vector<Pair> pairs;
  for (const Pair& pair : all) {
    if (truth_taken[pair.truth] || told_taken[pair.told]) continue;
    truth_taken[pair.truth] = true;
    told_taken[pair.told] = true;
    pairs.push_back(pair);
  }
  return pairs;
}

}  // namespace

base::Result<std::map<std::int64_t, std::vector<TruePerson>>> read_people(
    const std::filesystem::path& path) {
  const auto table = CsvTable::read(path);
  if (!table) return base::fail(table.error());
  constexpr std::array<const char*, 7> kNames = {"frame", "id", "team", "role", "x", "y", "z"};
  std::array<std::size_t, 7> at{};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto column = table->column(kNames[i]);
    if (!column) return base::fail(column.error());
    at[i] = *column;
  }
  std::map<std::int64_t, std::vector<TruePerson>> people;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    const auto frame = table->number(row, at[0]);
    if (!frame) return base::fail(frame.error());
    TruePerson person{table->text(row, at[1]), table->text(row, at[2]), table->text(row, at[3]),
                      Eigen::Vector3d::Zero()};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = table->number(row, at[4 + axis]);
      if (!value) return base::fail(value.error());
      person.position_in_world[static_cast<Eigen::Index>(axis)] = *value;
    }
    people[static_cast<std::int64_t>(*frame)].push_back(std::move(person));
  }
  return people;
}

PeopleScore score_people(const std::map<std::int64_t, std::vector<TruePerson>>& told,
                         const Truth& truth, std::span<const base::CameraId> cameras) {
  PeopleScore score;
  std::vector<double> errors;
  std::vector<double> ball_errors;
  std::map<std::string, std::string> names;
  for (const auto& [frame, people] : told) {
    const std::vector<TruePerson>& real = truth.people(frame);
    if (real.empty()) continue;
    ++score.frames;
    std::vector<bool> seen(real.size());
    for (std::size_t t = 0; t < real.size(); ++t) {
      seen[t] = is_seen(real[t], frame, truth, cameras);
      (real[t].is_ball() ? score.ball_frames : score.expected) += seen[t];
    }
    const std::vector<Pair> pairs = pair_up(real, people, false, kReach);
    for (const Pair& pair : pairs) {
      errors.push_back(pair.distance);
      score.found += seen[pair.truth];
      const auto [known, fresh] = names.try_emplace(real[pair.truth].id, people[pair.told].id);
      score.id_changes += !fresh && known->second != people[pair.told].id;
      known->second = people[pair.told].id;
    }
    const auto persons = static_cast<std::size_t>(
        std::count_if(people.begin(), people.end(), [](const auto& p) { return !p.is_ball(); }));
    score.extra += persons - pairs.size();
    for (const Pair& pair : pair_up(real, people, true, kBallReach)) {
      ball_errors.push_back(pair.distance);
      score.ball_found += seen[pair.truth];
    }
  }
  score.median_m = quantile(errors, 0.5);
  score.p95_m = quantile(errors, 0.95);
  score.ball_median_m = quantile(ball_errors, 0.5);
  return score;
}

}  // namespace touchline::score
