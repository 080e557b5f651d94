// The conservative visual hull of one instant (chapter 4.4.1; Kilner, Starck, Hilton, "A
// comparative study of free-viewpoint video techniques for sports events", 2006).
//
// Every silhouette is dilated by a bound on calibration and matting errors before the cones are
// intersected, so that each true surface point stays inside. Cameras here look at part of the pitch
// only, so the rule of who may carve is explicit:
//  - a camera takes part unless its estimate is lost or its matte is absent;
//  - it carves nothing outside its picture, nor within the dilation of the picture's border, nor
//    where its matte is unknown or occluded (dilated likewise);
//  - a point is in the hull when no camera carves it, at least one camera sees it inside its
//  dilated
//    foreground, and at least `min_support` inside their dilated foreground or what is unknown or
//    occluded to them; but a component has points that are foreground to `min_support` cameras.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hub/scene/hull.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::hull {

struct HullOptions {
  double voxel_m = 0.02;      // spacing of the samples, metres, 0.005..0.2
  double dilation_px = 3;     // bound on calibration and matting errors, pixels, 0..10
  int alpha_threshold = 128;  // coverage that counts as foreground, 1..255 (1: any)
  int min_support = 2;        // cameras to which a point must be, or may be, foreground, 1..6
  // Where two cameras see foreground that the hull explains in neither, one camera that carves
  // there is taken to be wrong: its matte has a hole.
  bool heal = true;
  double margin_m = 8;         // how far beyond the pitch people are looked for, metres, 0..50
  double below_turf_m = 0.04;  // the hull is closed this far below the turf, metres, 0..0.5
  double people_height_m =
      2.8;                   // what is larger than a ball ends here above the turf, metres, 1..6
  double ball_height_m = 8;  // and a ball here, metres, people_height_m..40
  double min_volume_m3 = 0.004;  // smaller components are dropped: a ball has 0.0056, 0..1
  double max_ball_m = 0.8;       // longest side of the box round what may be a ball, metres, 0.2..3
  // Share of a component's foreground pixels, in each camera that sees it, that no heavier
  // component explains, below which it is a phantom; 0..1.
  double phantom_share = 0.03;
  int min_billboard_px =
      60;  // smaller silhouettes of one camera get no billboard, pixels, 1..100000

  // kConfiguration, naming field, value and bound.
  base::Status validate() const;
};

// What became of a camera's view.
enum class Participation { kCarved, kLost, kWithoutMatte, kWrongSize };
std::string_view name(Participation participation);

struct CameraReport {
  base::CameraId camera;
  Participation participation = Participation::kWithoutMatte;
  std::size_t foreground_px = 0;  // at or above the threshold
  std::size_t covered_px = 0;     // of these, inside the projection of a group that is no phantom
};

struct HullReport {
  std::vector<CameraReport> cameras;  // in the order of the views
  std::size_t cells = 0;              // cells that were tested on the way down
  std::size_t bricks = 0;             // bricks of 8 x 8 x 8 samples that were evaluated
  std::size_t inside_samples = 0;
  std::size_t healed_samples = 0;  // of these, carved by one camera against two
  std::size_t dropped = 0;         // components too small, or too high above the turf
  std::size_t phantoms = 0;
};

struct HullResult {
  scene::Hull hull;
  HullReport report;
};

// Groups are the 6-connected components of the samples inside. Their surfaces are closed and each
// edge belongs to exactly two triangles.
//
// A component is a phantom when heavier components explain its foreground pixels in every camera
// that sees it (up to phantom_share). Weight is the volume, a quarter of it for what floats above
// the turf and is no ball. A phantom stays in the list, flagged.
//
// A silhouette that no group covers becomes a billboard: it stands where the ray of its lowest
// point meets the turf, or, cut by the lower border, where its top would be 1.8 m high.
//
// `options` must be valid. Bytes do not depend on the number of threads of the surrounding TBB
// arena.
HullResult carve(std::span<const codec::CameraView> views, const pitch::PitchModel& pitch,
                 const HullOptions& options);

}  // namespace touchline::hull
