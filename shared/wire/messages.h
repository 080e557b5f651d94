// What travels between an edge unit and the hub, as plain numbers and bytes. The wire knows no
// codec: it checks bounds of its own schema (touchline.idl) and nothing of what the numbers mean.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace touchline::wire {

// Of touchline.idl. A sample with another version is refused with both versions named.
inline constexpr std::uint16_t kSchemaVersion = 2;

// Bounds of touchline.idl; a message beyond them is refused by send() with an Error.
inline constexpr std::size_t kMaxParts = 8;
inline constexpr std::size_t kMaxPartBytes = 16u << 20;
inline constexpr std::size_t kMaxFrameBytes = 32u << 20;  // of all parts together
inline constexpr std::size_t kMaxPlateBytes = 4u << 20;
inline constexpr std::size_t kMaxNameChars = 32;  // camera ids, names of stages and reasons
inline constexpr std::size_t kMaxSourceChars = 1024;
inline constexpr std::size_t kMaxTextChars = 4096;
inline constexpr std::size_t kMaxListEntries = 64;  // stages, drop reasons
inline constexpr std::size_t kMaxPlaces = 64;       // of people whom one camera sees

struct StampFields {
  std::int64_t media_time_ns = 0;
  std::int64_t uncertainty_ns = 0;
  std::uint8_t domain = 0;
  bool has_timecode = false;
  bool drop_frame = false;
  std::uint8_t hours = 0;
  std::uint8_t minutes = 0;
  std::uint8_t seconds = 0;
  std::uint8_t frames = 0;
  bool operator==(const StampFields&) const = default;
};

struct EstimateFields {
  std::array<double, 8> model{};  // width, height, fx, fy, cx, cy, k1, k2
  std::array<double, 7> pose{};   // cam_from_world: qw, qx, qy, qz, tx, ty, tz
  std::array<double, 81> covariance{};
  double rms_px = 0;
  std::uint8_t evidence = 0;
  bool operator==(const EstimateFields&) const = default;
};

struct Part {
  std::uint8_t kind = 0;
  std::uint16_t version = 0;  // of the bytes' own format
  std::vector<std::uint8_t> bytes;
  bool operator==(const Part&) const = default;
};

// One frame of one camera.
struct FrameMessage {
  std::string camera;
  std::uint32_t epoch = 0;
  std::uint64_t sequence = 0;
  StampFields stamp;
  EstimateFields estimate;
  std::vector<Part> parts;
  bool operator==(const FrameMessage&) const = default;
};

// One tile of a camera's plate.
struct PlateMessage {
  std::string camera;
  std::uint32_t epoch = 0;
  std::uint32_t plate_version = 0;
  std::int32_t column = 0;
  std::int32_t row = 0;
  double radians_per_px = 0;
  std::array<double, 3> centre_in_world{};
  std::uint16_t format_version = 0;
  std::vector<std::uint8_t> bytes;
  bool operator==(const PlateMessage&) const = default;
};

enum class UnitState : std::uint8_t { kStarting, kRunning, kEnded, kFailed };

struct StageRate {
  std::string stage;
  double hz = 0;
  double mean_ms = 0;  // time spent on a frame
  bool operator==(const StageRate&) const = default;
};

struct DropCount {
  std::string reason;
  std::uint64_t count = 0;
  bool operator==(const DropCount&) const = default;
};

// How a unit fares; sent about once a second.
struct StatusMessage {
  std::string camera;
  std::uint32_t epoch = 0;
  UnitState state = UnitState::kStarting;
  std::string source;  // what feeds the unit
  std::vector<StageRate> stages;
  std::vector<DropCount> drops;
  std::uint64_t frames_read = 0;
  std::uint64_t frames_sent = 0;
  std::string calibration;  // what the latest estimate rests on: "lines", "lost", ...
  std::string text;         // for people; empty where there is nothing to say
  bool operator==(const StatusMessage&) const = default;
};

// The unit has sent everything. The hub hands it out only when as many frames and plate tiles have
// come as it names.
struct EndOfStream {
  std::string camera;
  std::uint32_t epoch = 0;
  std::uint64_t frames_sent = 0;
  std::uint64_t plates_sent = 0;
  bool operator==(const EndOfStream&) const = default;
};

enum class CommandKind : std::uint8_t { kStart, kStop, kKeyTraining, kTally, kConfigure };

// From the hub to one unit, or to all.
struct CommandMessage {
  std::string camera;  // empty = every unit
  CommandKind kind = CommandKind::kStart;
  std::string text;  // what the command carries, by kind
  bool operator==(const CommandMessage&) const = default;
};

// Where someone stands: pitch frame, metres, on the turf.
struct Place {
  float x = 0;
  float y = 0;
  float sd_m = 0;  // in the direction in which it is known least
  bool operator==(const Place&) const = default;
};

// From the hub to every unit: the people whom one camera sees at an instant.
struct PeopleMessage {
  std::string camera;
  std::int64_t media_time_ns = 0;
  std::uint8_t domain = 0;  // of the clock that the time is of
  std::vector<Place> places;
  bool operator==(const PeopleMessage&) const = default;
};

// A unit was found, is of this schema, and has the camera to itself.
struct UnitAppeared {
  std::string camera;
  std::uint32_t epoch = 0;
};

// A unit has left: it closed its link, or nothing was heard of it for the lease.
struct UnitGone {
  std::string camera;
  std::uint32_t epoch = 0;
  bool finished = false;  // its EndOfStream was handed out before
  std::uint64_t frames_received = 0;
  std::string what;  // for people
};

// A unit was turned away; it has been told why. `camera` is the id it asked for.
struct UnitRefused {
  std::string camera;
  std::uint32_t epoch = 0;
  std::string what;
};

// A live unit's status is overdue: alive, and not getting on.
struct UnitOverdue {
  std::string camera;
};

using Event = std::variant<FrameMessage, PlateMessage, StatusMessage, EndOfStream, UnitAppeared,
                           UnitGone, UnitRefused, UnitOverdue>;

}  // namespace touchline::wire
