#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "hub/render/stadium_sweep_internal.h"

namespace touchline::render {
namespace {

constexpr double kAlong = 0.25;      // metres between samples along a side
constexpr int kWindow = 24;          // samples that are correlated: 6 m
constexpr double kFineTop = 2.75;    // up to here heights are dense: hoardings
constexpr double kFine = 0.25;       // metres between heights there
constexpr double kCoarse = 1.5;      // and above
constexpr double kOutward = 0.25;    // metres between distances that are tried
constexpr double kDeepest = 40;      // of a stand behind its hoarding, metres
constexpr float kLeastContrast = 4;  // standard deviation in a window below which it says nothing

struct Axis {
  int across;
  double sign;
  double line;
  double reach;  // along the side, each way
};

Axis axis_of(const Stadium& stadium, PitchSide side) {
  const bool ends = side == PitchSide::kLeft || side == PitchSide::kRight;
  const double sign = side == PitchSide::kNear || side == PitchSide::kLeft ? -1 : 1;
  return ends ? Axis{0, sign, stadium.half_length_m, stadium.half_width_m}
              : Axis{1, sign, stadium.half_width_m, stadium.half_length_m};
}

// Luma of a plate along one line of the stadium; NaN where it does not show it.
void sample_line(const PlateTexture& texture, const Axis& axis, double outward, double height,
                 std::vector<float>& luma) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Vector3d& centre = texture.centre_in_world();
  // Only from the pitch's side of it.
  const bool behind = axis.sign * centre[axis.across] > axis.line + outward;
  for (std::size_t k = 0; k < luma.size(); ++k) {
    luma[k] = static_cast<float>(nan);
    if (behind) continue;
    Eigen::Vector3d p;
    p[axis.across] = axis.sign * (axis.line + outward);
    p[1 - axis.across] = -axis.reach + static_cast<double>(k) * kAlong;
    p.z() = height;
    const Eigen::Vector3d way = p - centre;
    const Eigen::Vector2f at = texture.position(way);
    if (texture.border_distance(at.x(), at.y()) <= 0) continue;
    const auto span = static_cast<float>(0.5 * kAlong / way.norm() / texture.radians_per_px());
    const Sample s = texture.sample(at.x(), at.y(), {span, 0}, {0, span});
    if (s.weight > 0) luma[k] = s.colour.dot(Eigen::Vector3f(0.2126f, 0.7152f, 0.0722f));
  }
}

struct Score {
  double sum = 0;  // of correlations, weighted by contrast
  double weight = 0;
};

void correlate(const std::vector<float>& a, const std::vector<float>& b, Score& score) {
  for (std::size_t start = 0; start + kWindow <= a.size(); start += kWindow / 2) {
    double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
    bool whole = true;
    for (std::size_t k = start; k < start + kWindow && whole; ++k) {
      whole = !std::isnan(a[k]) && !std::isnan(b[k]);
      const auto va = static_cast<double>(a[k]);
      const auto vb = static_cast<double>(b[k]);
      ma += va;
      mb += vb;
      aa += va * va;
      bb += vb * vb;
      ab += va * vb;
    }
    if (!whole) continue;
    ma /= kWindow;
    mb /= kWindow;
    const double sa = std::sqrt(std::max(0.0, aa / kWindow - ma * ma));
    const double sb = std::sqrt(std::max(0.0, bb / kWindow - mb * mb));
    if (sa < kLeastContrast || sb < kLeastContrast) continue;
    const double w = std::min(std::min(sa, sb), 30.0);
    score.sum += w * (ab / kWindow - ma * mb) / (sa * sb);
    score.weight += w;
  }
}

double default_outward(const StadiumSide& side, double height) {
  const ProfilePoint& edge = side.profile[1];
  const ProfilePoint& top = side.profile.back();
  if (height <= edge.height_m) return edge.outward_m;
  const double s = (height - edge.height_m) / (top.height_m - edge.height_m);
  return edge.outward_m + s * (top.outward_m - edge.outward_m);
}

// Points that lie within `tolerance` of the line through their neighbours are left out.
std::vector<ProfilePoint> simplified(const std::vector<ProfilePoint>& points, double tolerance) {
  std::vector<char> keep(points.size(), 0);
  keep.front() = keep.back() = 1;
  std::vector<std::pair<std::size_t, std::size_t>> open = {{0, points.size() - 1}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const double dx = points[b].outward_m - points[a].outward_m;
    const double dz = points[b].height_m - points[a].height_m;
    const double length = std::hypot(dx, dz);
    double worst = tolerance;
    std::size_t at = a;
    for (std::size_t k = a + 1; k < b; ++k) {
      const double off = std::abs((points[k].outward_m - points[a].outward_m) * dz -
                                  (points[k].height_m - points[a].height_m) * dx) /
                         std::max(length, 1e-9);
      if (off > worst) {
        worst = off;
        at = k;
      }
    }
    if (at == a) continue;
    keep[at] = 1;
    open.emplace_back(a, at);
    open.emplace_back(at, b);
  }
  std::vector<ProfilePoint> out;
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (keep[k]) out.push_back(points[k]);
  }
  return out;
}

