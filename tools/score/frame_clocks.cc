#include "tools/score/frame_clocks.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "shared/recording/timing_table.h"

namespace touchline::score {

base::Result<FrameClocks> FrameClocks::open(const recording::Recording& recording) {
  FrameClocks clocks;
  clocks.rate_ = recording.rate;
  clocks.start_ = recording.start;
  for (const recording::CameraEntry& entry : recording.cameras) {
    Clock clock;
    clock.rate = entry.rate;
    clock.offset_ns = entry.offset_ns;
    clock.regular = entry.rate == recording.rate && entry.offset_ns == 0 && entry.timing.empty();
    if (!entry.timing.empty()) {
      const auto rows = recording::read_timing_table(entry.timing);
      if (!rows) return base::fail(rows.error());
      // Of frames that repeat one instant the first stands.
      for (const recording::TimingRow& row : *rows) {
        clock.at.try_emplace(row.media_time.ns, row.frame);
      }
    }
    clocks.clocks_[entry.id] = std::move(clock);
  }
  return clocks;
}

std::int64_t FrameClocks::nearest_instant(std::int64_t time_ns) const {
  const auto off = [&](std::int64_t n) {
    return std::abs(base::frame_time(start_, rate_, n).ns - time_ns);
  };
  auto n = static_cast<std::int64_t>(
      std::llround(static_cast<double>(time_ns - start_.ns) * 1e-9 * rate_.hz()));
  while (off(n - 1) < off(n)) --n;
  while (off(n + 1) < off(n)) ++n;
  return n;
}

std::optional<std::int64_t> FrameClocks::video_frame(const base::CameraId& camera,
                                                     std::int64_t instant) const {
  const auto found = clocks_.find(camera);
  if (found == clocks_.end() || found->second.regular) return instant;
  const Clock& clock = found->second;
  const std::int64_t time = base::frame_time(start_, rate_, instant).ns;
  const double period = std::min(rate_.period_s(), clock.rate.period_s());
  const auto reach = static_cast<std::int64_t>(period * 1e9 / 2) + 1;
  std::int64_t best_time = 0;
  std::int64_t best = -1;
  const auto consider = [&](std::int64_t frame, std::int64_t at) {
    if (nearest_instant(at) != instant) return;
    if (best < 0 || std::abs(at - time) < std::abs(best_time - time)) {
      best = frame;
      best_time = at;
    }
  };
  if (!clock.at.empty()) {
    const auto after = clock.at.lower_bound(time);
    if (after != clock.at.begin()) consider(std::prev(after)->second, std::prev(after)->first);
    if (after != clock.at.end()) consider(after->second, after->first);
  } else {
    const double seconds = static_cast<double>(time - start_.ns - clock.offset_ns) / 1e9;
    const auto near = static_cast<std::int64_t>(std::floor(seconds * clock.rate.hz()));
    for (std::int64_t frame = std::max<std::int64_t>(near - 1, 0); frame <= near + 1; ++frame) {
      consider(frame, base::frame_time(start_, clock.rate, frame).ns + clock.offset_ns);
    }
  }
  if (best < 0 || std::abs(best_time - time) > reach) return std::nullopt;
  return best;
}

std::vector<std::int64_t> FrameClocks::instants(const base::CameraId& camera,
                                                std::int64_t last) const {
  std::vector<std::int64_t> out;
  const auto found = clocks_.find(camera);
  if (found == clocks_.end() || last < 0) return out;
  const Clock& clock = found->second;
  const std::int64_t end = clock.at.empty()
                               ? base::frame_time(start_, clock.rate, last).ns + clock.offset_ns
                               : clock.at.rbegin()->first;
  const double seconds = static_cast<double>(end - start_.ns) / 1e9;
  const auto most = static_cast<std::int64_t>(std::ceil(seconds * rate_.hz())) + 1;
  for (std::int64_t instant = 0; instant <= std::min<std::int64_t>(most, 10'000'000); ++instant) {
    const auto frame = video_frame(camera, instant);
    if (frame && *frame <= last) out.push_back(instant);
  }
  return out;
}

}  // namespace touchline::score
