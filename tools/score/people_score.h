// How well people were found and followed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct PeopleScore {
  std::size_t frames = 0;
  std::size_t expected = 0;  // true people whose hips at least one camera's picture holds
  std::size_t found = 0;     // of these, with someone told within 1.5 m
  std::size_t extra = 0;     // told, and nobody there, seen or not
  std::size_t id_changes = 0;
  double median_m = 0;  // distances in plan
  double p95_m = 0;
  std::size_t ball_frames = 0;
  std::size_t ball_found = 0;  // within 1 m
  double ball_median_m = 0;
};

// Rows of people.csv by frame; columns beyond those of the truth are passed over.
base::Result<std::map<std::int64_t, std::vector<TruePerson>>> read_people(
    const std::filesystem::path& path);

// Over the frames that `told` has. `cameras` are the recording's.
PeopleScore score_people(const std::map<std::int64_t, std::vector<TruePerson>>& told,
                         const Truth& truth, std::span<const base::CameraId> cameras);

}  // namespace touchline::score
