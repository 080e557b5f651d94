#include "edge/compensate/detail_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "edge/compensate/edge_model.h"

namespace touchline::compensate {
namespace {

constexpr int kRounds = 8;
constexpr double kMostBlur = 1.6;   // sigma; beyond, blur and boost are not told apart
constexpr double kFair = 2.0;       // misfit from which an edge counts less
constexpr double kBad = 6.0;        // and from which it does not count
constexpr double kAsMany = 12;      // edges that the evidence counts as: their errors are shared
constexpr double kNearPrior = 0.5;  // spread of the near tap round 0
constexpr double kFarPrior = 0.12;  // of the far tap
constexpr double kMost = 1.0;       // of an axis' total
constexpr double kFarShare = 0.7;   // of the near tap

// Least squares with bounds by descent along one coordinate after the other.
Taps bounded_step(const Eigen::Matrix4d& information, const Eigen::Vector4d& gradient,
                  const Taps& from) {
  Taps to = from;
  for (int sweep = 0; sweep < 60; ++sweep)
    for (Eigen::Index k = 0; k < 4; ++k) {
      const double slope = gradient[k] - information.row(k).dot(to - from);
      const Eigen::Index other = k ^ 1;
      const double most =
          k % 2 == 0 ? kMost - to[other] : std::min(kFarShare * to[other], kMost - to[other]);
      const double least = k % 2 == 0 ? to[other] / kFarShare : 0;
      const double wanted = to[k] + slope / std::max(information(k, k), 1e-9);
      to[k] = std::clamp(wanted, std::min(least, most), most);
    }
  return to;
}

}  // namespace

state::DetailModel fit_detail(std::span<const EdgeProfile> edges, const DetailOptions& options) {
  state::DetailModel model;
  if (static_cast<int>(edges.size()) < options.edges_needed) return model;
  std::vector<EdgeFit> fits;
  fits.reserve(edges.size());
  for (const auto& edge : edges) fits.emplace_back(edge);

  Taps taps = Taps::Zero();
  const Eigen::Vector4d prior =
      Eigen::Vector4d(1 / kNearPrior, 1 / kFarPrior, 1 / kNearPrior, 1 / kFarPrior).cwiseAbs2();
  Eigen::Matrix4d information;
  double counted = 0;
  std::array<double, 2> speaking{};
  double residual = 0;
  for (int round = 0; round < kRounds; ++round) {
    information.setZero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    counted = 0;
    residual = 0;
    speaking = {};
    for (auto& fit : fits) {
      fit.refine(taps, round == 0 ? 6 : 2);
      const auto reduced = fit.reduce(taps);
      if (fit.blur() > kMostBlur) continue;
      const double misfit = fit.misfit();
      if (round > 2 && misfit > kBad) continue;
      const double weight = 1 / (1 + std::pow(misfit / kFair, 2));
      information += weight * reduced.information;
      gradient += weight * reduced.gradient;
      counted += weight;
      residual += weight * fit.residual_rms();
      speaking[0] += weight * (fit.edge().cosine > 0.6 ? 1 : 0);
      speaking[1] += weight * (fit.edge().sine > 0.6 ? 1 : 0);
    }
    if (counted <= 0) return model;
    const double tempered = std::min(1.0, kAsMany / counted);
    information *= tempered;
    gradient *= tempered;
    information.diagonal() += prior;
    gradient -= prior.cwiseProduct(taps);
    taps = bounded_step(information, gradient, taps);
  }
  model.edges = static_cast<int>(std::lround(counted));
  model.residual = residual / counted;
  if (speaking[0] >= 3 && taps[0] + taps[1] >= options.least_boost)
    model.horizontal = {taps[0], taps[1]};
  if (speaking[1] >= 3 && taps[2] + taps[3] >= options.least_boost)
    model.vertical = {taps[2], taps[3]};
  return model;
}

}  // namespace touchline::compensate
