#include "edge/plate/still_seed.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "edge/plate/frame_sampler.h"
#include "edge/plate/sample_stack.h"

namespace touchline::plate {
namespace {

constexpr std::size_t kLeastPairs = 100;

std::array<float, 3> unpack(std::uint32_t s) {
  return {0.5f * static_cast<float>(s >> 21), static_cast<float>((s >> 11) & 0x3ff),
          static_cast<float>((s >> 1) & 0x3ff)};
}

}  // namespace

void StillSeed::add(const image::Frame& still, const geometry::CameraEstimate& estimate) {
  const auto at = std::find_if(stills_.begin(), stills_.end(), [&](const Still& s) {
    return s.estimate.model.fx < estimate.model.fx;
  });
  stills_.insert(at, Still{still, estimate});
}

std::vector<std::uint32_t> StillSeed::look_up(const image::PlateSnapshot& sphere,
                                              const image::PlateTileKey& key) const {
  constexpr auto kArea = static_cast<std::size_t>(image::kPlateTileSize) * image::kPlateTileSize;
  std::vector<std::uint32_t> out(kArea, 0U);
  TileSamples samples;
  std::size_t missing = kArea;
  for (const auto& still : stills_) {
    if (missing == 0) break;
    sample_tile(sphere, key, 0, still.frame, still.estimate, 2, samples);
    if (samples.seen == 0) continue;
    for (std::size_t i = 0; i < kArea; ++i)
      if (!out[i] && samples.inside[i]) {
        out[i] = pack_sample(samples.y[i], samples.cb[i], samples.cr[i], true);
        --missing;
      }
  }
  return out;
}

void StillFit::add(std::uint32_t still_sample, const std::array<float, 3>& video) {
  const auto s = unpack(still_sample);
  pairs_.push_back({s[0], s[1], s[2], video[0], video[1], video[2]});
}

bool StillFit::solve() {
  if (pairs_.size() < kLeastPairs) return false;
  double limit = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < 2; ++pass) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Matrix<double, 4, 3> right = Eigen::Matrix<double, 4, 3>::Zero();
    const auto squares = [&](const std::array<float, 6>& p) {
      std::array<double, 3> out{};
      for (std::size_t c = 0; c < 3; ++c) {
        const double d =
            map_[c][0] * p[0] + map_[c][1] * p[1] + map_[c][2] * p[2] + map_[c][3] - p[3 + c];
        out[c] = d * d;
      }
      return out;
    };
    const auto error = [&](const std::array<float, 6>& p) {
      const auto s = squares(p);
      return (s[0] + s[1] + s[2]) / 3;
    };
    for (const auto& p : pairs_) {
      if (pass > 0 && error(p) > limit) continue;
      const Eigen::Vector4d x(p[0] - 64.0, p[1] - 512.0, p[2] - 512.0, 30.0);
      normal += x * x.transpose();
      right += x * Eigen::Vector3d(p[3], p[4], p[5]).transpose();
    }
    // A little weight on plain gain 1 keeps a picture of one colour solvable.
    const double weight = 1e-3 * static_cast<double>(pairs_.size()) * 100;
    normal += weight * Eigen::Matrix4d::Identity();
    right(0, 0) += weight;
    right(1, 1) += weight;
    right(2, 2) += weight;
    const Eigen::Matrix<double, 4, 3> solution = normal.ldlt().solve(right);
    if (!solution.allFinite()) return false;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto k = static_cast<Eigen::Index>(c);
      for (int i = 0; i < 3; ++i)
        map_[c][static_cast<std::size_t>(i)] = static_cast<float>(solution(i, k));
      map_[c][3] = static_cast<float>(30 * solution(3, k) - 64 * solution(0, k) -
                                      512 * (solution(1, k) + solution(2, k)));
    }
    std::vector<double> errors;
    errors.reserve(pairs_.size());
    for (const auto& p : pairs_) errors.push_back(error(p));
    std::sort(errors.begin(), errors.end());
    limit = errors[errors.size() * 9 / 10];
    std::array<double, 3> sums{};
    double counted = 0;
    for (const auto& p : pairs_) {
      if (error(p) > limit) continue;
      const auto s = squares(p);
      for (std::size_t c = 0; c < 3; ++c) sums[c] += s[c];
      counted += 1;
    }
    for (std::size_t c = 0; c < 3; ++c) rms_[c] = std::sqrt(sums[c] / counted);
  }
  return true;
}

std::array<float, 3> StillFit::apply(std::uint32_t still_sample) const {
  const auto s = unpack(still_sample);
  std::array<float, 3> out{};
  for (std::size_t c = 0; c < 3; ++c)
    out[c] = map_[c][0] * s[0] + map_[c][1] * s[1] + map_[c][2] * s[2] + map_[c][3];
  return out;
}

}  // namespace touchline::plate
