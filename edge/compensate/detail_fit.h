// Fits the boost to edges.
#pragma once

#include <span>

#include "edge/compensate/detail_estimator.h"

namespace touchline::compensate {

state::DetailModel fit_detail(std::span<const EdgeProfile> edges, const DetailOptions& options);

}  // namespace touchline::compensate