void sweep_side(const pitch::PitchModel& pitch, std::span<const PlateCamera> cameras,
                const StadiumOptions& options, const Axis& axis, StadiumSide& side) {
  std::vector<double> heights;
  for (double z = -pitch.crown_m + 0.15; z < kFineTop; z += kFine) heights.push_back(z);
  for (double z = kFineTop + kCoarse / 2; z < options.top_m; z += kCoarse) heights.push_back(z);
  std::vector<double> outwards;
  for (double d = options.least_margin_m; d <= options.most_margin_m + kDeepest; d += kOutward) {
    outwards.push_back(d);
  }
  const std::size_t rows = heights.size();
  const std::size_t columns = outwards.size();
  std::vector<Score> scores(rows * columns);
  const auto samples = static_cast<std::size_t>(2 * axis.reach / kAlong) + 1;
  tbb::parallel_for(std::size_t{0}, rows * columns, [&](std::size_t k) {
    const double height = heights[k / columns];
    const double outward = outwards[k % columns];
    if (height < kFineTop && outward > options.most_margin_m) return;
    std::vector<std::vector<float>> lines(cameras.size(), std::vector<float>(samples));
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      sample_line(cameras[i].texture, axis, outward, height, lines[i]);
    }
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        correlate(lines[i], lines[j], scores[k]);
      }
    }
  });

  // How much a height says at all: the most that any distance there was compared by.
  std::vector<double> most(rows, 0);
  for (std::size_t k = 0; k < scores.size(); ++k) {
    most[k / columns] = std::max(most[k / columns], scores[k].weight);
  }
  const double full = *std::max_element(most.begin(), most.end());
  if (full <= 0) return;
  const auto gain = [&](std::size_t row, std::size_t column) {
    const Score& s = scores[row * columns + column];
    // Little overlap counts as little agreement.
    return s.sum / std::max(s.weight, 0.3 * most[row] + 0.02 * full);
  };
  // Best rising profile: agreement, less a little for leaving the default and for leaps.
  const double never = -1e9;
  std::vector<double> best(rows * columns, never);
  std::vector<std::size_t> from(rows * columns, 0);
  for (std::size_t r = 0; r < rows; ++r) {
    const double usual = default_outward(side, heights[r]);
    double carried = never;
    std::size_t carrier = 0;
    for (std::size_t c = 0; c < columns; ++c) {
      if (heights[r] < kFineTop && outwards[c] > options.most_margin_m) break;
      const double own = gain(r, c) - 0.004 * std::abs(outwards[c] - usual);
      if (r == 0) {
        best[c] = own;
        continue;
      }
      carried -= 0.01 * kOutward;  // for every metre further out
      if (best[(r - 1) * columns + c] > carried) {
        carried = best[(r - 1) * columns + c];
        carrier = c;
      }
      best[r * columns + c] = carried + own;
      from[r * columns + c] = carrier;
    }
  }
  std::size_t c = 0;
  for (std::size_t k = 0; k < columns; ++k) {
    if (best[(rows - 1) * columns + k] > best[(rows - 1) * columns + c]) c = k;
  }
  std::vector<ProfilePoint> path(rows);
  double agreement = 0, weight = 0, usual_agreement = 0;
  for (std::size_t r = rows; r-- > 0;) {
    path[r] = {outwards[c], heights[r]};
    agreement += most[r] * gain(r, c);
    weight += most[r];
    const double usual = default_outward(side, heights[r]);
    const auto u = static_cast<std::size_t>(std::clamp(
        std::lround((usual - outwards[0]) / kOutward), 0L, static_cast<long>(columns) - 1));
    usual_agreement += most[r] * gain(r, u);
    c = from[r * columns + c];
  }
  side.agreement = agreement / weight;
  if (side.agreement < options.least_agreement || agreement < usual_agreement + 0.02 * weight) {
    return;
  }
  std::vector<ProfilePoint> profile = simplified(path, 0.4);
  profile.insert(profile.begin(), {path.front().outward_m, side.profile.front().height_m});
  // Beyond the last height the slope goes on to the top.
  const ProfilePoint& a = profile[profile.size() - 2];
  const ProfilePoint& b = profile.back();
  const double slope = (b.outward_m - a.outward_m) / std::max(b.height_m - a.height_m, 1e-6);
  if (options.top_m > b.height_m + 1e-6) {
    profile.push_back(
        {b.outward_m + std::min(slope, 5.0) * (options.top_m - b.height_m), options.top_m});
  }
  side.profile = std::move(profile);
  side.measured = true;
}

}  // namespace

Stadium sweep_stadium(const pitch::PitchModel& pitch, std::span<const PlateCamera> cameras,
                      const StadiumOptions& options) {
  Stadium stadium = default_stadium(pitch, options);
  if (cameras.size() < 2) return stadium;
  for (const PitchSide side :
       {PitchSide::kNear, PitchSide::kFar, PitchSide::kLeft, PitchSide::kRight}) {
    sweep_side(pitch, cameras, options, axis_of(stadium, side),
               stadium.sides[static_cast<std::size_t>(side)]);
  }
  return stadium;
}

Stadium estimate_stadium(const pitch::PitchModel& pitch,
                         const std::map<base::CameraId, image::PlateSnapshot>& plates,
                         const StadiumOptions& options) {
  if (!options.validate()) return default_stadium(pitch);
  std::vector<PlateCamera> cameras;
  for (const auto& [id, plate] : plates) {
    if (plate.tiles.empty() || !(plate.radians_per_px > 0)) continue;
    cameras.push_back({id, PlateTexture(plate, Eigen::Vector3d::Ones())});
  }
  return sweep_stadium(pitch, cameras, options);
}

}  // namespace touchline::render
