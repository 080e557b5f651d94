// Which rule holds for a pixel of the plate: turf, beside a painted line, or neither.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::plate {

inline constexpr std::uint8_t kTurf = 1;       // a ray to turf, nothing fixed in front of it
inline constexpr std::uint8_t kPaintBand = 2;  // close to a marking
inline constexpr std::uint8_t kPaintCore = 4;  // on a marking, by the model
// The ray ends on the turf's plane, but something fixed may stand in front of it: a net or a post,
// or hoardings beyond the margin. Turf and paint are preferred where they are seen often.
inline constexpr std::uint8_t kPerhapsTurf = 8;
inline constexpr std::uint8_t kOccluder = 16;    // with it: a goal frame, a net or a flag pole
inline constexpr std::uint8_t kTurfBehind = 32;  // likewise: a net before what would be kTurf

struct ZoneOptions {
  double turf_margin_m = 1;
  double verge_m = 6;  // beyond the margin: perhaps turf
  double line_tolerance_m = 0.08;
  double line_tolerance_px = 2;
  double occluder_margin_px = 3;
};

// Zones of the tile, `apron` pixels round it included: (256 + 2 apron)^2 bytes, row by row.
std::vector<std::uint8_t> tile_zones(const image::PlateSnapshot& sphere,
                                     const image::PlateTileKey& key, int apron,
                                     const pitch::PitchModel& pitch, const ZoneOptions& options);

}  // namespace touchline::plate
