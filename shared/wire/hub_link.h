// The hub's end of the wire (design.md section 4).
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/wire/link_options.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

struct HubLinkReport {
  std::uint64_t frames = 0;  // handed out
  std::uint64_t plates = 0;
  std::uint64_t bytes = 0;            // of payload
  std::uint64_t frames_dropped = 0;   // live: oldest frames that made room, because next() was slow
  std::uint64_t samples_refused = 0;  // of units not taken in, or beyond bounds or credit
};

// next() may be called from one thread, the rest from any.
class HubLink {
 public:
  // Units of other cameras than these are refused. Camera ids must be valid and distinct.
  static base::Result<std::unique_ptr<HubLink>> open(const LinkOptions& options,
                                                     std::span<const base::CameraId> cameras);
  ~HubLink();
  HubLink(const HubLink&) = delete;
  HubLink& operator=(const HubLink&) = delete;

  // Waits for the next event; nothing when a stop is requested or after close(). Of one unit:
  // UnitAppeared first; frames in the order sent; EndOfStream after everything it sent; UnitGone
  // last. Taking a frame or plate tile out gives its unit credit for more.
  std::optional<Event> next(std::stop_token stop = {});

  // Error kNotFound when no unit of that camera is there.
  base::Status send(const CommandMessage& command);

  // To every unit that listens, and to nobody where none does; what is lost on the way stays lost.
  base::Status send(const PeopleMessage& people);

  // Replay: while paused, a camera gets no more credit; what is on the way still comes. For a
  // camera that is far ahead of the others.
  void pause(const base::CameraId& camera, bool paused);

  // No more events; next() hands out those that have come.
  void close();

  HubLinkReport report() const;

 private:
  struct Impl;
  explicit HubLink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::wire
