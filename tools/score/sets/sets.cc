// Which sets there are. A new one: its header, a line here, its source in CMakeLists.txt.
#include "tools/score/sets/broadcast_clips.h"
#include "tools/score/sets/keying_cdnet_highway.h"
#include "tools/score/sets/keying_lemur.h"
#include "tools/score/sets/multiview_wd2_person.h"
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
      {"multiview-wd2-person",
       "a person before 16 cameras: each left out in turn, hull and view of the others against it",
       run_multiview_wd2_person},
      {"keying-cdnet-highway",
       "160 labelled frames of a static camera, beside OpenCV's MOG2 and KNN",
       run_keying_cdnet_highway},
      {"keying-lemur", "one picture with true coverage, beside OpenCV's matting", run_keying_lemur},
  };
  return kSets;
}

}  // namespace touchline::score
