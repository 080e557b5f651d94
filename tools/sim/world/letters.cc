#include "tools/sim/world/letters.h"

#include <array>
#include <cmath>

namespace touchline::sim::world {
namespace {

constexpr float kAdvance = 5.5f;

// Each stroke is four digits: x0 y0 x1 y1.
constexpr std::array<std::string_view, 26> kLetters = {
    "0026 2640 1232",
    "0006 0636 3645 4544 4433 0333 3342 4241 4130 3000",
    "4536 3616 1605 0501 0110 1030 3041",
    "0006 0626 2645 4541 4120 2000",
    "0006 0646 0333 0040",
    "0006 0646 0333",
    "4536 3616 1605 0501 0110 1030 3041 4143 4323",
    "0006 4046 0343",
    "2026",
    "4641 4130 3010 1001",
    "0006 0246 1340",
    "0006 0040",
    "0006 0623 2346 4640",
    "0006 0640 4046",
    "1636 3645 4541 4130 3010 1001 0105 0516",
    "0006 0636 3645 4544 4433 3303",
    "1636 3645 4541 4130 3010 1001 0105 0516 2240",
    "0006 0636 3645 4544 4433 3303 2340",
    "4536 3616 1605 0504 0413 1333 3342 4241 4130 3010 1001",
    "0646 2026",
    "0601 0110 1030 3041 4146",
    "0620 2046",
    "0610 1023 2330 3046",
    "0046 0640",
    "0623 4623 2320",
    "0646 4600 0040",
};

}  // namespace

std::vector<LetterStroke> strokes_of(std::string_view word) {
  std::vector<LetterStroke> strokes;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (word[i] < 'A' || word[i] > 'Z') continue;
    const std::string_view code = kLetters[static_cast<std::size_t>(word[i] - 'A')];
    const float left = kAdvance * static_cast<float>(i);
    for (std::size_t k = 0; k + 4 <= code.size(); k += 5) {
      const auto digit = [&](std::size_t d) { return static_cast<float>(code[k + d] - '0'); };
      strokes.push_back({left + digit(0), digit(1), left + digit(2), digit(3)});
    }
  }
  return strokes;
}

float width_of(std::string_view word) {
  return kAdvance * static_cast<float>(word.size()) - (kAdvance - 4);
}

}  // namespace touchline::sim::world
