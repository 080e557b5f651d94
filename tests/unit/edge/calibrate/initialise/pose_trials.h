// Cameras drawn by chance, each looked for in the picture of its pitch: how many are found, how
// many wrongly.
#pragma once

#include <cstdint>
#include <string>

#include "shared/pitch/pitch_model.h"

namespace touchline::calibrate {

struct TrialCount {
  int trials = 0;
  int found = 0;
  int wrong = 0;     // found, and more than 8 px off over the turf in sight, at 540 lines
  int in_sight = 0;  // three lines or more in sight, along the pitch and across it
  int found_in_sight = 0;
  std::string wrong_seeds;
  double found_share() const {
    return in_sight > 0 ? static_cast<double>(found_in_sight) / in_sight : 1;
  }
};

// Match heads whose mount is known to a few centimetres, through the Initialiser.
TrialCount try_initialiser(pitch::Sport sport, int trials, std::uint32_t first_seed);
// Fixed cameras of which only the side is known, through survey_fixed.
TrialCount try_survey_fixed(pitch::Sport sport, int trials, std::uint32_t first_seed);

}  // namespace touchline::calibrate
