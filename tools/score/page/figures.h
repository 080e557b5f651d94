// Pictures of the worst frames.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/recording/recording.h"
#include "tools/score/page/page.h"
#include "tools/score/page/worst_frames.h"
#include "tools/score/truth.h"

namespace touchline::score::page {

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
