#include "hub/synchronise/synchroniser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace touchline::synchronise {
namespace {

using base::ErrorKind;
using base::MediaTime;

constexpr MediaTime kNever{std::numeric_limits<std::int64_t>::max()};

std::int64_t half_frame_ns(base::FrameRate rate) {
  return static_cast<std::int64_t>(rate.period_s() * 0.5e9);
}

// a - b without overflow, for any two times a source may claim.
std::int64_t distance(MediaTime a, MediaTime b) {
  std::int64_t difference = 0;
  if (__builtin_sub_overflow(a.ns, b.ns, &difference)) {
    return a < b ? std::numeric_limits<std::int64_t>::min()
                 : std::numeric_limits<std::int64_t>::max();
  }
  return difference;
}

std::uint64_t magnitude(std::int64_t value) {
  return value < 0 ? std::uint64_t{0} - static_cast<std::uint64_t>(value)
                   : static_cast<std::uint64_t>(value);
}

}  // namespace

base::Status SyncOptions::validate() const {
  const auto bad = [](const char* field, const std::string& value, const char* bound) {
    return base::fail(ErrorKind::kConfiguration, fmt::format("synchronise.{}", field),
                      fmt::format("{} is not {}", value, bound));
  };
  if (rate.num <= 0 || rate.den <= 0 || rate.hz() < 0.1 || rate.hz() > 1000) {
    return bad("rate", base::to_string(rate), "within 0.1 to 1000 frames a second");
  }
  if (tolerance_ns < 0 || tolerance_ns > half_frame_ns(rate)) {
    return bad("tolerance_ns", std::to_string(tolerance_ns), "within 0 and half a frame");
  }
  if (deadline_ns <= 0 || deadline_ns > 10'000'000'000) {
    return bad("deadline_ns", std::to_string(deadline_ns), "above 0 and at most 10 s");
  }
  return {};
}

Synchroniser::Synchroniser(std::vector<base::CameraId> cameras, const SyncOptions& options)
    : options_(options),
      tolerance_ns_(options.tolerance_ns > 0 ? options.tolerance_ns : half_frame_ns(options.rate)),
      cameras_(cameras.size()) {
  for (base::CameraId& camera : cameras) {
    rank_.push_back(rank_.size());
    report_.cameras.push_back({std::move(camera)});
  }
}

std::optional<std::size_t> Synchroniser::index_of(const base::CameraId& camera) const {
  for (std::size_t i = 0; i < report_.cameras.size(); ++i) {
    if (report_.cameras[i].camera == camera) return i;
  }
  return std::nullopt;
}

std::vector<scene::FrameSet> Synchroniser::push(codec::EncodedView view) {
  const std::optional<std::size_t> index = index_of(view.id.camera);
  if (!index) {
    ++report_.unknown_camera;
    return {};
  }
  Camera& camera = cameras_[*index];
  CameraSyncReport& report = report_.cameras[*index];
  ++report.pushed;
  const MediaTime time = view.stamp.media_time;
  if (camera.newest && view.id.epoch > camera.epoch) camera.ended = false;  // the unit restarted
  const bool same_run = camera.newest && view.id.epoch == camera.epoch;
  if (camera.ended || (camera.newest && (time <= *camera.newest || view.id.epoch < camera.epoch)) ||
      (same_run && view.id.sequence <= camera.newest_sequence)) {
    ++report.disorder;
    return {};
  }
  if (same_run) {
    const std::uint64_t step = view.id.sequence - camera.newest_sequence;
    report.missing_sequence += step - 1;
    if (!camera.period_ns) {
      camera.period_ns = distance(time, *camera.newest) /
                         static_cast<std::int64_t>(std::min<std::uint64_t>(step, 1u << 30));
      rank_cameras();
    }
  }
  camera.newest = time;
  camera.newest_sequence = view.id.sequence;
  camera.epoch = view.id.epoch;
  if (options_.mode == SyncMode::kLive && last_instant_ &&
      distance(time, *last_instant_) <= tolerance_ns_) {
    ++report.late;
    return {};
  }
  camera.frames.push_back(std::move(view));
  if (options_.mode == SyncMode::kLive) return {};
  return emit_ready(std::nullopt);
}

