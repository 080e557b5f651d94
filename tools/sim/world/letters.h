// Words in strokes, for boards.
#pragma once

#include <string_view>
#include <vector>

namespace touchline::sim::world {

struct LetterStroke {
  float x0, y0, x1, y1;
};

// Capital letters and blanks on a grid of four by six units a letter, five and a half units from
// one letter to the next; y upwards. Other characters are blanks.
std::vector<LetterStroke> strokes_of(std::string_view word);
float width_of(std::string_view word);  // units

}  // namespace touchline::sim::world
