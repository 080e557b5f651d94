#include "tools/sim/world/boards.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tools/sim/world/letters.h"
#include "tools/sim/world/noise.h"

namespace touchline::sim::world {
namespace {

constexpr int kHeight = 64;  // texels
constexpr int kWidth = 512;
constexpr int kLevels = 7;

constexpr std::array<std::string_view, 12> kWords = {
    "SOLMARK",  "BRIXENVALE", "NINE OAKS", "TARNWAY",  "VELLORIS", "HUNDRIG",
    "OSTRALUX", "KARMINTER",  "ELDERFLOW", "PICCANDO", "MOORGLEN", "DUNAVERT"};

struct Scheme {
  Colour ground, text, mark;
};
const std::array<Scheme, 12>& schemes() {
  static const std::array<Scheme, 12> all = {{
      {{0.80f, 0.12f, 0.02f}, {0.85f, 0.85f, 0.85f}, {0.85f, 0.85f, 0.85f}},
      {{0.02f, 0.06f, 0.35f}, {0.85f, 0.85f, 0.85f}, {0.80f, 0.60f, 0.03f}},
      {{0.82f, 0.82f, 0.80f}, {0.02f, 0.15f, 0.05f}, {0.05f, 0.35f, 0.10f}},
      {{0.60f, 0.02f, 0.03f}, {0.85f, 0.85f, 0.82f}, {0.85f, 0.70f, 0.05f}},
      {{0.02f, 0.02f, 0.02f}, {0.80f, 0.80f, 0.80f}, {0.60f, 0.03f, 0.03f}},
      {{0.85f, 0.60f, 0.02f}, {0.02f, 0.02f, 0.03f}, {0.02f, 0.02f, 0.03f}},
      {{0.03f, 0.30f, 0.10f}, {0.85f, 0.85f, 0.80f}, {0.85f, 0.85f, 0.80f}},
      {{0.85f, 0.85f, 0.85f}, {0.03f, 0.06f, 0.40f}, {0.65f, 0.03f, 0.05f}},
      {{0.03f, 0.30f, 0.55f}, {0.85f, 0.85f, 0.85f}, {0.02f, 0.05f, 0.20f}},
      {{0.25f, 0.02f, 0.25f}, {0.85f, 0.80f, 0.30f}, {0.85f, 0.80f, 0.30f}},
      {{0.80f, 0.80f, 0.82f}, {0.02f, 0.02f, 0.02f}, {0.80f, 0.25f, 0.02f}},
      {{0.02f, 0.20f, 0.22f}, {0.85f, 0.85f, 0.85f}, {0.30f, 0.70f, 0.60f}},
  }};
  return all;
}

float distance_to(const LetterStroke& s, float x, float y) {
  const float dx = s.x1 - s.x0, dy = s.y1 - s.y0;
  const float t = std::clamp(((x - s.x0) * dx + (y - s.y0) * dy) / (dx * dx + dy * dy), 0.0f, 1.0f);
  return std::hypot(x - s.x0 - t * dx, y - s.y0 - t * dy);
}

std::uint8_t stored(float colour) {
  return static_cast<std::uint8_t>(std::lround(255 * std::sqrt(std::clamp(colour, 0.0f, 1.0f))));
}

// A design at full size: ground, a mark at the left, a word beside it.
std::vector<Colour> drawn(std::size_t index) {
  const Scheme& scheme = schemes()[index];
  const std::string_view word = kWords[index];
  const auto strokes = strokes_of(word);
  const float unit_px = kHeight / 10.0f;   // a letter is six tenths of the height
  const float total = width_of(word) + 9;  // with the mark
  const float left = (kWidth / unit_px - total) / 2;
  std::vector<Colour> pixels(static_cast<std::size_t>(kWidth * kHeight));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const float ux = (static_cast<float>(x) + 0.5f) / unit_px - left;
      const float uy = (kHeight - static_cast<float>(y) - 0.5f) / unit_px - 2;
      Colour c = scheme.ground;
      const float mx = ux - 3, my = uy - 3;
      float mark = 0;
      switch (index % 4) {
        case 0:
          mark = 3 - std::hypot(mx, my);
          break;
        case 1:
          mark = 3.4f - std::abs(mx) - std::abs(my);
          break;
        case 2:
          mark = 1.1f - std::abs(std::hypot(mx, my) - 2.1f);
          break;
        default:
          mark = std::min(2.8f - std::max(std::abs(mx), std::abs(my)), std::abs(mx - my) - 0.6f);
          break;
      }
      c += std::clamp(mark * unit_px + 0.5f, 0.0f, 1.0f) * (scheme.mark - c);
      float nearest = 100;
      for (const LetterStroke& s : strokes) nearest = std::min(nearest, distance_to(s, ux - 9, uy));
      c += std::clamp((0.62f - nearest) * unit_px + 0.5f, 0.0f, 1.0f) * (scheme.text - c);
      pixels[static_cast<std::size_t>(y * kWidth + x)] = c;
    }
  return pixels;
}

}  // namespace

