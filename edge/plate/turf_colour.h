// What turf looks like in one camera: chroma over luma, which shading leaves alone, learnt from the
// pixels that see turf.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace touchline::plate {

class TurfColour {
 public:
  // A pixel that sees the turf region (people included: they are few). 10-bit code values.
  void observe(float y, float cb, float cr);
  // Takes the observations so far into the classifier; false while there are too few.
  bool update();
  bool ready() const { return ready_; }

  // Turf, lit or in shadow.
  bool is_turf(float y, float cb, float cr) const {
    const float luma = y - 64.f;
    if (luma < least_luma_ || luma > most_luma_) return false;
    const int i = bin((cb - 512.f) / luma);
    const int j = bin((cr - 512.f) / luma);
    return table_[static_cast<std::size_t>(j * kBins + i)] & 1;
  }
  // Turf, white paint, or a mix of both.
  bool is_painted(float y, float cb, float cr) const {
    const float luma = y - 64.f;
    if (luma < least_luma_) return false;
    const int i = bin((cb - 512.f) / luma);
    const int j = bin((cr - 512.f) / luma);
    return table_[static_cast<std::size_t>(j * kBins + i)] & (luma > paint_luma_ ? 3 : 1);
  }

  // The same for many pixels at once; kIsDoubtful: not turf, yet close enough in hue to be worn or
  // bare ground; kHasPaintHue: painted, if it is brighter than the turf round it. Luma is given
  // times 2; one of the sets of bits below for each.
  static constexpr std::uint8_t kIsTurf = 1;
  static constexpr std::uint8_t kIsPainted = 2;
  static constexpr std::uint8_t kIsDoubtful = 4;
  static constexpr std::uint8_t kHasPaintHue = 8;
  void classify(const std::uint16_t* y2, const std::uint16_t* cb, const std::uint16_t* cr,
                std::size_t count, std::uint8_t* out) const;

  static constexpr int kBins = 128;      // an axis, over -0.8..0.8
  static constexpr float kReach = 0.8f;  // of chroma over luma

 private:
  static constexpr std::uint8_t kBrightPaint = 16;  // painted if bright enough

  void classify8(const std::uint16_t* y2, const std::uint16_t* cb, const std::uint16_t* cr,
                 std::uint8_t* out) const;
  static int bin(float ratio) {
    const float b = (ratio + kReach) * (kBins / (2 * kReach));
    return b <= 0 ? 0 : b >= kBins - 1 ? kBins - 1 : static_cast<int>(b);
  }

  std::vector<std::uint32_t> histogram_ = std::vector<std::uint32_t>(kBins * kBins, 0);
  std::array<std::uint32_t, 256> luma_{};  // 4 code values a bin
  std::uint64_t observed_ = 0;
  std::vector<std::uint8_t> table_ = std::vector<std::uint8_t>(kBins * kBins, 0);
  // As classify() says it, before luma is looked at; 32 bits can be read at each place.
  std::vector<std::uint8_t> allowed_ = std::vector<std::uint8_t>(kBins * kBins + 3, 0);
  float least_luma_ = 0;
  float most_luma_ = 0;
  float paint_luma_ = 0;
  bool ready_ = false;
};

}  // namespace touchline::plate
