// Puts the cameras' frames side by side by media time, never by arrival.
//
// Cameras are ranked by frame period (of their first two frames), those within a fifth of each
// other counting as equal, then by configuration order. The instants of the sets are the frame
// times of the first in rank that has a frame there; every other camera gives its nearest frame, if
// that lies within the tolerance. So a slower camera is absent between its frames, cameras whose
// shutters are not locked together still meet, and where the leading camera misses a frame the next
// in rank leads. A frame that no instant takes makes a set at its own time: in replay every pushed
// frame is emitted exactly once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "hub/scene/frame_set.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/codec/camera_view.h"

namespace touchline::synchronise {

enum class SyncMode : std::uint8_t { kReplay, kLive };

struct SyncOptions {
  // kReplay waits for every camera that has not ended; kLive emits at the deadline.
  SyncMode mode = SyncMode::kReplay;
  // Rate of the fastest camera.
  base::FrameRate rate;
  // Greatest distance of a frame's media time from its set's instant, ns; at most half a frame of
  // `rate`, which is what 0 stands for.
  std::int64_t tolerance_ns = 0;
  // kLive: declared latency. A set is emitted once `now` is this much past its instant, ns;
  // above 0, at most 10 s.
  std::int64_t deadline_ns = 200'000'000;

  base::Status validate() const;
};

struct CameraSyncReport {
  base::CameraId camera;
  std::uint64_t pushed = 0;
  std::uint64_t emitted = 0;
  std::uint64_t late = 0;              // kLive: came after their set had gone; not emitted
  std::uint64_t disorder = 0;          // media time, sequence or epoch went back; not emitted
  std::uint64_t gaps = 0;              // sets in which this camera was absent while it ran
  std::uint64_t missing_sequence = 0;  // frames lost before, by sequence numbers
};

struct SyncReport {
  std::uint64_t sets = 0;
  std::vector<CameraSyncReport> cameras;  // in configuration order
  std::uint64_t unknown_camera = 0;       // pushed for a camera that is not configured
};

// Media times within +-4e18 ns. Not thread-safe: one thread pushes. Frame sets come out in rising
// order of their instants.
class Synchroniser {
 public:
  Synchroniser(std::vector<base::CameraId> cameras, const SyncOptions& options);

  std::vector<scene::FrameSet> push(codec::EncodedView view);
  // kLive: time passes. In kReplay it has no effect.
  std::vector<scene::FrameSet> advance(base::MediaTime now);
  // This camera sends no more: the others no longer wait for it.
  std::vector<scene::FrameSet> end(const base::CameraId& camera);
  // All cameras have ended: everything that waits comes out.
  std::vector<scene::FrameSet> finish();

  // Frames of a camera that wait for the others. A feeder that must bound its memory pauses a
  // camera that is far ahead.
  std::size_t waiting(const base::CameraId& camera) const;
  const SyncReport& report() const { return report_; }

 private:
  struct Camera {
    std::deque<codec::EncodedView> frames;
    std::optional<base::MediaTime> newest;  // of all frames taken in
    std::uint64_t newest_sequence = 0;
    std::uint64_t last_sequence = 0;  // of the last frame emitted
    std::uint32_t epoch = 0;
    std::optional<std::int64_t> period_ns;
    bool started = false;  // a frame was emitted
    bool ended = false;
  };

  std::optional<std::size_t> index_of(const base::CameraId& camera) const;
  void rank_cameras();
  bool all_cameras_known() const;
  bool all_cameras_past(base::MediaTime instant) const;
  std::optional<std::size_t> next_leader(base::MediaTime* before) const;
  std::vector<scene::FrameSet> emit_ready(std::optional<base::MediaTime> now);
  scene::FrameSet take_set(std::size_t leader, base::MediaTime before);
  codec::EncodedView pop_front(std::size_t index);
  scene::FrameSet make_set(base::MediaTime instant,
                           std::vector<std::optional<codec::EncodedView>> views);
  scene::AbsentReason absent_reason(const Camera& camera, base::MediaTime instant) const;

  SyncOptions options_;
  std::int64_t tolerance_ns_ = 0;
  std::vector<Camera> cameras_;    // in configuration order
  std::vector<std::size_t> rank_;  // indices into cameras_
  std::optional<base::MediaTime> last_instant_;
  SyncReport report_;
};

}  // namespace touchline::synchronise
