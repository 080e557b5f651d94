// Media time, frame rates, SMPTE timecode and the stamp every frame carries.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "shared/base/result.h"

namespace touchline::base {

// Nanoseconds TAI at mid-exposure. In a recording without a clock it counts from the recording's
// start_tai_ns.
struct MediaTime {
  std::int64_t ns = 0;
  auto operator<=>(const MediaTime&) const = default;
};

// Who vouches for a media time.
enum class ClockDomain : std::uint8_t { kUnknown, kPtp, kNtp, kTimecode, kRecording };

// Frames per second as a fraction; both positive.
struct FrameRate {
  std::int64_t num = 25;
  std::int64_t den = 1;
  bool operator==(const FrameRate&) const = default;
  double hz() const { return static_cast<double>(num) / static_cast<double>(den); }
  double period_s() const { return static_cast<double>(den) / static_cast<double>(num); }
};

// "25/1", "30000/1001" or "25".
Result<FrameRate> parse_frame_rate(const std::string& text);
std::string to_string(FrameRate rate);

// start + round(frame * 1e9 * den / num): the instant of frame k of a recording (formats.md).
MediaTime frame_time(MediaTime start, FrameRate rate, std::int64_t frame);

// SMPTE ST 12 timecode; drop_frame only at 30000/1001 and 60000/1001.
struct Timecode {
  int hours = 0;
  int minutes = 0;
  int seconds = 0;
  int frames = 0;
  bool drop_frame = false;
  bool operator==(const Timecode&) const = default;
};

// "10:00:00:00", with ';' before the frames for drop-frame.
Result<Timecode> parse_timecode(const std::string& text);
std::string to_string(const Timecode& timecode);
// The timecode `frames` later, wrapping at 24 hours.
Timecode advance(const Timecode& start, FrameRate rate, std::int64_t frames);

// When a frame was exposed. Sync is decided on media_time, never on arrival.
struct FrameStamp {
  MediaTime media_time;
  ClockDomain domain = ClockDomain::kUnknown;
  std::int64_t uncertainty_ns = 0;
  std::optional<Timecode> timecode;
  bool operator==(const FrameStamp&) const = default;
};

}  // namespace touchline::base
