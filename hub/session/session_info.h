// What a session says about itself, and the events it keeps beside views and plates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/time.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/recording.h"

namespace touchline::session {

inline constexpr int kSessionFormatVersion = 2;

struct SessionCamera {
  base::CameraId id;
  recording::Role role = recording::Role::kMatch;
  recording::Side side = recording::Side::kMain;
  int width = 0;  // pixels
  int height = 0;
  bool operator==(const SessionCamera&) const = default;
};

struct SessionInfo {
  std::string name;
  pitch::Sport sport = pitch::Sport::kSoccer;
  pitch::PitchSizes sizes;
  base::FrameRate rate;  // of the instants
  base::Timecode start_timecode;
  // Media time of instant 0. Without one the earliest view of the first camera that has any is
  // instant 0.
  std::optional<base::MediaTime> start;
  // A view belongs to an instant that is no farther away than this; 0 = half the period of `rate`.
  std::int64_t tolerance_ns = 0;
  std::vector<SessionCamera> cameras;  // in configuration order
};

// What happened beside the pictures: unit statuses, losses, absences, operator's marks.
struct Event {
  base::MediaTime time;   // media time it concerns, or of its arrival
  base::CameraId camera;  // empty: the hub
  std::string kind;       // "status", "lost", "absent", "mark", ...
  std::string text;       // one line, or JSON
  auto operator<=>(const Event&) const = default;
};

}  // namespace touchline::session
