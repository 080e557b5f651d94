#include "tools/sim/world/turf.h"

#include <immintrin.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "tools/sim/world/turf_internal.h"

namespace touchline::sim::world {
namespace {

float smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

// Value noise of unit amplitude with cells of one metre.
float value_noise(std::uint32_t stream, float x, float y) {
  const float fx = std::floor(x), fy = std::floor(y);
  const auto i = static_cast<std::uint32_t>(static_cast<int>(fx));
  const auto j = static_cast<std::uint32_t>(static_cast<int>(fy));
  const float px = x - fx, py = y - fy;
  const float sx = px * px * (3 - 2 * px), sy = py * py * (3 - 2 * py);
  const auto lattice = [&](std::uint32_t a, std::uint32_t b) {
    return 2 * unit(hashed(stream, a, b)) - 1;
  };
  return std::lerp(std::lerp(lattice(i, j), lattice(i + 1, j), sx),
                   std::lerp(lattice(i, j + 1), lattice(i + 1, j + 1), sx), sy);
}

// Base-two logarithm to 0.01, 0 below one.
float log2_of(float x) {
  if (!(x > 1)) return 0;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  const float mantissa = std::bit_cast<float>((bits & 0x7fffffu) | 0x3f800000u);
  return static_cast<float>(static_cast<int>(bits >> 23) - 128) +
         (-0.344845f * mantissa + 2.024658f) * mantissa - 0.674878f;
}

// A wave of stripes of width `w`: -1 and 1 with edges of `soft` metres.
float stripes(float x, float w, float soft) {
  const float phase = x / w;
  const float whole = std::floor(phase);
  const float sign = (static_cast<int>(whole) & 1) ? -1.0f : 1.0f;
  const float off = (phase - whole) * w;
  const float near_edge = std::min(off, w - off);
  return sign * std::min(1.0f, near_edge / soft);
}

}  // namespace

Turf::Turf(const WorldSpec& spec, const pitch::PitchModel& pitch, std::uint64_t seed)
    : spec_(spec.turf),
      lines_(spec.lines),
      wet_(static_cast<float>(spec.weather.wetness)),
      half_x_(static_cast<float>(pitch.length_m / 2 + pitch.in_goal_m)),
      half_y_(static_cast<float>(pitch.width_m / 2)),
      paint_(pitch, spec.lines),
      fine_(9, 7, 0, 1.0f, stream_of(seed, "turf.fine")),
      blade_(9, 4, 1, 3.0f, stream_of(seed, "turf.blade")) {
  macro_origin_x_ = -half_x_ - kTurfMargin;
  macro_origin_y_ = -half_y_ - kTurfMargin;
  macro_width_ = static_cast<int>(-2 * macro_origin_x_ / kMacroCell) + 2;
  macro_height_ = static_cast<int>(-2 * macro_origin_y_ / kMacroCell) + 2;
  macro_.resize(2 * static_cast<std::size_t>(macro_width_) *
                static_cast<std::size_t>(macro_height_));
  const std::uint32_t tone = stream_of(seed, "turf.tone"), bare = stream_of(seed, "turf.wear");
  const auto hl = static_cast<float>(pitch.length_m / 2);
  const bool soccer = pitch.sport == pitch::Sport::kSoccer;
  const auto worn = static_cast<float>(spec_.wear);
  for (int j = 0; j < macro_height_; ++j)
    for (int i = 0; i < macro_width_; ++i) {
      const float x = macro_origin_x_ + static_cast<float>(i) * kMacroCell;
      const float y = macro_origin_y_ + static_cast<float>(j) * kMacroCell;
      // Patches of 20, 6, 2 and 0.6 m; slightly longer along the pitch, as the mower goes.
      const float n = 0.45f * value_noise(tone, x / 20, y / 14) +
                      0.35f * value_noise(tone + 1, x / 6.1f, y / 5) +
                      0.30f * value_noise(tone + 2, x / 2.1f, y / 1.7f) +
                      0.25f * value_noise(tone + 3, x / 0.6f, y / 0.55f);
      float strain = 0;
      if (soccer) {
        const float gx = (std::abs(x) - (hl - 1.2f)) / 2.6f, gy = y / 3.6f;
        strain += 1.25f * std::exp(-gx * gx - gy * gy);
        const float px = (std::abs(x) - (hl - 11)) / 1.2f, py = y / 1.2f;
        strain += 0.7f * std::exp(-px * px - py * py);
        const float bx = (std::abs(x) - (hl - 7)) / 8, by = y / 9;
        strain += 0.35f * std::exp(-bx * bx - by * by);
      } else {
        const float gx = (std::abs(x) - hl) / 4, gy = y / 14;
        strain += 0.45f * std::exp(-gx * gx - gy * gy);
        const float mx = x / 14, my = y / 18;
        strain += 0.35f * std::exp(-mx * mx - my * my);
      }
      const float cx = x / 2.0f, cy = y / 2.0f;
      strain += 0.5f * std::exp(-cx * cx - cy * cy);
      const float lx = (std::abs(y) - (half_y_ + 0.8f)) / 0.5f;
      if (std::abs(x) < hl) strain += 0.35f * std::exp(-lx * lx);
      const float ragged = value_noise(bare, x / 0.8f, y / 0.8f) +
                           0.8f * value_noise(bare + 1, x / 0.27f, y / 0.27f) +
                           0.6f * value_noise(bare + 2, x / 2.5f, y / 2.5f);
      const float w =
          worn * strain * (1.0f + 0.55f * ragged) + 0.06f * worn * std::max(0.0f, ragged - 0.6f);
      const std::size_t at =
          2 * (static_cast<std::size_t>(j) * static_cast<std::size_t>(macro_width_) +
               static_cast<std::size_t>(i));
      macro_[at] = static_cast<std::uint8_t>(std::clamp(128 + 100 * n, 0.0f, 255.0f));
      macro_[at + 1] = static_cast<std::uint8_t>(std::clamp(255 * w, 0.0f, 255.0f));
    }
}

Turf::Macro Turf::macro_at(float x, float y) const {
  const float u = std::clamp((x - macro_origin_x_) * (1 / kMacroCell), 0.0f,
                             static_cast<float>(macro_width_) - 1.01f);
  const float v = std::clamp((y - macro_origin_y_) * (1 / kMacroCell), 0.0f,
                             static_cast<float>(macro_height_) - 1.01f);
  const int i = static_cast<int>(u), j = static_cast<int>(v);
  const float pu = u - static_cast<float>(i), pv = v - static_cast<float>(j);
  // Two neighbours of two channels in four bytes.
  const auto row = [&](int k) {
    std::int32_t bytes;
    std::memcpy(&bytes, macro_.data() + 2 * (static_cast<std::ptrdiff_t>(k) * macro_width_ + i), 4);
    return _mm_cvtepi32_ps(_mm_cvtepu8_epi32(_mm_cvtsi32_si128(bytes)));
  };
  const __m128 top = row(j), bottom = row(j + 1);
  const __m128 both = _mm_add_ps(top, _mm_mul_ps(_mm_set1_ps(pv), _mm_sub_ps(bottom, top)));
  const __m128 right = _mm_movehl_ps(both, both);
  const __m128 mixed = _mm_add_ps(both, _mm_mul_ps(_mm_set1_ps(pu), _mm_sub_ps(right, both)));
  return {(_mm_cvtss_f32(mixed) - 128) * 0.01f,
          _mm_cvtss_f32(_mm_shuffle_ps(mixed, mixed, 1)) * (1.0f / 255)};
}

// Grass bent away from the eye looks brighter than grass bent towards it.
float Turf::mowing(float x, float y, const TurfSample& sample) const {
  const auto w = static_cast<float>(spec_.stripe_m);
  const Footprint& f = sample.footprint;
  const float soft_x = 0.15f + 0.5f * (std::abs(f.ax) + std::abs(f.bx));
  const float soft_y = 0.15f + 0.5f * (std::abs(f.ay) + std::abs(f.by));
  switch (spec_.mowing) {
    case Mowing::kNone:
      return 0;
    case Mowing::kAcross:
      return stripes(x, w, soft_x) * sample.view_y;
    case Mowing::kAlong:
      return stripes(y, w, soft_y) * sample.view_x;
    case Mowing::kChequer:
      return 0.6f * (stripes(x, w, soft_x) * sample.view_y + stripes(y, w, soft_y) * sample.view_x);
    case Mowing::kRings: {
      const float r = std::max(std::hypot(x, y), 0.1f);
      return stripes(r, w, 0.7f * (soft_x + soft_y)) * (sample.view_y * x - sample.view_x * y) / r;
    }
  }
  return 0;
}

TurfColour Turf::at(const TurfSample& sample) const {
  const float x = sample.x, y = sample.y;
  const Footprint& f = sample.footprint;
  TurfColour out;
  const float beyond = std::max(std::abs(x) - half_x_, std::abs(y) - half_y_);
  const float size =
      std::sqrt(std::sqrt((f.ax * f.ax + f.ay * f.ay) * (f.bx * f.bx + f.by * f.by)));
  // Grain: the same tile at three sizes, turned so that its repetition does not show.
  const float u = x * (1 / kFineTexel), v = y * (1 / kFineTexel);
  const float level = log2_of(size * (1 / kFineTexel));
  float grain = 0.55f * fine_.at(u, v, level);
  grain += 0.45f * fine_.at(0.137f * u + 0.094f * v + 91, 0.137f * v - 0.094f * u + 37,
                            std::max(0.0f, level - 2.6f));
  if (size < 0.010f) {
    const float near_share = std::min(1.0f, (0.010f - size) * 200);
    grain +=
        0.9f * near_share *
        blade_.at(x * (1 / kBladeTexel), y * (1 / kBladeTexel), log2_of(size * (1 / kBladeTexel)));
  }
  const auto strength = static_cast<float>(spec_.texture);
  const auto [tone, wear] = macro_at(x, y);
  if (beyond > 9.5f) {
    const float t = 1 + 0.05f * grain;
    out.albedo = (spec_.artificial ? kCarpet : kTrack) * t;
    out.gloss = 0.5f * wet_;
    return out;
  }
  const float edge_share = beyond > 3.2f && spec_.artificial ? 1.0f : 0.0f;
  const float horizontal = 1 - sample.view_z * sample.view_z;
  float brightness = 1 + strength * (0.10f * tone + 0.105f * grain);
  brightness *= 1 + static_cast<float>(spec_.stripe_contrast) * 0.5f * mowing(x, y, sample);
  brightness *= 0.93f + 0.13f * horizontal;  // tips rather than the ground between the blades
  const float hue = strength * (0.05f * tone - 0.03f * grain);
  Colour grass = spec_.albedo;
  grass.x() *= 1 + hue;
  grass.z() *= 1 - 0.5f * hue;
  grass *= std::max(brightness, 0.25f);
  if (wear > 0.02f) {
    const float w = std::clamp(wear * (1 + 0.35f * grain), 0.0f, 1.0f);
    const float dry = smooth(0.05f, 0.45f, w), soil = 0.85f * smooth(0.4f, 0.95f, w);
    grass += 0.6f * dry * (kDry * brightness - grass);
    grass += soil * (kSoil * (1 + 0.12f * grain) - grass);
  }
  if (edge_share > 0) grass = kCarpet * (1 + 0.06f * grain);
  const LineCover cover = beyond < 2 ? paint_.cover(x, y, f) : LineCover{};
  out.detail = cover.detail;
  if (cover.lines > 0 || cover.other > 0) {
    const auto uneven = static_cast<float>(lines_.wear);
    const float keep = std::clamp(
        static_cast<float>(lines_.strength) * (1 - uneven * (0.25f + 0.22f * grain + 0.12f * tone)),
        0.0f, 1.0f);
    const float chalk = cover.lines * keep;
    if (cover.other > 0) grass += 0.8f * cover.other * (lines_.other_albedo - grass);
    grass += chalk * (lines_.albedo - grass);
  }
  out.albedo = grass * (1 - 0.28f * wet_);
  out.gloss = wet_ * (0.75f + 0.25f * tone + 0.2f * grain);
  return out;
}

}  // namespace touchline::sim::world
