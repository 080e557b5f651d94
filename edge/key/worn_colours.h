// Which colours a person wears, told by his sure pixels.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace touchline::key {

// A colour's place in a palette of 32 steps along Y', Cb and Cr, each of 32 ten-bit code values.
using ColourPlace = std::uint16_t;
inline constexpr int kPlaceBits = 5;
inline constexpr unsigned kPlaceSteps = 32;
inline constexpr std::size_t kChromaPlaces = std::size_t{kPlaceSteps} * kPlaceSteps;

// Of ten-bit code values; what is beyond them counts as its lowest ten bits.
inline unsigned place_step(unsigned code) { return code >> kPlaceBits & (kPlaceSteps - 1); }
inline unsigned chroma_place(unsigned cb, unsigned cr) {
  return place_step(cb) * kPlaceSteps + place_step(cr);
}
inline ColourPlace colour_place(unsigned y, unsigned cb, unsigned cr) {
  return static_cast<ColourPlace>(place_step(y) * kChromaPlaces + chroma_place(cb, cr));
}

// Counts colours; a colour is worn when it and those a step away from it in any direction have
// `share` of all that was counted.
class WornColours {
 public:
  explicit WornColours(double share);

  // Forgets what was counted.
  void clear();
  void add(ColourPlace place);
  int total() const { return total_; }
  // After the last of them.
  void finish();
  // Of a chroma_place(): a bit for each step of luma that is worn with it.
  const std::array<std::uint32_t, kChromaPlaces>& worn() const { return worn_; }

 private:
  using Lumas = std::array<std::int32_t, kPlaceSteps>;
  double share_;
  int total_ = 0;
  std::vector<Lumas> count_, near_;  // a chroma place each
  std::array<std::uint32_t, kChromaPlaces> worn_{};
  std::array<bool, kChromaPlaces> is_used_{}, is_near_{};
  std::vector<std::size_t> used_, touched_;
};

}  // namespace touchline::key
