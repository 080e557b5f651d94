// An edge unit's end of the wire (design.md section 4).
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/wire/link_options.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

struct EdgeLinkReport {
  std::uint64_t frames_sent = 0;
  std::uint64_t plates_sent = 0;
  std::uint64_t bytes_sent = 0;    // of payload
  std::uint64_t frames_alone = 0;  // live: frames sent while no hub listened; they are lost
  double waited_s = 0;             // time that send() waited for credit
};

// send() and finish() may be called from one thread at a time, the rest from any. Errors:
// kUnavailable no hub, or it has gone; kConfiguration refused by the hub (another unit has this
// camera id, camera not configured, other mode or schema), naming the camera; kLimit a message
// beyond the schema's bounds; kCancelled a stop was requested.
class EdgeLink {
 public:
  // `epoch` grows each time the unit starts. Messages carry this camera and epoch; send() refuses
  // others with kInternal.
  static base::Result<std::unique_ptr<EdgeLink>> open(const LinkOptions& options,
                                                      const base::CameraId& camera,
                                                      std::uint32_t epoch);
  ~EdgeLink();
  EdgeLink(const EdgeLink&) = delete;
  EdgeLink& operator=(const EdgeLink&) = delete;

  // Until the hub has taken this unit in. kTimeout when there is none within the time.
  base::Status wait_for_hub(std::chrono::milliseconds timeout, std::stop_token stop = {});

  // Replay: waits for credit; an Error when the hub is not there or dies. Live: never waits for the
  // hub; without one the message is lost and counted.
  base::Status send(const FrameMessage& message, std::stop_token stop = {});
  base::Status send(const PlateMessage& message, std::stop_token stop = {});
  base::Status send(const StatusMessage& message);

  // Sends the end-of-stream marker. Replay: returns when the hub has handed out every frame and
  // plate tile to its caller. Live: when all is acknowledged or the lease has passed.
  base::Status finish(std::stop_token stop = {});

  // The next command of the hub to this unit, if one has come.
  std::optional<CommandMessage> take_command();

  // The next the hub has said of people whom other cameras see, oldest first; those that nobody
  // took give way to newer ones.
  std::optional<PeopleMessage> take_people();

  EdgeLinkReport report() const;

 private:
  struct Impl;
  explicit EdgeLink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::wire
