// The bounds of touchline.idl, and what a message costs of a unit's credit.
#pragma once

#include <cstddef>

#include "shared/base/result.h"
#include "shared/wire/messages.h"

namespace touchline::wire {

// Error kLimit (kFormat for a text with a NUL) naming the camera, the field, the size and the
// bound. A camera name must be a valid id.
base::Status check_bounds(const FrameMessage& message);
base::Status check_bounds(const PlateMessage& message);
base::Status check_bounds(const StatusMessage& message);
base::Status check_bounds(const CommandMessage& message);
// And kFormat for a place that is no number, farther than kMostPlaceM from the centre spot, or
// whose sd_m is not above 0.
inline constexpr float kMostPlaceM = 1000;
base::Status check_bounds(const PeopleMessage& message);

// Bytes of payload, for reports.
std::size_t payload_bytes(const FrameMessage& message);
std::size_t payload_bytes(const PlateMessage& message);
// What a message takes from a unit's credit: its payload and a fixed share for the rest. Both sides
// must count alike.
inline constexpr std::size_t kMessageCost = 1024;
template <typename Message>
std::size_t credit_cost(const Message& message) {
  return payload_bytes(message) + kMessageCost;
}

}  // namespace touchline::wire
