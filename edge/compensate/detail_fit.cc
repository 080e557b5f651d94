#include "edge/compensate/detail_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace touchline::compensate {
namespace {

constexpr int kLeastEdges = 40;          // of a group
constexpr int kLeastInBin = 6;           // samples of a bin
constexpr double kAlongAxis = 0.9;       // component of a unit normal that looks along an axis
constexpr double kQuantile = 0.33;       // of the edges, by the boost they ask for
constexpr double kPriceOfBoost = 0.006;  // an undershoot this deep is not worth a boost of its own
constexpr double kMost = 1.0;            // of a tap
constexpr int kInverseSteps = 16;
constexpr int kBins = DetailEstimator::kBins;
constexpr double kPerPixel = DetailEstimator::kBinsPerPixel;

using Response = std::array<double, kBins>;
using Taps = std::array<double, 4>;  // h1, h2, v1, v2

struct Group {
  double cosine = 1, sine = 0;
  Response value{};
  Response weight{};  // what an undershoot at this place counts
};

double at(const Response& r, double position) {
  if (position <= 0) return r.front();
  if (position >= kBins - 1) return r.back();
  const auto i = static_cast<std::size_t>(position);
  const double f = position - std::floor(position);
  return r[i] + f * (r[i + 1] - r[i]);
}

// The averaged response with the boost undone: across an edge the taps lie at distances that shrink
// with the cosine of the angle between the edge's normal and the axis.
Response undo(const Group& g, const Taps& taps) {
  const double step = 1 / (1 + taps[0] + taps[1] + taps[2] + taps[3]);
  const std::array<double, 4> distance{g.cosine * kPerPixel, 2 * g.cosine * kPerPixel,
                                       g.sine * kPerPixel, 2 * g.sine * kPerPixel};
  Response u = g.value;
  Response next{};
  for (int iteration = 0; iteration < kInverseSteps; ++iteration) {
    for (int b = 0; b < kBins; ++b) {
      const auto i = static_cast<std::size_t>(b);
      double boosted = u[i];
      for (std::size_t k = 0; k < 4; ++k)
        if (taps[k] > 0)
          boosted += taps[k] * (u[i] - 0.5 * (at(u, b - distance[k]) + at(u, b + distance[k])));
      next[i] = u[i] + step * (g.value[i] - boosted);
    }
    u = next;
  }
  return u;
}

double cost(const Group& g, const Taps& taps) {
  const Response u = undo(g, taps);
  double sum = 0;
  for (std::size_t i = 0; i < kBins; ++i) {
    const double under = std::min(0.0, u[i]);
    sum += g.weight[i] * under * under / kPerPixel;
  }
  // The far taps cost more, so that they stay 0 unless the shape asks for them.
  const double boost = taps[0] + 2 * taps[1] + taps[2] + 2 * taps[3];
  return sum + kPriceOfBoost * kPriceOfBoost * 8 * boost;
}

// The two taps from `first` on, downhill by steps of shrinking size, apart and against each other.
Taps minimise(const Group& g, std::size_t first) {
  Taps best{};
  double least = cost(g, best);
  for (double size = 0.16; size > 0.004; size /= 2)
    for (bool better = true; better;) {
      better = false;
      for (const auto& [near, far] :
           {std::array{1., 0.}, {-1., 0.}, {0., 1.}, {0., -1.}, {1., -1.}, {-1., 1.}}) {
        Taps trial = best;
        trial[first] = std::clamp(trial[first] + near * size, 0.0, kMost);
        trial[first + 1] = std::clamp(trial[first + 1] + far * size, 0.0, kMost);
        const double c = cost(g, trial);
        if (c < least) {
          least = c;
          best = trial;
          better = true;
        }
      }
    }
  return best;
}

struct Vote {
  double boost = 0;  // sum of both taps
  double far = 0;    // of it, the far tap
  double edges = 0;
};

// The boost that kQuantile of the edges stay under, and the mean share of the far tap near it.
std::array<double, 2> agree(std::vector<Vote> votes) {
  std::sort(votes.begin(), votes.end(),
            [](const Vote& a, const Vote& b) { return a.boost < b.boost; });
  double all = 0;
  for (const auto& v : votes) all += v.edges;
  double boost = 0;
  double sum = 0;
  for (const auto& v : votes) {
    sum += v.edges;
    boost = v.boost;
    if (sum >= kQuantile * all) break;
  }
  double far = 0;
  double weight = 0;
  for (const auto& v : votes) {
    if (v.boost <= 0 || std::abs(v.boost - boost) > 0.5 * boost) continue;
    far += v.edges * v.far / v.boost;
    weight += v.edges;
  }
  const double share = weight > 0 ? far / weight : 0;
  return {boost * (1 - share), boost * share};
}

}  // namespace

state::DetailModel fit_detail(
    const std::map<DetailEstimator::Class, DetailEstimator::Profile>& profiles,
    const DetailOptions& options) {
  state::DetailModel model;
  std::array<std::vector<Vote>, 2> votes;  // across vertical edges, across horizontal ones
  std::array<double, 2> edges{};
  double residual = 0;
  for (const auto& [c, profile] : profiles) {
    if (profile.edges < kLeastEdges) continue;
    Group g;
    g.cosine = profile.cosine / profile.edges;
    g.sine = profile.sine / profile.edges;
    const double width = profile.width / profile.edges;

    bool gap = false;
    for (int b = 0; b < kBins; ++b) {
      const auto i = static_cast<std::size_t>(b);
      if (profile.count[i] < kLeastInBin) {
        // Fewer samples fall between the pixels of edges along an axis: take the neighbours.
        double sum = 0;
        double count = 0;
        for (int k = std::max(0, b - 2); k <= std::min(kBins - 1, b + 2); ++k) {
          sum += profile.sum[static_cast<std::size_t>(k)];
          count += profile.count[static_cast<std::size_t>(k)];
        }
        gap = gap || count < kLeastInBin;
        g.value[i] = count > 0 ? sum / count : 0;
      } else {
        g.value[i] = profile.sum[i] / profile.count[i];
      }
      const double t = b / kPerPixel - DetailEstimator::kReach;
      // Dark side, as far as the boost reaches; further out other things may lie.
      const double outside = c.width ? std::abs(t) - 0.5 * width : -t;
      g.weight[i] = outside > 0.2 && outside < 3.5 ? 1 : 0;
    }
    if (gap) continue;
    model.edges += profile.edges;
    for (const std::size_t axis : {0U, 1U}) {
      if ((axis == 0 ? g.cosine : g.sine) < kAlongAxis) continue;
      const Taps taps = minimise(g, 2 * axis);
      const double count = std::min<double>(profile.edges, 1000);
      votes[axis].push_back({taps[2 * axis] + taps[2 * axis + 1], taps[2 * axis + 1], count});
      edges[axis] += profile.edges;
      residual += count * std::sqrt(cost(g, taps) / 4);
    }
  }
  if (model.edges < options.edges_needed) {
    model.edges = 0;
    return model;
  }
  model.residual = residual / std::max(1.0, edges[0] + edges[1]);
  // A boost that few edges speak for, or too small to tell from none, is none.
  const auto across = agree(votes[0]);
  const auto down = agree(votes[1]);
  if (edges[0] * 5 > options.edges_needed && across[0] + across[1] >= options.least_boost)
    model.horizontal = across;
  if (edges[1] * 5 > options.edges_needed && down[0] + down[1] >= options.least_boost)
    model.vertical = down;
  return model;
}

}  // namespace touchline::compensate
