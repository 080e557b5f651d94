// The spherical plate of one mount, learnt from its live frames (chapter 4.3).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::plate {

struct PlateOptions {
  int learn_frames = 50;            // frames a tile is seen in before its median is fixed; 4..500
  int samples = 14;                 // samples in time kept of a pixel until then; 3..32
  int publish_frames = 25;          // after learning, frames between two versions; 1..10000
  int update_every = 10;            // a learnt tile takes in every n-th frame; calm: 4n; 1..1000
  double update_rate = 0.06;        // weight of a new sample in the running mean; 0.001..0.5
  double noise_codes = 3;           // least standard deviation, 10-bit code values; 0.25..50
  double filled_codes = 7;          // of luma where turf was interpolated, chroma's most; 1..200
  double bare_codes = 14;           // of all three where that may be bare ground; 1..200
  double turf_margin_m = 1.0;       // turf rules hold this far beyond the outer lines; 0..20
  double line_tolerance_m = 0.08;   // a painted line may lie this far beside the model; 0..0.5
  double line_tolerance_px = 2.0;   // and this far in plate pixels; 0..10
  double occluder_margin_px = 3.0;  // margin round goal frames and nets, plate pixels; 0..20
  int resumed_frames = 4;           // frames that a saved plate counts for; 2..255
  std::uint32_t first_version = 1;  // of the first snapshot: a plate in place of another counts on
  int max_tiles = 300;  // the oldest are dropped beyond; a tile takes 2 to 5 MB; 8..4096

  base::Status validate() const;
  PlateOptions bounded() const;  // with what is out of its bounds replaced by the nearest bound
};

// Turf is learnt only from samples that look like turf, or like paint beside a marking of the pitch
// model, so that people who stand still stay out; where people cover turf in every frame it comes
// from the survey stills or from its surroundings with count 0 and a raised deviation. Off the turf
// the temporal median rules. Deterministic: the snapshot depends on the frames and their order
// only.
class PlateBuilder {
 public:
  // `radians_per_px` about 1 / (longest focal length in pixels); `centre_in_world` the mount's
  // position. Options out of their bounds are replaced by the nearest bound.
  PlateBuilder(const pitch::PitchModel& pitch, const Eigen::Vector3d& centre_in_world,
               double radians_per_px, const PlateOptions& options = {});
  ~PlateBuilder();
  PlateBuilder(PlateBuilder&&) noexcept;
  PlateBuilder& operator=(PlateBuilder&&) noexcept;

  // Before the first frame: goes on from what was learnt earlier of the same camera in the same
  // place, at the scale and colour of this plate; a later version of it is the first one here. It
  // is what the plate shows where live frames do not say otherwise: four of them that agree win
  // over it, and it goes with their light. kArgument where scale or colour are others, or the
  // centre lies farther away than `most_moved_m`.
  base::Status resume(const image::PlateSnapshot& saved, double most_moved_m);
  // Of the pixels that live frames have told so far, how many look another way than in the plate
  // that was resumed, whatever the light; nothing until enough of them are told, or without one.
  // What live frames have not told is forgotten when that is more than half.
  std::optional<double> resumed_apart() const;

  // A survey still: its turf gives the mean where the video never shows it, after an affine colour
  // fit to the video. Seats, hoardings and people of stills are not used. Nothing if lost.
  void seed(const image::Frame& still, const geometry::CameraEstimate& estimate);

  // A live frame, compensated. Nothing if lost, or if the frame's size is not the model's.
  void add(const image::Frame& frame, const geometry::CameraEstimate& estimate);

  // The plate so far. The same object as before until enough frames came in (PlateOptions), or
  // `fresh` asks for all there is, as at the end of the hold-back, and unless they tell anything
  // new. Tiles without news are those of the version before (SharedPlateTile::is). A version never
  // changes.
  std::shared_ptr<const image::PlateSnapshot> snapshot(bool fresh = false);

  int frames() const;  // live frames taken in

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::plate
