#include "tools/score/people_score.h"

#include <algorithm>
#include <array>
#include <optional>

#include "tools/score/csv.h"
#include "tools/score/score_context.h"

namespace touchline::score {

namespace {

constexpr double kReach = 1.5;  // metres
constexpr double kBallReach = 1.0;
constexpr double kHips = 0.9;

const ScoreKind kFound{"people", "found", "%", Better::kHigher, Statistic::kMean, 2};
const ScoreKind kExtra{"people", "extra a frame", "", Better::kLower, Statistic::kMean, 2};
const ScoreKind kError{"people", "position error", "m", Better::kLower, Statistic::kMean, 3};
const ScoreKind kHonesty{"people",     "error over stated sd",     "",
                         Better::kOne, Statistic::kRootMeanSquare, 2};
const ScoreKind kChanges{"people", "id changes", "", Better::kLower, Statistic::kTotal, 0};
const ScoreKind kBallFound{"people", "ball found", "%", Better::kHigher, Statistic::kMean, 1};
const ScoreKind kBallError{"people", "ball error", "m", Better::kLower, Statistic::kMean, 3};

bool is_seen(const TruePerson& person, const std::vector<geometry::CameraEstimate>& cameras) {
  const Eigen::Vector3d hips =
      person.position_in_world + Eigen::Vector3d(0, 0, person.is_ball() ? 0 : kHips);
  return std::any_of(cameras.begin(), cameras.end(), [&](const auto& camera) {
    const auto pixel = geometry::project(camera, hips);
    return pixel && camera.model.sees(*pixel);
  });
}

void score_frame(std::int64_t frame, const std::vector<TruePerson>& truth,
                 const std::vector<ToldPerson>& told,
                 const std::vector<geometry::CameraEstimate>& cameras,
                 std::map<std::string, std::string>& names, SeriesBook& book) {
  std::vector<bool> seen(truth.size());
  for (std::size_t t = 0; t < truth.size(); ++t) seen[t] = is_seen(truth[t], cameras);
  std::vector<bool> found(truth.size(), false);
  const std::vector<PersonPair> pairs = pair_people(truth, told, false, kReach);
  const std::vector<PersonPair> balls = pair_people(truth, told, true, kBallReach);
  for (const PersonPair& pair : pairs) found[pair.truth] = true;
  for (const PersonPair& pair : balls) found[pair.truth] = true;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    if (!seen[t]) continue;
    const double value = found[t] ? 100 : 0;
    if (truth[t].is_ball()) {
      book.add(kBallFound, "ball", {frame, value});
    } else {
      book.add_person(kFound, truth[t].id, {frame, value});
    }
  }
  for (const PersonPair& pair : pairs) {
    const std::string& id = truth[pair.truth].id;
    const ToldPerson& is = told[pair.told];
    book.add_person(kError, id, {frame, pair.distance_m});
    if (is.sd_m && is.sd_m->minCoeff() > 0) {
      const Eigen::Vector3d error =
          is.person.position_in_world - truth[pair.truth].position_in_world;
      book.add_person(kHonesty, id, {frame, error.x() / is.sd_m->x()});
      book.add_person(kHonesty, id, {frame, error.y() / is.sd_m->y()});
    }
    const auto [known, fresh] = names.try_emplace(id, is.person.id);
    const bool changed = !fresh && known->second != is.person.id;
    known->second = is.person.id;
    book.add_person(kChanges, id, {frame, changed ? 1.0 : 0.0});
  }
  for (const PersonPair& pair : balls) book.add(kBallError, "ball", {frame, pair.distance_m});
  const auto people = std::count_if(told.begin(), told.end(),
                                    [](const ToldPerson& p) { return !p.person.is_ball(); });
  book.add(kExtra, "all", {frame, static_cast<double>(people) - static_cast<double>(pairs.size())});
}

}  // namespace

base::Result<ToldPeople> read_told_people(const std::filesystem::path& path) {
  const auto table = CsvTable::read(path);
  if (!table) return base::fail(table.error());
  constexpr std::array<const char*, 7> kNames = {"frame", "id", "team", "role", "x", "y", "z"};
  std::array<std::size_t, 7> at{};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    const auto column = table->column(kNames[i]);
    if (!column) return base::fail(column.error());
    at[i] = *column;
  }
  const bool with_sd = table->has("sd_x") && table->has("sd_y");
  ToldPeople people;
  for (std::size_t row = 0; row < table->rows(); ++row) {
    const auto frame = table->frame(row, at[0]);
    if (!frame) return base::fail(frame.error());
    ToldPerson told;
    told.person.id = table->text(row, at[1]);
    told.person.team = table->text(row, at[2]);
    told.person.role = table->text(row, at[3]);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto value = table->number(row, at[4 + axis]);
      if (!value) return base::fail(value.error());
      told.person.position_in_world[static_cast<Eigen::Index>(axis)] = *value;
    }
    if (with_sd) {
      const auto x = table->number(row, *table->column("sd_x"));
      if (!x) return base::fail(x.error());
      const auto y = table->number(row, *table->column("sd_y"));
      if (!y) return base::fail(y.error());
      told.sd_m = Eigen::Vector2d(*x, *y);
    }
    people[*frame].push_back(std::move(told));
  }
  return people;
}

base::Result<std::map<std::int64_t, std::vector<TruePerson>>> read_people(
    const std::filesystem::path& path) {
  const auto told = read_told_people(path);
  if (!told) return base::fail(told.error());
  std::map<std::int64_t, std::vector<TruePerson>> people;
  for (const auto& [frame, rows] : *told) {
    for (const ToldPerson& row : rows) people[frame].push_back(row.person);
  }
  return people;
}

std::vector<PersonPair> pair_people(const std::vector<TruePerson>& truth,
                                    const std::vector<ToldPerson>& told, bool balls,
                                    double reach_m) {
  std::vector<PersonPair> all;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    for (std::size_t p = 0; p < told.size(); ++p) {
      if (truth[t].is_ball() != balls || told[p].person.is_ball() != balls) continue;
      const Eigen::Vector3d offset = truth[t].position_in_world - told[p].person.position_in_world;
      const double distance = balls ? offset.norm() : offset.head<2>().norm();
      if (distance <= reach_m) all.push_back({t, p, distance});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const PersonPair& a, const PersonPair& b) {
    return a.distance_m < b.distance_m;
  });
  std::vector<bool> truth_taken(truth.size(), false);
  std::vector<bool> told_taken(told.size(), false);
  std::vector<PersonPair> pairs;
  for (const PersonPair& pair : all) {
    if (truth_taken[pair.truth] || told_taken[pair.told]) continue;
    truth_taken[pair.truth] = true;
    told_taken[pair.told] = true;
    pairs.push_back(pair);
  }
  return pairs;
}

base::Status score_people(const Context& context, SeriesBook& book, Remarks& remarks) {
  const auto path = context.options.exports / "people" / "people.csv";
  if (!context.truth.has_people()) {
    remarks.not_scored.push_back("people: the truth has no people.csv");
    return {};
  }
  if (!is_there(path)) {
    remarks.not_scored.push_back(fmt::format("people: no {}", path.string()));
    return {};
  }
  const auto told = read_told_people(path);
  if (!told) return base::fail(told.error());
  const std::vector<ToldPerson> nobody;
  std::map<std::string, std::string> names;
  for (const std::int64_t frame : context.truth.people_frames()) {
    const auto at = told->find(frame);
    score_frame(frame, context.truth.people(frame), at == told->end() ? nobody : at->second,
                context.cameras(frame), names, book);
  }
  return {};
}

}  // namespace touchline::score
