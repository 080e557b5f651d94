// A session's exports against a recording's truth, as figures, a table and JSON.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/camera_score.h"
#include "tools/score/hull_score.h"
#include "tools/score/matte_score.h"
#include "tools/score/people_score.h"
#include "tools/score/truth.h"
#include "tools/score/view_score.h"

namespace touchline::score {

// Folders as `touchline-hub export` and `render` write them: <exports>/cameras/<id>.csv,
// mattes/<id>/%06d.png, hull/%06d.ply, people/people.csv, renders/virtualNN/%06d.png. What is not
// there is not scored, and said.
struct ScoreOptions {
  std::filesystem::path exports;
  double voxel_m = 0.02;         // reach of the hull's score, metres, 0..0.1
  std::size_t most_mattes = 10;  // frames a camera, spread evenly; 0 = all
  std::size_t most_hulls = 6;    // frames, spread evenly; 0 = all
  std::size_t most_views = 15;
};

struct CameraViews {
  std::string camera;  // virtual
  std::vector<ViewScore> frames;
};

struct ScoreReport {
  std::string recording;
  std::vector<CameraScore> cameras;
  std::vector<MatteScore> mattes;
  std::vector<HullScore> hulls;
  std::optional<PeopleScore> people;
  std::vector<CameraViews> views;
  std::vector<std::string> not_scored;  // and why
};

base::Result<ScoreReport> score_exports(const recording::Recording& recording, const Truth& truth,
                                        const ScoreOptions& options);

std::string table_text(const ScoreReport& report);
std::string json_text(const ScoreReport& report);

}  // namespace touchline::score
