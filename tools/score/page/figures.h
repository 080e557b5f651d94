// Pictures of the worst frames: which, and what is shown of them.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/page/page.h"
#include "tools/score/report.h"
#include "tools/score/truth.h"

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

struct Shot {
  std::string file;   // relative to the page's folder; or
  std::string svg;    // an element of its own
  std::string what;   // what it shows
  bool wide = false;  // over the whole width of the page
};

struct Figure {
  WorstFrame frame;
  std::vector<Shot> shots;
  std::vector<Shot> blink;  // two pictures shown in turn
  std::string missing;      // why there is no picture
};

// Makes the pictures in <options.folder>/pictures. Each video is decoded once.
base::Result<std::vector<Figure>> make_figures(const std::vector<WorstFrame>& frames,
                                               const recording::Recording& recording,
                                               const Truth& truth, const PageOptions& options);

}  // namespace touchline::score::page
