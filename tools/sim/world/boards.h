// What stands on the boards round the ground: designs of letters and shapes, printed or on LED
// walls that move and change.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/sim/world/world_spec.h"

namespace touchline::sim::world {

struct BoardLook {
  Colour albedo = Colour::Zero();    // printed
  Colour emission = Colour::Zero();  // LED
};

class BoardPaint {
 public:
  BoardPaint(const BoardsSpec& spec, std::uint64_t seed);

  // `along` and `up` in metres from the board's lower left corner as seen from the pitch; `size` is
  // the width of the sample on the board, metres; `side` names the row of boards.
  BoardLook at(Boards kind, int side, float along, float up, float size, double time_s) const;

  static constexpr float kAspect = 8;  // of one design: so many times as long as high

 private:
  Colour design(std::uint32_t index, float along, float up, float size) const;

  BoardsSpec spec_;
  std::uint32_t stream_;
  struct Design {
    std::vector<std::uint32_t> offset;  // of each level
    std::vector<std::uint8_t> texels;   // square roots of the colour, three a texel
  };
  std::vector<Design> designs_;
};

}  // namespace touchline::sim::world
