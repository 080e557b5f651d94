#include "hub/render/colour_reference.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/bounds.h"
#include "shared/image/colour.h"

namespace touchline::render {
namespace {

// Log R'G'B' of a plate's turf, averaged over a disc that looks like a square on the sphere.
std::optional<Eigen::Vector3d> turf_colour(const image::PlateSnapshot& plate,
                                           const Eigen::Vector3d& point, double blur_m) {
  const Eigen::Vector3d way = point - plate.centre_in_world;
  const double distance = way.norm();
  if (distance < 1 || -way.z() / distance < 0.02) return std::nullopt;
  const Eigen::Vector2d at = image::plate_from_direction(plate, way);
  const double rise = -way.z() / distance;
  const double half_u = blur_m / 2 / distance / plate.radians_per_px;
  const double half_v = half_u * rise;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n = 0;
  int asked = 0;
  const auto taps = [](double half) { return std::clamp(static_cast<int>(half), 1, 3); };
  const int nu = taps(half_u);
  const int nv = taps(half_v);
  for (int j = -nv; j <= nv; ++j) {
    for (int i = -nu; i <= nu; ++i) {
      ++asked;
      const auto u = static_cast<int>(std::lround(at.x() + half_u * i / nu));
      const auto v = static_cast<int>(std::lround(at.y() + half_v * j / nv));
      const auto divide = [](int a) {
        return a >= 0 ? a / image::kPlateTileSize
                      : -((-a + image::kPlateTileSize - 1) / image::kPlateTileSize);
      };
      const image::PlateTileKey key{divide(u), divide(v)};
      const auto tile = plate.tiles.find(key);
      if (tile == plate.tiles.end()) continue;
      const int x = u - key.column * image::kPlateTileSize;
      const int y = v - key.row * image::kPlateTileSize;
      const image::PlateTile& t = *tile->second;
      if (!t.count.contains(x, y) || t.count(x, y) == 0) continue;
      const auto rgb = image::ycbcr_to_rgb(
          static_cast<float>(t.mean[0](x, y)) / 16.f, static_cast<float>(t.mean[1](x, y)) / 16.f,
          static_cast<float>(t.mean[2](x, y)) / 16.f, plate.colour);
      sum += Eigen::Vector3d(static_cast<double>(rgb[0]), static_cast<double>(rgb[1]),
                             static_cast<double>(rgb[2]));
      ++n;
    }
  }
  if (n < asked) return std::nullopt;
  sum /= n;
  if (sum.minCoeff() < 0.02 || sum.maxCoeff() > 0.98) return std::nullopt;
  return Eigen::Vector3d(sum.array().log());
}

}  // namespace

base::Status ColourReferenceOptions::validate() const {
  for (const base::Status& status : {base::in_bounds("colour.grid_m", grid_m, 0.1, 10),
                                     base::in_bounds("colour.blur_m", blur_m, 0, 5),
                                     base::in_bounds("colour.prior_sd", prior_sd, 0.001, 1),
                                     base::in_bounds("colour.white_limit", white_limit, 0.01, 2),
                                     base::in_bounds("colour.max_gain", max_gain, 1, 4)}) {
    if (!status) return status;
  }
  return {};
}

Eigen::Vector3d ColourReference::of(const base::CameraId& camera) const {
  const auto found = gain.find(camera);
  return found == gain.end() ? Eigen::Vector3d(1, 1, 1) : found->second;
}

ColourReference estimate_colour_reference(
    const pitch::PitchModel& pitch, const std::map<base::CameraId, image::PlateSnapshot>& plates,
    const ColourReferenceOptions& options) {
  ColourReference out;
  for (const auto& [id, plate] : plates) out.gain[id] = Eigen::Vector3d(1, 1, 1);
  if (!options.validate() || plates.size() < 2) return out;

  struct Observation {
    int a = 0, b = 0;
    Eigen::Vector3d ratio;  // log colour of a less that of b
  };
  std::vector<Observation> observations;
  std::vector<const image::PlateSnapshot*> list;
  for (const auto& [id, plate] : plates) list.push_back(&plate);
  const auto n = static_cast<Eigen::Index>(list.size());
  for (double y = -pitch.width_m / 2; y <= pitch.width_m / 2; y += options.grid_m) {
    for (double x = -pitch.length_m / 2; x <= pitch.length_m / 2; x += options.grid_m) {
      std::vector<std::pair<int, Eigen::Vector3d>> seen;
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (const auto c = turf_colour(*list[i], pitch.on_turf({x, y}), options.blur_m)) {
          seen.emplace_back(static_cast<int>(i), *c);
        }
      }
      if (seen.size() > 1) ++out.points;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        for (std::size_t j = i + 1; j < seen.size(); ++j) {
          observations.push_back({seen[i].first, seen[j].first, seen[i].second - seen[j].second});
        }
      }
    }
  }
  if (observations.empty()) return out;

  // log gain_a + log colour_a = log gain_b + log colour_b, reweighted against people, lines and
  // mowing stripes that change with the side they are seen from.
  Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(n, 3);
  const double noise = options.white_limit / 4;
  const double prior = noise * noise / (options.prior_sd * options.prior_sd);
  const auto rms = [&](const Eigen::MatrixXd& g) {
    double sum = 0;
    std::size_t used = 0;
    for (const Observation& o : observations) {
      const Eigen::Vector3d r = o.ratio + (g.row(o.a) - g.row(o.b)).transpose();
      if (o.ratio.cwiseAbs().maxCoeff() > 3 * options.white_limit) continue;
      sum += r.squaredNorm() / 3;
      ++used;
    }
    return used > 0 ? std::sqrt(sum / static_cast<double>(used)) : 0;
  };
  out.rms_before = rms(gain);
  for (int iteration = 0; iteration < 8; ++iteration) {
    for (int k = 0; k < 3; ++k) {
      // The prior is weighed as one observation a camera, so that it only matters for those
      // without shared turf; the row of ones fixes the common scale.
      Eigen::MatrixXd normal =
          prior * Eigen::MatrixXd::Identity(n, n) + Eigen::MatrixXd::Ones(n, n);
      Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
      for (const Observation& o : observations) {
        const double r = o.ratio[k] + gain(o.a, k) - gain(o.b, k);
        const double w = 1 / (1 + r * r / (noise * noise));
        normal(o.a, o.a) += w;
        normal(o.b, o.b) += w;
        normal(o.a, o.b) -= w;
        normal(o.b, o.a) -= w;
        right[o.a] -= w * o.ratio[k];
        right[o.b] += w * o.ratio[k];
      }
      gain.col(k) = normal.ldlt().solve(right);
      gain.col(k).array() -= gain.col(k).mean();
    }
  }
  out.rms_after = rms(gain);
  Eigen::Index i = 0;
  for (auto& [id, g] : out.gain) {
    for (int k = 0; k < 3; ++k) {
      g[k] = std::clamp(std::exp(gain(i, k)), 1 / options.max_gain, options.max_gain);
    }
    ++i;
  }
  return out;
}

}  // namespace touchline::render
