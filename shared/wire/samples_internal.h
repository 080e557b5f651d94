// Messages <-> the generated types of touchline.idl.
#pragma once

#include <cstdint>

#include "shared/base/result.h"
#include "shared/wire/inbox.h"
#include "shared/wire/messages.h"
#include "shared/wire/unit_table.h"
#include "touchline_idl/touchline.h"

namespace touchline::wire {

// Messages within their bounds (bounds.h).
void to_sample(const FrameMessage& message, idl::Frame& sample);
void to_sample(const PlateMessage& message, idl::Plate& sample);
void to_sample(const UnitReport& report, idl::Status& sample);
idl::Command to_sample(const Reply& reply);
// `address` names the unit; its kind and credit do not matter.
idl::Command to_sample(const Reply& address, const CommandMessage& message);
void to_sample(const PeopleMessage& message, idl::People& sample);

// Take the sample's bytes. Error kUnsupported for another schema, else as check_bounds().
base::Result<FrameMessage> from_sample(idl::Frame& sample);
base::Result<PlateMessage> from_sample(idl::Plate& sample);
// A sample of another schema gives a report with that schema and nothing else but the camera.
base::Result<UnitReport> from_sample(const idl::Status& sample);
base::Result<PeopleMessage> from_sample(const idl::People& sample);

// Kinds of idl::Command below this are ReplyKind, from it on CommandKind.
inline constexpr std::uint8_t kFirstCommandKind = 16;

}  // namespace touchline::wire
