#include <array>
#include <bit>
#include <cstdint>

#include "tools/sim/world/turf.h"
#include "tools/sim/world/turf_internal.h"

namespace touchline::sim::world {
namespace {

Floats log2_of(Floats x) {
  const Ints bits = _mm256_castps_si256(x);
  const Floats mantissa = _mm256_castsi256_ps(
      _mm256_or_si256(_mm256_and_si256(bits, all_ints(0x7fffff)), all_ints(0x3f800000)));
  const Ints exponent = _mm256_sub_epi32(_mm256_srli_epi32(bits, 23), all_ints(128));
  const Floats value =
      floats(exponent) + (all(-0.344845f) * mantissa + all(2.024658f)) * mantissa - all(0.674878f);
  return both(below(all(1), x), value);
}

Floats stripes(Floats x, float w, Floats soft) {
  const Floats phase = x * all(1 / w);
  const Floats down = floor_of(phase);
  const Floats sign = _mm256_castsi256_ps(_mm256_slli_epi32(whole(down), 31));  // of odd stripes
  const Floats off = (phase - down) * all(w);
  const Floats height = least(all(1), least(off, all(w) - off) / soft);
  return _mm256_xor_ps(height, sign);
}

}  // namespace

Floats Turf::mowing(const TurfLanes& s) const {
  const auto w = static_cast<float>(spec_.stripe_m);
  const Floats soft_x = all(0.15f) + all(0.5f) * (magnitude(s.ax) + magnitude(s.bx));
  const Floats soft_y = all(0.15f) + all(0.5f) * (magnitude(s.ay) + magnitude(s.by));
  switch (spec_.mowing) {
    case Mowing::kNone:
      break;
    case Mowing::kAcross:
      return stripes(s.x, w, soft_x) * s.view_y;
    case Mowing::kAlong:
      return stripes(s.y, w, soft_y) * s.view_x;
    case Mowing::kChequer:
      return all(0.6f) * (stripes(s.x, w, soft_x) * s.view_y + stripes(s.y, w, soft_y) * s.view_x);
    case Mowing::kRings: {
      const Floats r = most(root(s.x * s.x + s.y * s.y), all(0.1f));
      return stripes(r, w, all(0.7f) * (soft_x + soft_y)) * (s.view_y * s.x - s.view_x * s.y) / r;
    }
  }
  return all(0);
}

TurfLaneColours Turf::at(const TurfLanes& s) const {
  TurfLaneColours out;
  const Floats beyond = most(magnitude(s.x) - all(half_x_), magnitude(s.y) - all(half_y_));
  out.elsewhere = bits_of(below(all(spec_.artificial ? 3.2f : 9.5f), beyond));
  const Floats size = root(root((s.ax * s.ax + s.ay * s.ay) * (s.bx * s.bx + s.by * s.by)));
  const Floats u = s.x * all(1 / kFineTexel), v = s.y * all(1 / kFineTexel);
  const Floats level = log2_of(size * all(1 / kFineTexel));
  Floats grain = all(0.55f) * fine_.at(u, v, level);
  grain += all(0.45f) * fine_.at(all(0.137f) * u + all(0.094f) * v + all(91),
                                 all(0.137f) * v - all(0.094f) * u + all(37), level - all(2.6f));
  const Floats close = below(size, all(0.010f));
  if (bits_of(close) != 0) {
    const Floats share = both(close, least(all(1), (all(0.010f) - size) * all(200)));
    grain += all(0.9f) * share *
             blade_.at(s.x * all(1 / kBladeTexel), s.y * all(1 / kBladeTexel),
                       log2_of(size * all(1 / kBladeTexel)));
  }
  // Patches and wear: two neighbours of two channels in four bytes.
  const Floats mu = held((s.x - all(macro_origin_x_)) * all(1 / kMacroCell), 0,
                         static_cast<float>(macro_width_) - 1.01f);
  const Floats mv = held((s.y - all(macro_origin_y_)) * all(1 / kMacroCell), 0,
                         static_cast<float>(macro_height_) - 1.01f);
  const Ints i = whole(mu), j = whole(mv);
  const Floats pu = mu - floats(i), pv = mv - floats(j);
  const Ints place = _mm256_add_epi32(_mm256_mullo_epi32(j, all_ints(macro_width_)), i);
  const auto* bytes = reinterpret_cast<const int*>(macro_.data());
  const auto* next = reinterpret_cast<const int*>(macro_.data() + 2 * macro_width_);
  const Ints top = _mm256_i32gather_epi32(bytes, place, 2);
  const Ints bottom = _mm256_i32gather_epi32(next, place, 2);
  const auto channel = [&](int shift) {
    const Ints mask = all_ints(255);
    const auto value = [&](Ints four, int by) {
      return floats(_mm256_and_si256(_mm256_srli_epi32(four, by), mask));
    };
    const Floats left = value(top, shift), right = value(top, shift + 16);
    const Floats low_left = value(bottom, shift), low_right = value(bottom, shift + 16);
    const Floats a = left + pv * (low_left - left), b = right + pv * (low_right - right);
    return a + pu * (b - a);
  };
  const Floats tone = (channel(0) - all(128)) * all(0.01f);
  const Floats wear = channel(8) * all(1.0f / 255);

  const auto strength = static_cast<float>(spec_.texture);
  Floats brightness = all(1) + all(0.10f * strength) * tone + all(0.105f * strength) * grain;
  brightness *= all(1) + all(static_cast<float>(spec_.stripe_contrast) * 0.5f) * mowing(s);
  brightness *= all(0.93f) + all(0.13f) * (all(1) - s.view_z * s.view_z);
  const Floats hue = all(0.05f * strength) * tone - all(0.03f * strength) * grain;
  const Floats bright = most(brightness, all(0.25f));
  Floats red = all(spec_.albedo.x()) * (all(1) + hue) * bright;
  Floats green = all(spec_.albedo.y()) * bright;
  Floats blue = all(spec_.albedo.z()) * (all(1) - all(0.5f) * hue) * bright;
  const Floats worn = below(all(0.02f), wear);
  if (bits_of(worn) != 0) {
    const Floats w = both(worn, held(wear * (all(1) + all(0.35f) * grain), 0, 1));
    const Floats dry = all(0.6f) * smooth_step(0.05f, 0.45f, w);
    const Floats soil = all(0.85f) * smooth_step(0.4f, 0.95f, w);
    const Floats clod = all(1) + all(0.12f) * grain;
    const auto wither = [&](Floats& c, float straw, float earth) {
      c += dry * (all(straw) * brightness - c);
      c += soil * (all(earth) * clod - c);
    };
    wither(red, kDry.x(), kSoil.x());
    wither(green, kDry.y(), kSoil.y());
    wither(blue, kDry.z(), kSoil.z());
  }
  const Floats extent =
      all(0.5f) * most(magnitude(s.ax) + magnitude(s.bx), magnitude(s.ay) + magnitude(s.by));
  unsigned near = bits_of(below(beyond, all(2)));
  if (near != 0) near &= paint_.near_lines(s.x, s.y, extent);
  if (near != 0) {
    alignas(32) std::array<float, 6 * kLaneCount> in{};
    alignas(32) std::array<float, kLaneCount> lines{}, other{};
    const Floats* const from[] = {&s.x, &s.y, &s.ax, &s.ay, &s.bx, &s.by};
    for (std::size_t k = 0; k < 6; ++k) _mm256_store_ps(&in[k * kLaneCount], *from[k]);
    for (unsigned rest = near; rest != 0; rest &= rest - 1) {
      const auto k = static_cast<std::size_t>(std::countr_zero(rest));
      const LineCover cover =
          paint_.cover(in[k], in[8 + k], {in[16 + k], in[24 + k], in[32 + k], in[40 + k]});
      lines[k] = cover.lines;
      other[k] = cover.other;
      const float sum = cover.lines + cover.other;
      if (sum > 0) out.painted |= 1u << k;
      if (sum > 0 && !(sum == 1)) out.edges |= 1u << k;
      if (cover.detail) out.detail |= 1u << k;
    }
    if (out.painted != 0) {
      const auto uneven = static_cast<float>(lines_.wear);
      const Floats keep =
          held(all(static_cast<float>(lines_.strength)) *
                   (all(1) - all(uneven) * (all(0.25f) + all(0.22f) * grain + all(0.12f) * tone)),
               0, 1);
      const Floats chalk = _mm256_load_ps(lines.data()) * keep;
      const Floats older = all(0.8f) * _mm256_load_ps(other.data());
      const auto cover = [&](Floats& c, float second, float first) {
        c += older * (all(second) - c);
        c += chalk * (all(first) - c);
      };
      cover(red, lines_.other_albedo.x(), lines_.albedo.x());
      cover(green, lines_.other_albedo.y(), lines_.albedo.y());
      cover(blue, lines_.other_albedo.z(), lines_.albedo.z());
    }
  }
  out.red = red;
  out.green = green;
  out.blue = blue;
  return out;
}

}  // namespace touchline::sim::world
