#include "edge/key/worn_colours.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>
#include <vector>

namespace touchline::key {
namespace {

using Codes = std::array<unsigned, 3>;

bool says(const WornColours& colours, const Codes& c) {
  return (colours.worn()[chroma_place(c[1], c[2])] >> place_step(c[0]) & 1U) != 0;
}

// By the definition: the counted colours at most a step away in every direction.
bool is_worn(const std::vector<Codes>& counted, const Codes& c, double share) {
  const auto near = [&](const Codes& o) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<int>(place_step(o[k]));
      const auto b = static_cast<int>(place_step(c[k]));
      if (std::abs(a - b) > 1) return false;
    }
    return true;
  };
  const auto n = std::count_if(counted.begin(), counted.end(), near);
  return n > 0 && static_cast<double>(n) >= share * static_cast<double>(counted.size());
}

TEST(WornColours, AreThoseOfTheDefinitionPersonAfterPerson) {
  std::mt19937 random(4);
  const auto code = [&] { return static_cast<unsigned>(random() % 1024); };
  WornColours colours(0.05);
  for (int person = 0; person < 20; ++person) {
    colours.clear();
    std::vector<Codes> counted;
    // Some clusters, at the corners of the palette too, and strays.
    for (int cluster = 0; cluster < 4; ++cluster) {
      Codes middle;
      for (unsigned& value : middle) {
        const auto where = random() % 4;
        value = where == 0 ? 0 : where == 1 ? 1023 : code();
      }
      const int n = static_cast<int>(random() % 60);
      for (int k = 0; k < n; ++k) {
        Codes c = middle;
        for (unsigned& value : c)
          value = static_cast<unsigned>(
              std::clamp(static_cast<int>(value) + static_cast<int>(random() % 81) - 40, 0, 1023));
        counted.push_back(c);
      }
    }
    for (const Codes& c : counted) colours.add(colour_place(c[0], c[1], c[2]));
    ASSERT_EQ(colours.total(), static_cast<int>(counted.size()));
    colours.finish();
    for (int k = 0; k < 500; ++k) {
      const Codes asked = k % 2 == 0 || counted.empty() ? Codes{code(), code(), code()}
                                                        : counted[random() % counted.size()];
      ASSERT_EQ(says(colours, asked), is_worn(counted, asked, 0.05))
          << asked[0] << ' ' << asked[1] << ' ' << asked[2];
    }
  }
}

TEST(WornColours, NobodyWearsAnything) {
  WornColours colours(0.05);
  colours.finish();
  EXPECT_TRUE(std::all_of(colours.worn().begin(), colours.worn().end(),
                          [](std::uint32_t bits) { return bits == 0; }));
}

}  // namespace
}  // namespace touchline::key