std::vector<scene::FrameSet> Synchroniser::advance(MediaTime now) {
  if (options_.mode != SyncMode::kLive) return {};
  return emit_ready(now);
}

std::vector<scene::FrameSet> Synchroniser::end(const base::CameraId& camera) {
  if (const std::optional<std::size_t> index = index_of(camera)) cameras_[*index].ended = true;
  if (options_.mode == SyncMode::kLive) return {};
  return emit_ready(std::nullopt);
}

std::vector<scene::FrameSet> Synchroniser::finish() {
  for (Camera& camera : cameras_) camera.ended = true;
  return emit_ready(kNever);
}

std::size_t Synchroniser::waiting(const base::CameraId& camera) const {
  const std::optional<std::size_t> index = index_of(camera);
  return index ? cameras_[*index].frames.size() : 0;
}

// Shortest period first; those within a fifth of the shortest that is left keep their order.
void Synchroniser::rank_cameras() {
  const auto period = [&](std::size_t camera) {
    return cameras_[camera].period_ns.value_or(std::numeric_limits<std::int64_t>::max());
  };
  std::vector<std::size_t> left(cameras_.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  rank_.clear();
  while (!left.empty()) {
    std::int64_t shortest = std::numeric_limits<std::int64_t>::max();
    for (const std::size_t camera : left) shortest = std::min(shortest, period(camera));
    const auto next = std::find_if(left.begin(), left.end(), [&](std::size_t camera) {
      return static_cast<double>(period(camera)) <= 1.2 * static_cast<double>(shortest);
    });
    rank_.push_back(*next);
    left.erase(next);
  }
}

// The camera whose oldest frame gives the next instant: the first in rank; but where frames lie so
// far before its frame that it cannot take them, the first in rank of those that have such frames,
// and so on. `before`: frames from this time on belong to a later set.
std::optional<std::size_t> Synchroniser::next_leader(MediaTime* before) const {
  *before = kNever;
  std::optional<std::size_t> leader;
  while (true) {
    std::optional<std::size_t> found;
    for (const std::size_t camera : rank_) {
      const auto& frames = cameras_[camera].frames;
      if (!frames.empty() && frames.front().stamp.media_time < *before) {
        found = camera;
        break;
      }
    }
    if (!found) return leader;
    leader = found;
    const MediaTime instant = cameras_[*leader].frames.front().stamp.media_time;
    bool earlier = false;
    for (const Camera& camera : cameras_) {
      earlier =
          earlier || (!camera.frames.empty() &&
                      distance(instant, camera.frames.front().stamp.media_time) > tolerance_ns_);
    }
    if (!earlier) return leader;
    *before = MediaTime{instant.ns - tolerance_ns_};
  }
}

std::vector<scene::FrameSet> Synchroniser::emit_ready(std::optional<MediaTime> now) {
  std::vector<scene::FrameSet> sets;
  while (true) {
    if (options_.mode == SyncMode::kReplay && !all_cameras_known()) return sets;
    MediaTime before = kNever;
    const std::optional<std::size_t> leader = next_leader(&before);
    if (!leader) return sets;
    const MediaTime instant = cameras_[*leader].frames.front().stamp.media_time;
    if (options_.mode == SyncMode::kLive) {
      if (distance(*now, instant) < options_.deadline_ns) return sets;
    } else if (!all_cameras_past(instant)) {
      return sets;
    }
    sets.push_back(take_set(*leader, before));
  }
}

// Replay: each camera that runs has shown its period, by which the leader is chosen.
bool Synchroniser::all_cameras_known() const {
  return std::all_of(cameras_.begin(), cameras_.end(), [](const Camera& camera) {
    return camera.ended || camera.period_ns.has_value();
  });
}

// Replay: each camera that runs has brought a frame at or after the end of the instant's reach, so
// that its nearest frame is known.
bool Synchroniser::all_cameras_past(MediaTime instant) const {
  return std::all_of(cameras_.begin(), cameras_.end(), [&](const Camera& camera) {
    return camera.ended ||
           (!camera.frames.empty() && camera.frames.back().stamp.media_time >= instant);
  });
}

scene::FrameSet Synchroniser::take_set(std::size_t leader, MediaTime before) {
  MediaTime instant = cameras_[leader].frames.front().stamp.media_time;
  // Frames within reach that have a nearer successor make a set before this one, at the earliest of
  // their times.
  std::vector<std::size_t> surplus;
  MediaTime earliest = kNever;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    const auto& frames = cameras_[i].frames;
    if (i == leader || frames.size() < 2) continue;
    const MediaTime first = frames[0].stamp.media_time;
    const MediaTime second = frames[1].stamp.media_time;
    if (second < before &&
        magnitude(distance(second, instant)) < magnitude(distance(first, instant))) {
      surplus.push_back(i);
      earliest = std::min(earliest, first);
    }
  }
  std::vector<std::optional<codec::EncodedView>> views(cameras_.size());
  if (!surplus.empty()) {
    instant = earliest;
    for (const std::size_t i : surplus) {
      if (distance(cameras_[i].frames.front().stamp.media_time, instant) <= tolerance_ns_) {
        views[i] = pop_front(i);
      }
    }
  } else {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const auto& frames = cameras_[i].frames;
      if (frames.empty()) continue;
      const MediaTime time = frames.front().stamp.media_time;
      if (time >= before ||
          magnitude(distance(time, instant)) > static_cast<std::uint64_t>(tolerance_ns_)) {
        continue;
      }
      views[i] = pop_front(i);
    }
  }
  return make_set(instant, std::move(views));
}

