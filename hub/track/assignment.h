// Pairs rows with columns of a cost matrix at least total cost (Kuhn 1955; shortest augmenting
// paths, Jonker, Volgenant 1987).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace touchline::track {

// The column of each row, or -1. A pair that costs `worst` or more is left apart, and leaving a row
// apart costs `worst`. Costs must be finite.
std::vector<int> assign(const Eigen::MatrixXd& cost, double worst);

}  // namespace touchline::track