BoardPaint::BoardPaint(const BoardsSpec& spec, std::uint64_t seed)
    : spec_(spec), stream_(stream_of(seed, "boards")) {
  for (std::size_t i = 0; i < kWords.size(); ++i) {
    Design design;
    auto pixels = drawn(i);
    for (int level = 0, w = kWidth, h = kHeight; level < kLevels; ++level, w /= 2, h /= 2) {
      design.offset.push_back(static_cast<std::uint32_t>(design.texels.size()));
      for (const Colour& c : pixels)
        for (int k = 0; k < 3; ++k) design.texels.push_back(stored(c[k]));
      std::vector<Colour> half(static_cast<std::size_t>(w / 2 * (h / 2)));
      for (int y = 0; y < h / 2; ++y)
        for (int x = 0; x < w / 2; ++x) {
          const auto at = [&](int a, int b) {
            return pixels[static_cast<std::size_t>((2 * y + b) * w + 2 * x + a)];
          };
          half[static_cast<std::size_t>(y * (w / 2) + x)] =
              0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1));
        }
      pixels = std::move(half);
    }
    designs_.push_back(std::move(design));
  }
}

Colour BoardPaint::design(std::uint32_t index, float along, float up, float size) const {
  const Design& d = designs_[index % designs_.size()];
  const auto high = static_cast<float>(spec_.height_m);
  const float texels = size / high * kHeight;
  const int level =
      std::clamp(static_cast<int>(std::log2(std::max(texels, 1.0f)) + 0.5f), 0, kLevels - 1);
  const int w = kWidth >> level, h = kHeight >> level;
  const float u = along / (high * kAspect) * static_cast<float>(w) - 0.5f;
  const float v = (1 - up / high) * static_cast<float>(h) - 0.5f;
  const float fu = std::floor(u), fv = std::floor(v);
  const int x0 = std::clamp(static_cast<int>(fu), 0, w - 1), x1 = std::min(x0 + 1, w - 1);
  const int y0 = std::clamp(static_cast<int>(fv), 0, h - 1), y1 = std::min(y0 + 1, h - 1);
  const float pu = std::clamp(u - fu, 0.0f, 1.0f), pv = std::clamp(v - fv, 0.0f, 1.0f);
  const std::uint8_t* base = d.texels.data() + d.offset[static_cast<std::size_t>(level)];
  Colour c;
  for (int k = 0; k < 3; ++k) {
    const auto at = [&](int x, int y) {
      const auto s = static_cast<float>(base[3 * (y * w + x) + k]);
      return s * s;
    };
    const float top = at(x0, y0) + pu * (at(x1, y0) - at(x0, y0));
    const float bottom = at(x0, y1) + pu * (at(x1, y1) - at(x0, y1));
    c[k] = (top + pv * (bottom - top)) * (1.0f / (255 * 255));
  }
  return c;
}

BoardLook BoardPaint::at(Boards kind, int side, float along, float up, float size,
                         double time_s) const {
  BoardLook look;
  const float length = static_cast<float>(spec_.height_m) * kAspect;
  const auto lane = static_cast<std::uint32_t>(side);
  if (kind == Boards::kPrinted) {
    const float panel = std::floor(along / length);
    const std::uint32_t index =
        hashed(stream_, lane, static_cast<std::uint32_t>(static_cast<int>(panel)));
    const float within = along - panel * length;
    look.albedo = design(index, within, up, size);
    if (within < 0.03f || within > length - 0.03f) look.albedo *= 0.4f;  // where panels meet
    return look;
  }
  // One design along the whole row; it moves, and gives way to the next from one end to the other.
  const double cycle = time_s / spec_.led_period_s + unit(hashed(stream_, lane, 5));
  const double shown = std::floor(cycle);
  const auto through = static_cast<float>(cycle - shown);
  std::uint32_t show = static_cast<std::uint32_t>(static_cast<std::int64_t>(shown));
  constexpr float kWipe = 0.07f;  // of the period
  if (through < kWipe && along > through / kWipe * 160) --show;
  const std::uint32_t index = hashed(stream_, lane, show, 9);
  const auto moved = static_cast<float>(std::fmod(spec_.led_speed_m_s * time_s, 1000.0 * length));
  const float direction = (index >> 8) & 1 ? 1.0f : -1.0f;
  float place = along + direction * moved;
  place -= std::floor(place / length) * length;
  look.emission = static_cast<float>(spec_.led_brightness) * design(index, place, up, size);
  look.albedo = Colour::Constant(0.02f);
  return look;
}

}  // namespace touchline::sim::world
