// A session's exports against a recording's truth, as series of figures, a table and JSON.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/series.h"
#include "tools/score/truth.h"

namespace touchline::score {

// Folders as `touchline-hub export` and `render` write them: <exports>/cameras/<id>.csv,
// mattes/<id>/%06d.png, hull/%06d.ply, people/people.csv, renders/virtualNN/%06d.png and
// foreground/virtualNN/%06d.png (render --foreground). What is not there is not scored, and said.
struct ScoreOptions {
  std::filesystem::path exports;
  double voxel_m = 0.02;        // reach of the hull's score, metres, 0..0.1
  double dilation_px = 3;       // of the true mattes whose hull is the volume's measure, 0..10
  std::size_t most_mattes = 0;  // frames a camera, spread evenly; 0 = all
  std::size_t most_hulls = 0;   // frames, spread evenly; 0 = all that have a true mesh
  std::size_t most_views = 0;   // frames a virtual camera; 0 = all
  bool oracle = true;           // also render with true cameras and true mattes; takes the longest
};

// The table is a row a series.
struct ScoreReport {
  std::string recording;  // its name
  std::vector<Series> series;
  std::vector<std::string> not_scored;  // what, and why
  std::vector<std::string> notes;       // how to read the figures of this report

  // None when there is no such series; "all" of a kind with one subject is that subject's.
  const Series* find(const std::string& group, const std::string& score,
                     const std::string& subject) const;
};

base::Result<ScoreReport> score_exports(const recording::Recording& recording, const Truth& truth,
                                        const ScoreOptions& options);

struct TableOptions {
  bool each_person = false;  // rows of single people; they are in the JSON always
};
std::string table_text(const ScoreReport& report, const TableOptions& options = {});
// The schema is in tools/README.md.
std::string json_text(const ScoreReport& report);

}  // namespace touchline::score
