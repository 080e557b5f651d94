// What an operator may tell a running unit about the key's colours: the text of the wire's
// key-training command.
//
//   click X Y        the colour at a pixel of the newest frame is background
//   colour #3a7d2c   this colour is
//   undo             takes the last of those back
//   radii R1 R2      sets both radii
//   clear            forgets all colours
//   save, load       to and from the unit's file
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <variant>

#include "edge/key/colour_training.h"
#include "shared/base/result.h"
#include "shared/image/frame.h"

namespace touchline::key {

struct ClickOrder {
  int x = 0, y = 0;
  bool operator==(const ClickOrder&) const = default;
};
struct ColourOrder {
  image::Rgb8 colour{};
  bool operator==(const ColourOrder&) const = default;
};
struct RadiiOrder {
  double r1 = 0, r2 = 0;
  bool operator==(const RadiiOrder&) const = default;
};
enum class PlainOrder : std::uint8_t { kUndo, kClear, kSave, kLoad };
using TrainingOrder = std::variant<ClickOrder, ColourOrder, RadiiOrder, PlainOrder>;

// Errors: kArgument, naming the words there are.
base::Result<TrainingOrder> parse_training_order(std::string_view text);

// Does it, and says what was done. `newest` is the frame that clicks are on, null where there is
// none; `file` is the unit's, empty where it has none. On an error nothing is changed.
base::Result<std::string> obey(const TrainingOrder& order, const image::Frame* newest,
                               const std::filesystem::path& file, ColourTraining& training);

}  // namespace touchline::key
