// What an edge unit knows -> messages for the wire. Values are carried over unchanged; the wire
// checks its own bounds when they are sent.
#pragma once

#include <cstdint>

#include "edge/publish/unit_status.h"
#include "shared/codec/camera_view.h"
#include "shared/codec/encoded_plate.h"
#include "shared/wire/messages.h"

namespace touchline::publish {

wire::FrameMessage to_message(const codec::EncodedView& view);
// `epoch` is the unit's run, as in its frames.
wire::PlateMessage to_message(const codec::EncodedPlateTile& tile, std::uint32_t epoch);
// Texts, names and lists longer than the wire's bounds are cut.
wire::StatusMessage to_message(const UnitStatus& status);

}  // namespace touchline::publish
