// The difference key: people and ball against the plate (chapter 4.3).
#pragma once

#include <memory>

#include "edge/key/colour_training.h"
#include "edge/state/key_result.h"
#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::key {

struct KeyOptions {
  double weak_sigma = 5.0;          // difference at which a pixel may belong to a person; 1..50
  double strong_sigma = 12.0;       // difference that starts a person; weak_sigma..200
  double noise_codes = 4;           // camera noise, 10-bit code values; 0.5..50
  double calibration_px = 0.7;      // standard error of the calibration in the picture; 0..5
  double darkest_shadow = 0.4;      // luma of turf in shadow over turf in light, least; 0.05..1
  double brightest_turf = 1.25;     // luma of turf over the plate's, most; 1..3
  double margin_m = 5;              // people stand at most this far beyond the outer lines; 0..50
  double tallest_m = 2.6;           // and reach this high; 1..5
  double alike_reach_m = 0.45;      // from a body, where its own colours in the plate hide it; 0..2
  double occluder_margin_px = 2.5;  // margin round goal frames, nets and flags; 0..20
  ColourTraining colours;           // what the operator clicked on; none: it changes nothing

  base::Status validate() const;
};

// The matte of a compensated frame of any size the estimate's model has. Alpha is 0 outside the
// volume in which people can be (the pitch, `margin_m` round it, up to `tallest_m`): nobody stands
// in the sky or on the upper stands, and the crowd moves. Goal frames, nets and flag poles are
// occluders and unknown. Unknown is also what shows the plate close to a person in a colour that he
// wears: there the two cannot be told apart. A lost camera, or a frame that is not of the model's
// size, gives a matte of the frame's size with alpha 0 and everything unknown. Options out of their
// bounds are replaced by the nearest bound.
state::KeyResult key(const image::Frame& frame, const geometry::CameraEstimate& camera,
                     const image::PlateSnapshot& plate, const pitch::PitchModel& pitch,
                     const KeyOptions& options = {});

// Keys frame after frame of one camera: the same results, but what was prepared of a plate is kept
// for as long as the plate stays the same. It holds the plate it was given last.
class Keyer {
 public:
  Keyer();
  ~Keyer();
  Keyer(Keyer&&) noexcept;
  Keyer& operator=(Keyer&&) noexcept;

  state::KeyResult key(const image::Frame& frame, const geometry::CameraEstimate& camera,
                       const std::shared_ptr<const image::PlateSnapshot>& plate,
                       const pitch::PitchModel& pitch, const KeyOptions& options = {});

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace touchline::key
