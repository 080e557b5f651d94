// What the hub's DDS listeners put in and HubLink::next() takes out: everything in the order of
// arrival; of each unit's frames, in live mode, only the newest few.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <variant>

#include "shared/base/bounded_queue.h"
#include "shared/wire/link_options.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

// A unit's participant.
using UnitKey = std::array<std::uint8_t, 12>;

// A status sample: the message and what the link itself says in it.
struct UnitReport {
  std::uint16_t schema = 0;
  Mode mode = Mode::kLive;
  StatusMessage status;
  std::optional<EndOfStream> end;
};

// What of a unit the hub is connected to.
enum class Endpoint : std::uint8_t { kFrames = 1, kPlates = 2, kStatus = 4, kCommands = 8 };

struct EndpointChange {
  Endpoint endpoint{};
  bool connected = false;
};
struct Overdue {};
struct Tick {};
// A sample that broke the schema's bounds; it was thrown away.
struct BadSample {
  std::string what;
};

struct InboxItem {
  UnitKey unit{};
  std::variant<FrameMessage, PlateMessage, UnitReport, EndpointChange, Overdue, Tick, BadSample>
      content;
};

class Inbox {
 public:
  // `max_unit_bytes`: what may wait of one unit, by credit_cost(); more is refused.
  Inbox(Mode mode, int keep_last, std::size_t max_unit_bytes);

  // Never waits. False when closed, or the item was refused.
  bool push(InboxItem item);
  // Waits for the next item; nothing when stopped, or closed and empty.
  std::optional<InboxItem> pop(std::stop_token stop);
  void close();
  // Nothing more is expected of this unit.
  void forget(const UnitKey& unit);

  // Frames that made room for newer ones, and items refused.
  std::uint64_t dropped() const;
  std::uint64_t refused() const;

 private:
  static constexpr std::size_t kMaxItems = 1u << 18;
  static constexpr std::size_t kMaxUnits = 256;

  struct Ticket {
    InboxItem item;
    bool next_of_lane = false;  // live: the oldest frame of the unit's lane is meant
    std::size_t cost = 0;
  };
  struct Lane {
    explicit Lane(std::size_t keep_last) : frames(keep_last, base::FullPolicy::kDropOldest) {}
    base::BoundedQueue<FrameMessage> frames;  // live
    std::size_t bytes = 0;                    // of everything else that waits
  };

  const Mode mode_;
  const std::size_t keep_last_;
  const std::size_t max_unit_bytes_;
  base::BoundedQueue<Ticket> order_;
  mutable std::mutex mutex_;
  std::map<UnitKey, std::unique_ptr<Lane>> lanes_;
  std::uint64_t refused_ = 0;
  std::uint64_t dropped_before_ = 0;  // of units forgotten
};

}  // namespace touchline::wire
