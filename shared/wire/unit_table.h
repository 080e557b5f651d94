// Who is there, and how much each may send: the hub's side of the link protocol, without DDS and
// without threads.
//
// A unit is taken in when all four of its endpoints are connected and a status sample has told its
// camera, epoch, mode and schema. It is refused when it is of another schema or mode, or its camera
// is not configured. When another unit has that camera, the newcomer waits: the first sign of life
// of the first unit, or the end of its lease, decides. So a duplicate is refused, and a unit that
// was killed and started again is taken in.
//
// Replay: a unit may send until the credit it was granted since it started is used up. The grant is
// what was handed out of that unit plus the option's credit_bytes.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/wire/inbox.h"
#include "shared/wire/link_options.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

enum class ReplyKind : std::uint8_t { kAccepted = 0, kRefused = 1, kCredit = 2, kComplete = 3 };

// What the hub answers a unit.
struct Reply {
  UnitKey unit{};
  ReplyKind kind{};
  std::string camera;
  std::uint32_t epoch = 0;
  std::uint64_t credit_bytes = 0;
  std::string text;
};

class UnitTable {
 public:
  using Time = std::chrono::steady_clock::time_point;

  struct Outcome {
    std::vector<Event> events;
    std::vector<Reply> replies;
    std::vector<UnitKey> forgotten;  // nothing of these is connected any more
  };

  UnitTable(const LinkOptions& options, std::span<const base::CameraId> cameras);

  Outcome process(InboxItem item, Time now);
  // Replay: a paused camera gets no more credit.
  Outcome pause(const std::string& camera, bool paused);
  // Of the unit that has this camera.
  std::optional<Reply> address(const std::string& camera) const;
  std::vector<Reply> everyone() const;
  // Samples that were not taken: of units not taken in, or beyond bounds.
  std::uint64_t refused() const { return refused_; }

 private:
  enum class State : std::uint8_t { kArriving, kTaken, kRefused, kGone };
  struct Unit {
    State state = State::kArriving;
    unsigned endpoints = 0;  // bits of Endpoint
    std::optional<UnitReport> hello;
    std::optional<Time> waiting_since;  // for the unit that has the camera to show itself
    std::vector<PlateMessage> held;     // plate tiles that came before it was taken in
    std::size_t held_bytes = 0;
    std::string camera;
    std::uint32_t epoch = 0;
    std::uint64_t frames = 0;
    std::uint64_t plates = 0;
    std::uint64_t used_bytes = 0;     // of credit, by what was handed out
    std::uint64_t granted_bytes = 0;  // by the last reply
    std::optional<EndOfStream> end;
    bool finished = false;
  };

  void consider(const UnitKey& key, Unit& unit, Time now, Outcome& out);
  void take_in(const UnitKey& key, Unit& unit, Outcome& out);
  void refuse(const UnitKey& key, Unit& unit, std::string why, Outcome& out);
  void connection(const UnitKey& key, EndpointChange change, Time now, Outcome& out);
  void report(const UnitKey& key, UnitReport report, Time now, Outcome& out);
  void frame(const UnitKey& key, FrameMessage message, Outcome& out);
  void plate(const UnitKey& key, PlateMessage message, Outcome& out);
  void tick(Time now, Outcome& out);
  void sign_of_life(const UnitKey& key, Outcome& out);
  void stray(const UnitKey& key, Unit& unit, Outcome& out);
  std::string silence_text(const std::string& camera) const;
  void grant(const UnitKey& key, Unit& unit, bool always, Outcome& out);
  void complete_if_all_here(const UnitKey& key, Unit& unit, Outcome& out);
  void leave(const UnitKey& key, Unit& unit, Time now, Outcome& out);

  const LinkOptions options_;
  std::set<std::string> cameras_;
  std::set<std::string> paused_;
  std::map<UnitKey, Unit> units_;
  std::map<std::string, UnitKey> holders_;  // of each camera, while taken in
  std::set<UnitKey> lost_;                  // replay: went before their end
  std::uint64_t refused_ = 0;
};

}  // namespace touchline::wire
