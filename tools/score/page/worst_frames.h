// Which frames the page shows: the worst of each score.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "tools/score/report.h"

namespace touchline::score::page {

// A frame of a subject that is the worst in some scores of its group.
struct WorstFrame {
  std::string group;
  std::string subject;
  std::int64_t frame = 0;
  std::vector<std::string> reasons;  // "rms_px 3.21 px, on average 0.40"
  std::string id() const;            // of its figure in the page
};

// For each score the worst sample of the subjects it is worst for, at most `of_each`, clear
// successes left out. A score's "all" is passed over where there are others. Frames
// that several scores name come once; one that is shown already stands for one a tenth worse. In
// order of the report's groups.
std::vector<WorstFrame> worst_frames(const std::vector<Series>& series, std::size_t of_each);

// How bad a value is; larger is worse, 0 is perfect where perfect is known.
double badness(const ScoreKind& kind, double value);

}  // namespace touchline::score::page
