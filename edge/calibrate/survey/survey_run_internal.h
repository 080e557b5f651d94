// One survey on a pitch of given sizes: starts, searches, solves and judges.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge/calibrate/survey/survey.h"

namespace touchline::calibrate {

// `head`: the maps are of one head's stills; else of frames of one camera that does not move.
base::Result<SurveyResult> run_survey(const std::vector<LineMap>& maps,
                                      const pitch::PitchModel& pitch, Side side,
                                      const SurveyOptions& options, bool head);

// The survey on the pitch as given; again with what it finds of the sizes that were not stated.
base::Result<SurveyResult> survey_on_any_size(const std::vector<LineMap>& maps,
                                              const pitch::PitchModel& pitch, Side side,
                                              const SurveyOptions& options, bool head);

// Which of length, width and crown were not stated, or are refuted, can be told from the pictures,
// and are not yet as the pictures have them. A result with any is provisional: its fit was not
// judged.
Eigen::Array<bool, 3, 1> sizes_to_find(const SurveyOptions& options, const SurveyResult& result);

}  // namespace touchline::calibrate
