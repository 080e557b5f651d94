// A folder with a page for people who would rather look: tables, plots over time and pictures of
// the worst frames.
#pragma once

#include <filesystem>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/report.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct PageOptions {
  std::filesystem::path folder;   // made where it is missing; index.html and pictures/ go there
  std::filesystem::path exports;  // what the report was made of
  double voxel_m = 0.02;          // as in ScoreOptions
  // Pictures of a score at most, each of another camera, person or view; 0..20.
  std::size_t worst_of_each = 2;
};

// index.html refers to files of its own folder only. Pictures that cannot be made (a video without
// that frame, an export that is not there) are left out, and the page says so.
base::Status write_page(const ScoreReport& report, const recording::Recording& recording,
                        const Truth& truth, const PageOptions& options);

}  // namespace touchline::score
