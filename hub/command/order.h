// A line of an operator as a command of the wire (design.md section 4): "CAMERA key ORDER", where
// ORDER is for the unit's key (edge/key/training_order.h has the words), e.g. "m1 key click 640
// 360".
#pragma once

#include <string_view>

#include "shared/base/result.h"
#include "shared/wire/messages.h"

namespace touchline::command {

// Errors: kArgument for a line without camera, kind or text, a camera that is no id, a kind that is
// not known.
base::Result<wire::CommandMessage> parse_order(std::string_view line);

}  // namespace touchline::command
