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
constexpr double kMostBlur = 1.6;  // sigma; beyond, blur and boost are not told apart
constexpr double kFair = 2.0;      // misfit from which an edge counts less
constexpr double kBad = 6.0;       // and from which it does not count
constexpr int kFirstChoice = 3;    // rounds in which dark strips are sought
constexpr int kSecondChoice = 5;
constexpr double kBlurSpread = 0.25;  // of the logarithm of the blur round the typical one
constexpr double kWideEnough = 3;     // bars, pixels
constexpr double kAsksForMore = 0.4;  // weight of an edge that asks for more boost
constexpr double kAsMany = 12;        // edges that the evidence counts as: their errors are shared
constexpr double kNearPrior = 0.5;    // spread of the near tap round 0
constexpr double kFarPrior = 0.12;    // of the far tap
constexpr double kMost = 0.8;         // of an axis' total; more would blur what it cannot know
constexpr double kFarShare = 0.7;     // of the near tap

// Least squares with bounds by descent along one coordinate after the other.
Taps bounded_step(const Eigen::Matrix4d& information, const Eigen::Vector4d& gradient,
                  const Taps& from) {
  // Every allowed pair of taps is a sum of (1, 0) and (1, kFarShare) with weights >= 0.
  Eigen::Matrix4d basis = Eigen::Matrix4d::Zero();
  for (const Eigen::Index axis : {0, 2}) {
    basis(axis, axis) = basis(axis, axis + 1) = 1;
    basis(axis + 1, axis + 1) = kFarShare;
  }
  const Eigen::Matrix4d h = basis.transpose() * information * basis;
  const Eigen::Vector4d g = basis.transpose() * (gradient + information * from);
  Eigen::Vector4d weights = Eigen::Vector4d::Zero();
  for (int sweep = 0; sweep < 200; ++sweep)
    for (Eigen::Index k = 0; k < 4; ++k) {
      const double slope = g[k] - h.row(k).dot(weights);
      weights[k] = std::max(0.0, weights[k] + slope / std::max(h(k, k), 1e-9));
    }
  Taps to = basis * weights;
  for (const Eigen::Index axis : {0, 2}) {
    const double total = to[axis] + to[axis + 1];
    if (total > kMost) to.segment<2>(axis) *= kMost / total;
  }
  return to;
}

// A blur that two fifths of the edges stay under: the lens in focus.
double typical_blur(const std::vector<EdgeFit>& fits) {
  std::vector<double> blurs;
  for (const auto& fit : fits) blurs.push_back(fit.blur());
  const auto at = blurs.begin() + static_cast<std::ptrdiff_t>(blurs.size() * 2 / 5);
  std::nth_element(blurs.begin(), at, blurs.end());
  return *at;
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
  double typical = 0;
  for (int round = 0; round < kRounds; ++round) {
    information.setZero();
    Eigen::Vector4d gradient = Eigen::Vector4d::Zero();
    counted = 0;
    residual = 0;
    speaking = {};
    if (round > 0) typical = typical_blur(fits);
    for (auto& fit : fits) {
      if (round > 0) fit.expect_blur(std::log(typical), kBlurSpread);
      if (round == kFirstChoice || round == kSecondChoice)
        fit.choose_strip(taps, 3);
      else
        fit.refine(taps, round == 0 ? 6 : 2);
      const auto reduced = fit.reduce(taps);
      if (fit.blur() > kMostBlur) continue;
      const double misfit = fit.misfit();
      if (round > 2 && misfit > kBad) continue;
      double weight = 1 / (1 + std::pow(misfit / kFair, 2));
      // What a narrow bar tells hangs on its width.
      if (fit.edge().bar) weight *= std::clamp(fit.edge().width / kWideEnough, 0.1, 1.0);
      // Too little compensation harms less than too much.
      if (round > 1 && reduced.gradient[0] + reduced.gradient[2] > 0) weight *= kAsksForMore;
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
