#include "hub/track/assignment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <set>

namespace touchline::track {
namespace {

double total(const Eigen::MatrixXd& cost, const std::vector<int>& columns, double worst) {
  double sum = 0;
  for (std::size_t r = 0; r < columns.size(); ++r) {
    sum += columns[r] < 0 ? worst : cost(static_cast<Eigen::Index>(r), columns[r]);
  }
  return sum;
}

// Over all ways of pairing rows with columns or leaving them apart.
double least_total(const Eigen::MatrixXd& cost, double worst) {
  const auto rows = static_cast<std::size_t>(cost.rows());
  std::vector<int> order(static_cast<std::size_t>(cost.cols()) + rows);
  std::iota(order.begin(), order.end(), 0);
  double least = 1e300;
  do {
    std::vector<int> columns(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(rows));
    for (int& c : columns) c = c < cost.cols() ? c : -1;
    least = std::min(least, total(cost, columns, worst));
  } while (std::next_permutation(order.begin(), order.end()));
  return least;
}

TEST(Assign, CostsLeast) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0, 10);
  for (const auto& [rows, columns] : {std::pair{1, 1}, {2, 3}, {3, 2}, {4, 3}, {3, 4}}) {
    for (int trial = 0; trial < 20; ++trial) {
      Eigen::MatrixXd cost(rows, columns);
      for (Eigen::Index i = 0; i < cost.size(); ++i) cost(i) = unit(random);
      const std::vector<int> pairs = assign(cost, 6);
      std::set<int> used;
      for (const int c : pairs) {
        if (c >= 0) {
          EXPECT_TRUE(used.insert(c).second);
        }
      }
      EXPECT_NEAR(total(cost, pairs, 6), least_total(cost, 6), 1e-9);
    }
  }
}

TEST(Assign, LeavesApartWhatIsTooDear) {
  Eigen::MatrixXd cost(2, 2);
  cost << 1, 100, 100, 100;
  EXPECT_EQ(assign(cost, 50), (std::vector<int>{0, -1}));
}

TEST(Assign, TakesEmptyTables) {
  EXPECT_TRUE(assign(Eigen::MatrixXd(0, 3), 1).empty());
  EXPECT_EQ(assign(Eigen::MatrixXd(2, 0), 1), (std::vector<int>{-1, -1}));
}

}  // namespace
}  // namespace touchline::track
