#include "tools/sim/world/light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::sim::world {
namespace {

constexpr float kSunRadius = 0.0047f;  // radians
constexpr float kCloudTexels = 12;     // of the tile, one size of cloud

float smooth(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

struct Daylight {
  float sun = 1, all = 1;
};

Daylight daylight(const CloudSpec& clouds, double time_s) {
  const auto& keys = clouds.keys;
  const auto as = [](const LightKey& key) {
    return Daylight{static_cast<float>(key.sun), static_cast<float>(key.all)};
  };
  if (keys.empty()) return {};
  if (time_s <= keys.front().time_s) return as(keys.front());
  for (std::size_t i = 1; i < keys.size(); ++i) {
    if (time_s > keys[i].time_s) continue;
    const auto t =
        static_cast<float>((time_s - keys[i - 1].time_s) / (keys[i].time_s - keys[i - 1].time_s));
    const Daylight a = as(keys[i - 1]), b = as(keys[i]);
    return {std::lerp(a.sun, b.sun, t), std::lerp(a.all, b.all, t)};
  }
  return as(keys.back());
}

}  // namespace

Light::Light(const WorldSpec& spec, const Structure& structure, std::uint64_t seed)
    : spec_(spec),
      masts_(structure.masts),
      clouds_(8, 5, 1, 1.0f, stream_of(seed, "clouds")),
      stream_(stream_of(seed, "horizon")) {}

Lighting Light::at(double time_s) const {
  Lighting out;
  const SunSpec& sun = spec_.sun;
  const Colour ground = spec_.turf.albedo * 0.8f;
  if (sun.present) {
    const Daylight day = daylight(spec_.clouds, time_s);
    const auto share = static_cast<float>(sun.share);
    const float elevation = static_cast<float>(sun.elevation_deg * std::numbers::pi / 180);
    const float azimuth = static_cast<float>(sun.azimuth_deg * std::numbers::pi / 180);
    Lamp lamp;
    lamp.sun = true;
    lamp.towards = {std::cos(azimuth) * std::cos(elevation),
                    std::sin(azimuth) * std::cos(elevation), std::sin(elevation)};
    lamp.colour = sun.tint * (share * day.sun * day.all / std::sin(elevation));
    lamp.radius = kSunRadius;
    if (day.sun > 0.001f) out.lamps.push_back(lamp);
    out.overcast = 1 - day.sun;
    // Clouds make the sky grey and a little brighter.
    const Colour tint = sun.sky_tint + out.overcast * (Colour::Ones() - sun.sky_tint);
    out.above = tint * ((1 - share) * day.all * (1 + 0.35f * out.overcast));
    const Colour lit = lamp.colour * lamp.towards.z() + out.above;
    out.below = ground.cwiseProduct(lit);
    out.zenith =
        day.all * (Colour(0.22f, 0.42f, 0.85f) +
                   out.overcast * (Colour(0.75f, 0.78f, 0.82f) - Colour(0.22f, 0.42f, 0.85f)));
    out.horizon =
        day.all * (Colour(0.70f, 0.80f, 0.95f) +
                   out.overcast * (Colour(0.85f, 0.87f, 0.90f) - Colour(0.70f, 0.80f, 0.95f)));
  } else {
    out.zenith = Colour(0.004f, 0.005f, 0.009f);
    out.horizon = Colour(0.012f, 0.012f, 0.016f);
    out.above = Colour(0.006f, 0.007f, 0.01f);
  }
  const auto level = static_cast<float>(spec_.floodlights.level);
  if (!masts_.empty() && level > 0) {
    const float each = level * 0.9f / static_cast<float>(masts_.size());
    for (const Eigen::Vector3f& mast : masts_) {
      Lamp lamp;
      lamp.distant = false;
      lamp.position = mast;
      // Lamps are aimed so that the ground is lit evenly: level at the centre spot, little
      // fall-off.
      const float sine = mast.z() / mast.norm();
      lamp.colour = spec_.floodlights.tint * (each / sine);
      lamp.radius = 0.5f * static_cast<float>(spec_.floodlights.lamp_m);
      out.lamps.push_back(lamp);
    }
    // Light that the stands and the air send back.
    out.above += spec_.floodlights.tint * (0.10f * level);
    out.below += ground * level;
  }
  const auto visibility = static_cast<float>(spec_.weather.visibility_m);
  out.extinction = 3.912f / visibility;
  out.fog = (out.above + 0.35f * out.horizon) * 0.55f;
  if (!masts_.empty()) out.fog += Colour::Constant(0.10f * level);
  return out;
}

float Light::cloud_shade(float x, float y, double time_s) const {
  const CloudSpec& c = spec_.clouds;
  const auto scale = static_cast<float>(kCloudTexels / c.drift_scale_m);
  const auto mx = static_cast<float>(c.drift_x_m_s * time_s),
             my = static_cast<float>(c.drift_y_m_s * time_s);
  const float n = clouds_.bilinear((x - mx) * scale, (y - my) * scale, 0);
  return 1 - static_cast<float>(c.drift) * smooth(-0.35f, 0.55f, n);
}

Floats Light::cloud_shade(Floats x, Floats y, double time_s) const {
  const CloudSpec& c = spec_.clouds;
  const Floats scale = all(static_cast<float>(kCloudTexels / c.drift_scale_m));
  const Floats mx = all(static_cast<float>(c.drift_x_m_s * time_s)),
               my = all(static_cast<float>(c.drift_y_m_s * time_s));
  const Floats n = clouds_.bilinear((x - mx) * scale, (y - my) * scale, all_ints(0));
  return all(1) - all(static_cast<float>(c.drift)) * smooth_step(-0.35f, 0.55f, n);
}

Colour Light::sky(const Lighting& lighting, const Eigen::Vector3f& d, double time_s) const {
  const float up = d.z();
  if (up < 0.045f) {
    // Trees and houses beyond the ground.
    const float bearing = std::atan2(d.y(), d.x()) * 40;
    const float cell = std::floor(bearing);
    const auto i = static_cast<std::uint32_t>(static_cast<int>(cell));
    const float a = unit(hashed(stream_, i)), b = unit(hashed(stream_, i + 1));
    const float p = bearing - cell;
    const float skyline = 0.012f + 0.03f * std::lerp(a, b, p * p * (3 - 2 * p));
    if (up < skyline) {
      const Colour trees = Colour(0.05f, 0.075f, 0.04f) * (0.7f + 0.6f * a);
      const Colour lit = trees.cwiseProduct(lighting.above * 2 + Colour::Constant(0.004f));
      return lit + 0.25f * (lighting.horizon - lit);
    }
  }
  const float h = std::clamp(up, 0.0f, 1.0f);
  Colour c = lighting.horizon + std::sqrt(h) * (lighting.zenith - lighting.horizon);
  if (spec_.sun.present && h > 0.01f) {
    const auto drift = static_cast<float>(0.8 * time_s);
    const float u = d.x() / (h + 0.15f) * 22 + drift, v = d.y() / (h + 0.15f) * 22;
    const float n = clouds_.at(u, v, 1.0f) + 0.5f * clouds_.at(3.1f * u, 3.1f * v, 0.5f);
    const float cover = smooth(0.9f - 1.6f * lighting.overcast, 2.2f - 1.2f * lighting.overcast, n);
    const Colour cloud = lighting.horizon * (1.05f - 0.12f * n);
    c += cover * std::min(1.0f, h * 8) * (cloud - c);
  }
  return c.cwiseMax(0.0f);
}

}  // namespace touchline::sim::world
