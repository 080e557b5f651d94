// Where a camera stands that does not move, from one picture and its side alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge/calibrate/survey/survey_step_internal.h"

namespace touchline::calibrate {

// The least score of a pose that is kept, by score_exact.
inline constexpr double kLeastStillScore = 0.7;

// Every place that explains the picture is solved, and the one that explains it best is taken where
// clearly less speaks against it than against any other. `maps` holds one map. Errors: kNumerical
// when no place explains the lines, or two do about as well.
base::Result<SurveyProblem> find_fixed_place(const std::vector<LineMap>& maps,
                                             const pitch::PitchModel& pitch, Side side,
                                             const SurveyOptions& options, const SurveyStep& step);

// No position explains the lines of `pictures` pictures.
tl::unexpected<base::Error> no_position(Side side, std::size_t pictures);

}  // namespace touchline::calibrate
