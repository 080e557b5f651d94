// People of a recorded match from its true cameras and mattes.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "hub/hull/carve.h"
#include "hub/track/people_tracker.h"
#include "tests/support/folders.h"
#include "tools/score/oracle.h"
#include "tools/score/truth.h"

namespace touchline::track {
namespace {

TEST(TrackData, FollowsTheTruePeople) {
  const auto data = support::data_folder();
  if (!data || !std::filesystem::exists(*data / "recordings/dev-attack")) {
    GTEST_SKIP() << "no recordings/dev-attack: set TOUCHLINE_DATA";
  }
  const auto recording = recording::load_recording(*data / "recordings/dev-attack");
  ASSERT_TRUE(recording) << to_string(recording.error());
  const auto truth = score::Truth::open(*recording);
  ASSERT_TRUE(truth) << to_string(truth.error());
  score::OracleOptions options;
  options.tiles = false;
  auto oracle = score::Oracle::open(*recording, *truth, options);
  ASSERT_TRUE(oracle) << to_string(oracle.error());
  hull::HullOptions hull_options;
  hull_options.voxel_m = 0.04;
  PeopleTracker tracker(oracle->pitch());
  std::vector<double> errors;
  std::map<std::string, std::string> names;
  int changes = 0;
  for (std::int64_t frame = 0; frame < 8; ++frame) {
    const auto views = oracle->next();
    ASSERT_TRUE(views) << to_string(views.error());
    ASSERT_TRUE(*views);
    const hull::HullResult result = hull::carve(**views, oracle->pitch(), hull_options);
    const auto people = tracker.update(result.hull, **views, (**views)[0].stamp.media_time);
    for (const score::TruePerson& person : truth->people(frame)) {
      double nearest = 1.5;
      std::string name;
      for (const scene::Person& found : people) {
        if ((found.role == "ball") != person.is_ball()) continue;
        const double away = (found.position_in_world - person.position_in_world).head<2>().norm();
        if (away >= nearest) continue;
        nearest = away;
        name = found.id;
      }
      if (name.empty()) continue;
      errors.push_back(nearest);
      const auto [known, fresh] = names.try_emplace(person.id, name);
      changes += !fresh && known->second != name;
      known->second = name;
    }
  }
  ASSERT_GT(errors.size(), 8 * 20U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  EXPECT_LE(errors[errors.size() / 2], 0.3);
  EXPECT_EQ(changes, 0);
}

}  // namespace
}  // namespace touchline::track
