// How far a survey may be off: its joint covariance, with the noise that its residuals show, with
// the pitch's sizes as unsure as they were, and with the doubt whether the head has a pupil offset.
#pragma once

#include "edge/calibrate/survey/survey_solve.h"

namespace touchline::calibrate {

// `options` are those of the solution, with covariance wanted; size_sigma is what is not known of
// each size (0 = measured). A head's pupil offset that the pictures do not bear out is set to 0,
// and the rest solved again: the Bayes factor of the two models decides (Kass and Raftery 1995,
// with priors of equal weight), and the covariance is of both, weighted by it. Sets the mount,
// heads and covariance of the problem, and the solution; of a camera that does not move, roll
// stands for the mount's levelling in the covariance.
void settle_survey(const SurveySolveOptions& options, SurveyProblem& problem,
                   SurveySolution& solution);

}  // namespace touchline::calibrate
