// Which sets there are. A new one: its header, a line here, its source in CMakeLists.txt.
#include "tools/score/sets/broadcast_clips.h"
#include "tools/score/sets/pitch_keypoints.h"
#include "tools/score/sets/pitch_lines.h"
#include "tools/score/sets/set_report.h"

namespace touchline::score {

const std::vector<SetEntry>& sets() {
  static const std::vector<SetEntry> kSets = {
      {"pitch-lines",
       "clicked points on the lines of 1054 broadcast frames, beside published cameras",
       run_pitch_lines},
      {"pitch-keypoints",
       "labelled points in 97 views of four matches: one position over many views",
       run_pitch_keypoints},
      {"broadcast-clips",
       "five television clips through the edge's chain, against what was drawn on them",
       run_broadcast_clips},
  };
  return kSets;
}

}  // namespace touchline::score
