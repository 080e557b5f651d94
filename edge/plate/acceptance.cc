#include "edge/plate/acceptance.h"

#include <algorithm>
#include <array>

#include "edge/plate/zones.h"

namespace touchline::plate {
namespace {

constexpr int kWide = image::kPlateTileSize + 2 * kApron;
constexpr std::size_t kRow = kWide;
constexpr int kRejectReach = 3;  // pixels round a person that are not learnt either
constexpr int kDoubtReach = 12;  // pixels round a person where doubtful colours are not learnt

// Ones spread to `reach` rows, or columns, on both sides: windows of twice the length are made of
// two, until one and its shifted copy are as long as is wanted. `at(k)` is line k, all `length`
// long; `spare` likewise.
template <typename Line>
void spread_lines(int lines, std::size_t length, int reach, const Line& at) {
  // Forwards: line k takes in k + 1 .. k + reach.
  const auto take = [&](int to, int from) {
    std::uint8_t* a = at(to);
    const std::uint8_t* b = at(from);
    for (std::size_t x = 0; x < length; ++x) a[x] |= b[x];
  };
  for (int done = 0; done < reach;) {
    const int step = std::min(done + 1, reach - done);
    for (int k = 0; k + step < lines; ++k) take(k, k + step);
    done += step;
  }
  // Backwards: from those.
  for (int done = 0; done < reach;) {
    const int step = std::min(done + 1, reach - done);
    for (int k = lines - 1; k - step >= 0; --k) take(k, k - step);
    done += step;
  }
}

// 1 within `reach` pixels (a square) of a 1; in rows [top, bottom).
void widen(const std::vector<std::uint8_t>& in, int reach, int top, int bottom,
           std::vector<std::uint8_t>& out) {
  out = in;
  std::array<std::uint8_t, kRow> before;
  for (int y = top; y < bottom; ++y) {
    std::uint8_t* row = &out[static_cast<std::size_t>(y) * kRow];
    if (std::find(row, row + kWide, 1) == row + kWide) continue;
    for (const int side : {1, -1})
      for (int done = 0; done < reach;) {
        const int step = std::min(done + 1, reach - done);
        std::copy_n(row, kWide, before.begin());
        if (side > 0)
          for (int x = 0; x + step < kWide; ++x)
            row[x] |= before[static_cast<std::size_t>(x + step)];
        else
          for (int x = step; x < kWide; ++x) row[x] |= before[static_cast<std::size_t>(x - step)];
        done += step;
      }
  }
  spread_lines(bottom - top, kRow, reach,
               [&](int k) { return &out[static_cast<std::size_t>(top + k) * kRow]; });
}

// A row: 1 where learning is allowed, 2 where it is doubtful, and what is none of turf's.
void judge(const std::uint8_t* zones, const std::uint8_t* inside, const std::uint8_t* colours,
           const std::uint16_t* luma, const LocalTurf::Row& local, std::uint8_t* accepted,
           std::uint8_t* foreign) {
  std::array<std::uint8_t, kRow> good;
  std::array<std::uint8_t, kRow> doubtful;
  // Every load is made whatever comes of it, so that the loops vectorise.
  for (std::size_t x = 0; x < kRow; ++x) {
    const std::uint8_t zone = zones[x];
    const std::uint8_t colour = colours[x];
    const std::uint8_t in = inside[x];
    const bool may_be_paint = (zone & (kPaintBand | kPerhapsTurf)) != 0;
    const std::uint8_t wanted = may_be_paint ? TurfColour::kIsPainted : TurfColour::kIsTurf;
    const bool pale = may_be_paint & ((colour & TurfColour::kHasPaintHue) != 0) &
                      (luma[x] >= local.darkest_paint[x]);
    const auto fits = static_cast<std::uint8_t>((colour & wanted) | (pale ? 1 : 0));
    const std::uint8_t lit = luma[x] >= local.darkest_turf[x] ? in : std::uint8_t{0};
    const std::uint8_t shown = fits != 0 ? lit : std::uint8_t{0};
    const auto usual = static_cast<std::uint8_t>(may_be_paint ? 1 : local.usual[x]);
    good[x] = zone == 0 ? in : static_cast<std::uint8_t>(shown & usual);
    const auto doubt =
        static_cast<std::uint8_t>((colour & TurfColour::kIsDoubtful) | (shown & ~usual));
    doubtful[x] = doubt != 0 ? lit : std::uint8_t{0};
  }
  for (std::size_t x = 0; x < kRow; ++x)
    accepted[x] = static_cast<std::uint8_t>(good[x] | ((doubtful[x] & ~good[x]) << 1));
  for (std::size_t x = 0; x < kRow; ++x)
    foreign[x] = static_cast<std::uint8_t>(inside[x] & ~(good[x] | doubtful[x]));
}

}  // namespace

// Single pixels are noise; three in a neighbourhood are a person, whose rim is mixed with turf.
bool Acceptance::find_bodies() {
  body_.assign(foreign_.size(), 0);
  std::uint8_t any = 0;
  std::array<std::uint8_t, kRow> sums{};
  for (std::size_t y = 1; y + 1 < kRow; ++y) {
    const std::uint8_t* a = &foreign_[(y - 1) * kRow];
    const std::uint8_t* b = a + kRow;
    const std::uint8_t* c = b + kRow;
    for (std::size_t x = 0; x < kRow; ++x) sums[x] = static_cast<std::uint8_t>(a[x] + b[x] + c[x]);
    std::uint8_t* to = &body_[y * kRow];
    for (std::size_t x = 1; x + 1 < kRow; ++x) {
      const auto sum = static_cast<std::uint8_t>(sums[x - 1] + sums[x] + sums[x + 1]);
      to[x] = static_cast<std::uint8_t>((sum >= 3 ? 1 : 0) & b[x]);
      any |= to[x];
    }
  }
  return any != 0;
}

const std::vector<std::uint8_t>& Acceptance::classify(const std::vector<std::uint8_t>& zones,
                                                      const TileSamples& samples,
                                                      const TurfColour& turf) {
  const std::size_t area = zones.size();
  accepted_.assign(area, 0);
  foreign_.assign(area, 0);
  colours_.assign(area, 0);
  doubted_.assign(area, 0);
  const auto top = static_cast<std::size_t>(samples.top);
  const auto bottom = static_cast<std::size_t>(std::max(samples.top, samples.bottom));
  for (std::size_t start = top * kRow; start < bottom * kRow; start += kRow) {
    const std::uint8_t* zone = &zones[start];
    std::uint8_t zoned = 0;
    for (std::size_t x = 0; x < kRow; ++x) zoned |= zone[x];
    if (zoned && turf.ready())
      turf.classify(&samples.y[start], &samples.cb[start], &samples.cr[start], kRow,
                    &colours_[start]);
  }
  local_.measure(zones, samples, colours_);
  std::uint8_t anything = 0;
  LocalTurf::Row local;
  for (std::size_t y = top; y < bottom; ++y) {
    const std::size_t start = y * kRow;
    local_.row(static_cast<int>(y), samples, local);
    judge(&zones[start], &samples.inside[start], &colours_[start], &samples.y[start], local,
          &accepted_[start], &foreign_[start]);
    for (std::size_t x = 0; x < kRow; ++x) anything |= foreign_[start + x];
  }
  const std::size_t end = bottom * kRow;
  if (anything && find_bodies()) {
    widen(body_, kRejectReach, samples.top, samples.bottom, near_body_);
    widen(body_, kDoubtReach, samples.top, samples.bottom, around_body_);
    for (std::size_t i = top * kRow; i < end; ++i) {
      // What is doubtful is taken as 1 where nobody is around.
      const int sure = accepted_[i] & 1;
      const int fair = (accepted_[i] >> 1) & ~around_body_[i];
      const int anywhere = zones[i] == 0 ? 1 : 0;
      const int taken = (sure | fair) & (anywhere | ~near_body_[i]) & 1;
      doubted_[i] = static_cast<std::uint8_t>((accepted_[i] >> 1) & ~taken);
      accepted_[i] = static_cast<std::uint8_t>(taken);
    }
  } else {
    for (std::size_t i = top * kRow; i < end; ++i)
      accepted_[i] = static_cast<std::uint8_t>((accepted_[i] | (accepted_[i] >> 1)) & 1);
  }
  return accepted_;
}

}  // namespace touchline::plate
