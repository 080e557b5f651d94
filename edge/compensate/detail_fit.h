// Fits the boost to averaged edge profiles.
#pragma once

#include <map>

#include "edge/compensate/detail_estimator.h"

namespace touchline::compensate {

state::DetailModel fit_detail(
    const std::map<DetailEstimator::Class, DetailEstimator::Profile>& profiles,
    const DetailOptions& options);

}  // namespace touchline::compensate
