#include "hub/track/assignment.h"

#include <algorithm>
#include <limits>

namespace touchline::track {

std::vector<int> assign(const Eigen::MatrixXd& cost, double worst) {
  const auto rows = static_cast<int>(cost.rows());
  const auto columns = static_cast<int>(cost.cols());
  // Each row has a column of its own that stands for being left apart.
  const int all = columns + rows;
  const auto price = [&](int r, int c) {
    if (c < columns) return std::min(cost(r, c), worst);
    return worst;
  };
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const auto size = static_cast<std::size_t>(all) + 1;
  std::vector<double> row_potential(static_cast<std::size_t>(rows) + 1);
  std::vector<double> column_potential(size);
  std::vector<int> row_of(size, 0);  // by column, from 1; 0 = free
  std::vector<int> previous(size);
  for (int r = 1; r <= rows; ++r) {
    row_of[0] = r;
    int column = 0;
    std::vector<double> least(size, kInfinite);
    std::vector<bool> used(size, false);
    do {
      used[static_cast<std::size_t>(column)] = true;
      const int row = row_of[static_cast<std::size_t>(column)];
      double step = kInfinite;
      int next = 0;
      for (int c = 1; c <= all; ++c) {
        const auto at = static_cast<std::size_t>(c);
        if (used[at]) continue;
        const double reduced = price(row - 1, c - 1) -
                               row_potential[static_cast<std::size_t>(row)] - column_potential[at];
        if (reduced < least[at]) {
          least[at] = reduced;
          previous[at] = column;
        }
        if (least[at] < step) {
          step = least[at];
          next = c;
        }
      }
      for (std::size_t c = 0; c < size; ++c) {
        if (used[c]) {
          row_potential[static_cast<std::size_t>(row_of[c])] += step;
          column_potential[c] -= step;
        } else {
          least[c] -= step;
        }
      }
      column = next;
    } while (row_of[static_cast<std::size_t>(column)] != 0);
    while (column != 0) {
      const int back = previous[static_cast<std::size_t>(column)];
      row_of[static_cast<std::size_t>(column)] = row_of[static_cast<std::size_t>(back)];
      column = back;
    }
  }
  std::vector<int> column_of(static_cast<std::size_t>(rows), -1);
  for (int c = 1; c <= columns; ++c) {
    const int row = row_of[static_cast<std::size_t>(c)];
    if (row > 0 && cost(row - 1, c - 1) < worst)
      column_of[static_cast<std::size_t>(row - 1)] = c - 1;
  }
  return column_of;
}

}  // namespace touchline::track