codec::EncodedView Synchroniser::pop_front(std::size_t index) {
  codec::EncodedView view = std::move(cameras_[index].frames.front());
  cameras_[index].frames.pop_front();
  return view;
}

scene::FrameSet Synchroniser::make_set(MediaTime instant,
                                       std::vector<std::optional<codec::EncodedView>> views) {
  scene::FrameSet set;
  set.instant = instant;
  ++report_.sets;
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    Camera& camera = cameras_[i];
    CameraSyncReport& report = report_.cameras[i];
    scene::FrameSetEntry entry{report.camera, scene::Absent{absent_reason(camera, instant)}};
    if (views[i]) {
      ++report.emitted;
      camera.started = true;
      camera.last_sequence = views[i]->id.sequence;
      entry.view = *std::move(views[i]);
    } else if (camera.started && !(camera.ended && camera.frames.empty())) {
      ++report.gaps;
    }
    set.entries.push_back(std::move(entry));
  }
  last_instant_ = instant;
  return set;
}

// Why a camera has nothing here.
scene::AbsentReason Synchroniser::absent_reason(const Camera& camera, MediaTime instant) const {
  if (camera.ended && camera.frames.empty()) return scene::AbsentReason::kEnded;
  if (!camera.started) return scene::AbsentReason::kNotYet;
  if (!camera.frames.empty()) {
    // The next frame is there: either one is missing in between, or the camera is slower.
    const bool missing = camera.frames.front().id.epoch == camera.epoch &&
                         camera.frames.front().id.sequence > camera.last_sequence + 1;
    return missing ? scene::AbsentReason::kLostInTransit : scene::AbsentReason::kNotYet;
  }
  // Live: a frame that was due by now has not come.
  const bool due = camera.newest && camera.period_ns &&
                   distance(instant, *camera.newest) + tolerance_ns_ >= *camera.period_ns;
  return due ? scene::AbsentReason::kLate : scene::AbsentReason::kNotYet;
}

}  // namespace touchline::synchronise
