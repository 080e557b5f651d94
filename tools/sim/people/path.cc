#include "tools/sim/people/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/sim/people/asset_files.h"
#include "tools/sim/people/random.h"
#include "tools/sim/people/track_files.h"

namespace touchline::sim::people {
namespace {

using Eigen::Vector2d;
constexpr double kRate = 50;
constexpr std::size_t kTrackLimit = 256U << 20U;

// Weighted mean over +-`half` samples; ends are held.
std::vector<Vector2d> smoothed(const std::vector<Vector2d>& in, double sigma_samples) {
  const int half = static_cast<int>(std::ceil(3 * sigma_samples));
  std::vector<double> weight;
  double sum = 0;
  for (int d = -half; d <= half; ++d) {
    weight.push_back(std::exp(-0.5 * d * d / (sigma_samples * sigma_samples)));
    sum += weight.back();
  }
  std::vector<Vector2d> out(in.size());
  const int n = static_cast<int>(in.size());
  for (int i = 0; i < n; ++i) {
    Vector2d p = Vector2d::Zero();
    for (int d = -half; d <= half; ++d) {
      p += weight[static_cast<std::size_t>(d + half)] *
           in[static_cast<std::size_t>(std::clamp(i + d, 0, n - 1))];
    }
    out[static_cast<std::size_t>(i)] = p / sum;
  }
  return out;
}

// Monotone cubic through the way points in each coordinate (Fritsch and Carlson 1980): no
// overshoot.
Vector2d through(const std::vector<WayPoint>& points, double t) {
  if (t <= points.front().time_s) return points.front().position_m;
  if (t >= points.back().time_s) return points.back().position_m;
  std::size_t k = 0;
  while (k + 2 < points.size() && points[k + 1].time_s <= t) ++k;
  const auto secant = [&](std::size_t i) -> Vector2d {
    return (points[i + 1].position_m - points[i].position_m) /
           (points[i + 1].time_s - points[i].time_s);
  };
  const auto slope = [&](std::size_t i) -> Vector2d {
    if (i == 0 || i + 1 == points.size()) return Vector2d::Zero();
    const Vector2d a = secant(i - 1);
    const Vector2d b = secant(i);
    Vector2d m;
    for (int c = 0; c < 2; ++c) m[c] = a[c] * b[c] <= 0 ? 0.0 : 2 * a[c] * b[c] / (a[c] + b[c]);
    return m;
  };
  const double h = points[k + 1].time_s - points[k].time_s;
  const double u = (t - points[k].time_s) / h;
  const double u2 = u * u;
  const double u3 = u2 * u;
  return (2 * u3 - 3 * u2 + 1) * points[k].position_m + (u3 - 2 * u2 + u) * h * slope(k) +
         (3 * u2 - 2 * u3) * points[k + 1].position_m + (u3 - u2) * h * slope(k + 1);
}

// Runs and rests within the roaming circle.
std::vector<WayPoint> wander(const PersonSpec& spec, double from, double to, const Stream& random) {
  std::vector<WayPoint> out;
  std::uint64_t k = 0;
  const auto place = [&] {
    const double radius = spec.roam_m * std::sqrt(random.uniform(k++));
    const double angle = random.uniform(k++, 0, 2 * std::numbers::pi);
    return Vector2d(spec.position_m + radius * Vector2d(std::cos(angle), std::sin(angle)));
  };
  out.push_back({from, place()});
  while (out.back().time_s < to) {
    const Vector2d next = place();
    const double pace = spec.pace_mps * random.uniform(k++, 0.5, 1.4);
    const double way = (next - out.back().position_m).norm();
    // Starting and stopping take time: an ease of 0.6 of the mean speed at the ends.
    out.push_back({out.back().time_s + std::max(0.6, 1.5 * way / pace), next});
    if (random.uniform(k++) < 0.5) {
      out.push_back({out.back().time_s + random.uniform(k++, 0.5, 2.5), next});
    }
  }
  return out;
}

base::Result<std::vector<Vector2d>> follow_track(const TrackSource& source, double from,
                                                 double to) {
  const auto text = read_text(source.file, kTrackLimit);
  if (!text) return base::fail(text.error());
  const auto track = parse_track(*text, source.format, source.player, source.file.string());
  if (!track) return base::fail(track.error());
  const double rate = source.rate_hz > 0 ? source.rate_hz : track->rate_hz;
  // Gaps are bridged straight.
  std::vector<std::pair<double, Vector2d>> seen;
  for (std::size_t i = 0; i < track->places.size(); ++i) {
    if (track->places[i]) seen.emplace_back(static_cast<double>(i) / rate, *track->places[i]);
  }
  // Where somebody is elsewhere from one row to the next (another half, another man under the
  // number) the track ends: only the stretch that holds the first frame counts.
  constexpr double kFastest = 13;  // m/s
  std::size_t first = 0;
  std::size_t last = seen.size();
  for (std::size_t i = 1; i < seen.size(); ++i) {
    const double far = (seen[i].second - seen[i - 1].second).norm();
    if (far < kFastest * (seen[i].first - seen[i - 1].first) + 0.5) continue;
    if (seen[i].first <= source.start_s) {
      first = i;
    } else {
      last = i;
      break;
    }
  }
  seen = std::vector<std::pair<double, Vector2d>>(seen.begin() + static_cast<std::ptrdiff_t>(first),
                                                  seen.begin() + static_cast<std::ptrdiff_t>(last));
  std::vector<Vector2d> out;
  std::size_t k = 0;
  for (double t = from; t <= to + 0.5 / kRate; t += 1 / kRate) {
    const double at = t + source.start_s;
    while (k + 1 < seen.size() && seen[k + 1].first <= at) ++k;
    if (at <= seen.front().first || k + 1 >= seen.size()) {
      out.push_back(at <= seen.front().first ? seen.front().second : seen.back().second);
      continue;
    }
    const double u = (at - seen[k].first) / (seen[k + 1].first - seen[k].first);
    out.push_back((1 - u) * seen[k].second + u * seen[k + 1].second);
  }
  return out;
}

}  // namespace

Vector2d PlacePath::at(double time_s) const {
  const double x =
      std::clamp((time_s - start_s) * rate_hz, 0.0, static_cast<double>(places.size()) - 1.0);
  const auto i = std::min(static_cast<std::size_t>(x), places.size() - 1);
  const std::size_t j = std::min(i + 1, places.size() - 1);
  const double u = x - static_cast<double>(i);
  return (1 - u) * places[i] + u * places[j];
}

base::Result<PlacePath> plan_path(const PersonSpec& spec, double from_s, double to_s,
                                  std::uint64_t seed) {
  PlacePath path;
  path.start_s = from_s;
  path.rate_hz = kRate;
  const auto n = static_cast<std::size_t>(std::ceil((to_s - from_s) * kRate)) + 1;
  const auto sample = [&](const std::vector<WayPoint>& points) {
    std::vector<Vector2d> out(n);
    for (std::size_t i = 0; i < n; ++i) {
      out[i] = through(points, from_s + static_cast<double>(i) / kRate);
    }
    return out;
  };
  switch (spec.path) {
    case PathKind::kStanding:
      path.places.assign(n, spec.position_m);
      break;
    case PathKind::kScripted:
      path.places = smoothed(sample(spec.way_points), 0.10 * kRate);
      break;
    case PathKind::kAuto:
      path.places = smoothed(sample(wander(spec, from_s, to_s, Stream(seed, "wander " + spec.id))),
                             0.15 * kRate);
      break;
    case PathKind::kTrack: {
      auto places = follow_track(spec.track, from_s, to_s);
      if (!places) return base::fail(places.error());
      path.places = smoothed(*places, 0.15 * kRate);
      break;
    }
  }
  return path;
}

}  // namespace touchline::sim::people
