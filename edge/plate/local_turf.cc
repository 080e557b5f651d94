#include "edge/plate/local_turf.h"

#include <algorithm>
#include <cmath>

#include "edge/plate/turf_colour.h"
#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kBlock = 20;  // pixels of a block whose turf is measured
constexpr int kBlocks = LocalTurf::kWide / kBlock;
static_assert(kBlocks * kBlock == LocalTurf::kWide);
constexpr auto kRow = static_cast<std::size_t>(LocalTurf::kWide);
constexpr int kReach = 2;     // blocks round one with the turf that its luma is held against
constexpr int kHueReach = 1;  // and its chroma
constexpr double kDarkestTurf = 0.25;         // of the brightest turf's luma within that reach
constexpr double kDarkestPaint = 1.1;         // of the turf's luma in the block
constexpr std::uint32_t kLeastTurf = kBlock;  // samples of turf that tell a block's luma
constexpr int kBlack = 2 * 64;                // luma times 2
constexpr int kGrey = 512;
constexpr int kUnit = 512;     // of a chroma over luma times 2
constexpr int kHueSlack = 38;  // of them: by which turf's chroma may differ,
constexpr int kHueCodes = 5;   // and code values

struct Sums {
  std::uint32_t count = 0;
  std::int64_t luma = 0, cb = 0, cr = 0;  // over black and grey
  double mean_luma() const {
    return count < kLeastTurf ? 0.0 : std::max(0.0, static_cast<double>(luma) / count);
  }
};

Sums sums_of(const std::vector<std::uint8_t>& zones, const TileSamples& samples,
             const std::vector<std::uint8_t>& colours, int i, int j) {
  Sums out;
  std::uint32_t luma = 0, cb = 0, cr = 0;
  for (int y = j * kBlock; y < (j + 1) * kBlock; y += 2) {
    const std::size_t start =
        static_cast<std::size_t>(y) * kRow + static_cast<std::size_t>(i) * kBlock;
    for (std::size_t x = start; x < start + kBlock; ++x) {
      // Without a branch: the loop runs in lanes.
      const int turf = static_cast<int>(zones[x] == kTurf) &
                       static_cast<int>((colours[x] & TurfColour::kIsTurf) != 0);
      const std::uint32_t one = turf != 0 ? samples.inside[x] : 0U;
      luma += one * samples.y[x];
      cb += one * samples.cb[x];
      cr += one * samples.cr[x];
      out.count += one;
    }
  }
  const std::int64_t n = out.count;
  out.luma = std::int64_t{luma} - n * kBlack;
  out.cb = std::int64_t{cb} - n * kGrey;
  out.cr = std::int64_t{cr} - n * kGrey;
  return out;
}

}  // namespace

void LocalTurf::measure(const std::vector<std::uint8_t>& zones, const TileSamples& samples,
                        const std::vector<std::uint8_t>& colours) {
  std::vector<Sums> sums(static_cast<std::size_t>(kBlocks) * kBlocks);
  const auto at = [](int i, int j) { return static_cast<std::size_t>(j * kBlocks + i); };
  for (int j = 0; j < kBlocks; ++j)
    for (int i = 0; i < kBlocks; ++i) sums[at(i, j)] = sums_of(zones, samples, colours, i, j);
  blocks_.assign(sums.size(), {});
  for (int j = 0; j < kBlocks; ++j)
    for (int i = 0; i < kBlocks; ++i) {
      double brightest = 0;
      Sums near;
      for (int v = std::max(0, j - kReach); v <= std::min(kBlocks - 1, j + kReach); ++v)
        for (int u = std::max(0, i - kReach); u <= std::min(kBlocks - 1, i + kReach); ++u) {
          const Sums& s = sums[at(u, v)];
          brightest = std::max(brightest, s.mean_luma());
          if (std::abs(u - i) > kHueReach || std::abs(v - j) > kHueReach) continue;
          near.count += s.count;
          near.luma += s.luma;
          near.cb += s.cb;
          near.cr += s.cr;
        }
      Block& block = blocks_[at(i, j)];
      block.darkest_turf = static_cast<std::uint16_t>(
          brightest > 0 ? kBlack + static_cast<int>(kDarkestTurf * brightest) : 0);
      const double here = sums[at(i, j)].mean_luma();
      if (here > 0) block.darkest_paint = static_cast<std::uint16_t>(kBlack + kDarkestPaint * here);
      if (near.mean_luma() <= 0) continue;
      const auto share = [&](std::int64_t chroma) {
        const double ratio = static_cast<double>(chroma) / static_cast<double>(near.luma);
        return static_cast<std::int16_t>(std::clamp(kUnit * ratio, -1000.0, 1000.0));
      };
      block.cb = share(near.cb);
      block.cr = share(near.cr);
      block.known = true;
    }
}

void LocalTurf::row(int y, const TileSamples& samples, Row& out) const {
  const std::size_t start = static_cast<std::size_t>(y) * kRow;
  for (int i = 0; i < kBlocks; ++i) {
    const Block& block = blocks_[static_cast<std::size_t>(y / kBlock * kBlocks + i)];
    const auto begin = static_cast<std::size_t>(i) * kBlock;
    std::fill_n(out.darkest_turf.begin() + i * kBlock, kBlock, block.darkest_turf);
    std::fill_n(out.darkest_paint.begin() + i * kBlock, kBlock, block.darkest_paint);
    const std::uint16_t* luma = &samples.y[start + begin];
    const std::uint16_t* cb = &samples.cb[start + begin];
    const std::uint16_t* cr = &samples.cr[start + begin];
    std::uint8_t* usual = &out.usual[begin];
    const auto all = static_cast<std::uint8_t>(block.known ? 0 : 1);
    for (int x = 0; x < kBlock; ++x) {
      const int over = luma[x] - kBlack;
      const int blue = std::abs((cb[x] - kGrey) * kUnit - block.cb * over);
      const int red = std::abs((cr[x] - kGrey) * kUnit - block.cr * over);
      const int most = kHueSlack * over + kHueCodes * kUnit;
      usual[x] = static_cast<std::uint8_t>((std::max(blue, red) <= most ? 1 : 0) | all);
    }
  }
}

}  // namespace touchline::plate
