// Eight places of turf at once, held against one at a time.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tools/sim/world/world.h"
#include "tools/sim/world/world_data.h"

namespace touchline::sim::world {
namespace {

using Eight = std::array<float, kLaneCount>;

Floats loaded(const Eight& values) { return _mm256_loadu_ps(values.data()); }
Eight stored(Floats values) {
  Eight out;
  _mm256_storeu_ps(out.data(), values);
  return out;
}

TEST(TurfLanes, AreAsOneAtATime) {
  for (const Mowing mowing :
       {Mowing::kNone, Mowing::kAcross, Mowing::kAlong, Mowing::kChequer, Mowing::kRings}) {
    WorldSpec spec;
    spec.turf.mowing = mowing;
    spec.lines.other_sport = true;
    const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {}).value();
    const auto world = World::create(spec, pitch, 5).value();
    const Turf& turf = world.data().turf;
    int painted = 0;
    for (std::uint32_t n = 0; n < 4000; ++n) {
      TurfLanes lanes{};
      std::array<Eight, 9> in;
      std::array<TurfSample, kLaneCount> samples;
      // Footprints from a few millimetres to some decimetres.
      const float size = 0.003f * std::exp2(6 * unit(hashed(1, n)));
      const float x0 = 124 * (unit(hashed(2, n)) - 0.5f), y0 = 86 * (unit(hashed(3, n)) - 0.5f);
      for (std::size_t i = 0; i < kLaneCount; ++i) {
        TurfSample& s = samples[i];
        s.x = x0 + size * static_cast<float>(i);
        s.y = y0 + 0.3f * size * static_cast<float>(i);
        s.footprint = {size, 0.3f * size, -0.4f * size, 1.7f * size};
        s.view_x = 0.6f;
        s.view_y = 0.7f;
        s.view_z = -std::sqrt(1 - 0.36f - 0.49f);
        const std::array<float, 9> values{
            s.x,      s.y,      s.footprint.ax, s.footprint.ay, s.footprint.bx, s.footprint.by,
            s.view_x, s.view_y, s.view_z};
        for (std::size_t k = 0; k < values.size(); ++k) in[k][i] = values[k];
      }
      Floats* const to[] = {&lanes.x,  &lanes.y,      &lanes.ax,     &lanes.ay,    &lanes.bx,
                            &lanes.by, &lanes.view_x, &lanes.view_y, &lanes.view_z};
      for (std::size_t k = 0; k < in.size(); ++k) *to[k] = loaded(in[k]);
      const TurfLaneColours all_lanes = turf.at(lanes);
      const std::array<Eight, 3> colours{stored(all_lanes.red), stored(all_lanes.green),
                                         stored(all_lanes.blue)};
      for (std::size_t i = 0; i < kLaneCount; ++i) {
        if (all_lanes.elsewhere >> i & 1u) continue;
        const TurfColour one = turf.at(samples[i]);
        for (std::size_t k = 0; k < 3; ++k)
          ASSERT_NEAR(colours[k][i], one.albedo[static_cast<Eigen::Index>(k)],
                      2e-3)  // a level more or less of its texture
              << samples[i].x << ' ' << samples[i].y << " size " << size;
        ASSERT_EQ((all_lanes.detail >> i & 1u) != 0, one.detail);
        painted += (all_lanes.painted >> i & 1u) != 0 ? 1 : 0;
      }
    }
    EXPECT_GT(painted, 100);
  }
}

}  // namespace
}  // namespace touchline::sim::world
