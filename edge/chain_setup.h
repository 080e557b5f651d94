// What the installer states about one camera.
#pragma once

#include <cstdint>

#include "edge/calibrate/initialise/side.h"
#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::edge {

enum class HeadKind : std::uint8_t {
  kHead,     // pans, tilts and zooms from one place
  kFixed,    // does not move
  kCloseup,  // a head that may show too few lines to be solved: lost is then an expected answer
};

struct ChainSetup {
  base::CameraId camera;
  HeadKind kind = HeadKind::kHead;
  calibrate::Side side = calibrate::Side::kMain;
  pitch::Sport sport = pitch::Sport::kSoccer;
  // As measured; what nobody measured is found by the survey where it can be.
  pitch::PitchSizes sizes;
  base::FrameRate rate;
};

}  // namespace touchline::edge
