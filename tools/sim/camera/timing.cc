#include "tools/sim/camera/timing.h"

#include <algorithm>
#include <cmath>

namespace touchline::sim::camera {

Schedule schedule(const TimingSpec& spec, base::FrameRate rate, std::int64_t frames,
                  base::MediaTime start, const Stream& random) {
  Schedule made;
  made.rate = spec.rate.value_or(rate);
  const Stream drops = random.sub("drop"), repeats = random.sub("repeat");
  const Stream jitter = random.sub("jitter");
  const auto asked = [](const std::vector<std::int64_t>& list, std::int64_t number) {
    return std::find(list.begin(), list.end(), number) != list.end();
  };
  const double duration_s = static_cast<double>(frames) * rate.period_s();
  const auto exposures = static_cast<std::int64_t>(std::floor(duration_s * made.rate.hz() + 1e-9));
  const auto offset_ns = static_cast<std::int64_t>(std::llround(spec.offset_ms * 1e6));
  made.table = spec.jitter_us > 0;
  std::int64_t least_ns = std::numeric_limits<std::int64_t>::min();
  for (std::int64_t e = 0; e < exposures; ++e) {
    const auto n = static_cast<std::uint64_t>(e);
    if (asked(spec.drop, e) || drops.uniform(n) < spec.drop_share) {
      made.table = true;
      continue;
    }
    Shot shot;
    shot.frame = static_cast<std::int64_t>(made.shots.size());
    if (!made.shots.empty() && (asked(spec.repeat, e) || repeats.uniform(n) < spec.repeat_share)) {
      made.table = true;
      shot = made.shots.back();
      shot.frame += 1;
      shot.repeats = true;
      made.shots.push_back(shot);
      continue;
    }
    shot.exposure = e;
    const std::int64_t nominal_ns = base::frame_time({}, made.rate, e).ns;
    const auto jitter_ns =
        spec.jitter_us > 0
            ? static_cast<std::int64_t>(std::llround(spec.jitter_us * 1e3 * jitter.gaussian(n)))
            : 0;
    const std::int64_t true_ns = nominal_ns + offset_ns + jitter_ns;
    shot.time_s = static_cast<double>(true_ns) * 1e-9;
    shot.media_time.ns = start.ns + nominal_ns + jitter_ns + (spec.offset_stated ? offset_ns : 0);
    // Times of a table do not fall, whatever the jitter.
    shot.media_time.ns = std::max(shot.media_time.ns, least_ns);
    least_ns = shot.media_time.ns;
    made.shots.push_back(shot);
  }
  // Each instant belongs to the nearest shot, the earlier where two are as near; a repeat has none.
  const double period_ns = rate.period_s() * 1e9;
  std::vector<std::pair<double, Shot*>> nearest(static_cast<std::size_t>(frames),
                                                {0.0, static_cast<Shot*>(nullptr)});
  for (Shot& shot : made.shots) {
    if (shot.repeats) continue;
    const auto since = static_cast<double>(shot.media_time.ns - start.ns);
    const auto instant = static_cast<std::int64_t>(std::llround(since / period_ns));
    if (instant < 0 || instant >= frames) continue;
    auto& [distance, owner] = nearest[static_cast<std::size_t>(instant)];
    const double mine =
        std::abs(since - static_cast<double>(base::frame_time({}, rate, instant).ns));
    if (mine > 0.5e9 * std::min(rate.period_s(), made.rate.period_s()) + 1) continue;
    if (owner != nullptr && mine >= distance) continue;
    if (owner != nullptr) owner->instant = -1;
    distance = mine;
    owner = &shot;
    shot.instant = instant;
  }
  return made;
}

std::vector<recording::TimingRow> timing_rows(const Schedule& schedule,
                                              const base::Timecode& start) {
  std::vector<recording::TimingRow> rows;
  for (const Shot& shot : schedule.shots) {
    rows.push_back(
        {shot.frame, shot.media_time, base::advance(start, schedule.rate, shot.exposure)});
  }
  return rows;
}

std::vector<Shutter> shutters(const TimingSpec& spec, base::FrameRate rate, double time_s) {
  const double period = rate.period_s();
  if (spec.scan == image::Scan::kProgressive) {
    const double half = spec.shutter * period / 2;
    return {{time_s - half, time_s + half}};
  }
  const double half = spec.shutter * period / 4;
  const double first = time_s - period / 4, second = time_s + period / 4;
  return {{first - half, first + half}, {second - half, second + half}};
}

}  // namespace touchline::sim::camera
