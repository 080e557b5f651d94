// Blind estimate of a camera's detail (aperture) setting from the response at straight edges and
// lines (chapter 4.3.1).
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "edge/state/detail_model.h"
#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::compensate {

struct DetailOptions {
  int edges_per_frame = 4000;  // edge points taken from one frame at most; 16..100000
  double step_codes = 60;      // least height of a step or line, 10-bit code values; 10..500
  int edges_needed = 300;      // with fewer edges nothing is estimated; 10..1000000
  double least_boost = 0.04;   // an axis with less in sum is reported as without detail; 0..0.2

  base::Status validate() const;
};

// Collects profiles over frames: steps with flat sides and lines with flat ground on both sides,
// at any angle. Profiles are placed below a pixel across the edge, grouped by angle, sharpness and
// line width, scaled and averaged. Whatever lens, pixels and transfer curve do to an edge, its
// response never dips under the dark side's level; the boost does that. So the least boost is
// sought whose undoing leaves no dip on the dark sides, over all angles at once. Bright sides may
// be clipped and are not used. One frame costs tens of milliseconds: a background job.
class DetailEstimator {
 public:
  // Options out of their bounds are replaced by the nearest bound.
  explicit DetailEstimator(const DetailOptions& options = {});

  // Luma of a frame, 10-bit code values; at least 64 by 64, else ignored.
  void add(image::ImageView<const std::uint16_t> luma);

  // From all frames added; all zero where there were too few edges, or too few towards an axis.
  state::DetailModel estimate() const;

  // Averaged response of edges of about the same angle and width. Bins of a quarter pixel across
  // the edge, from -kReach to kReach.
  struct Profile {
    std::vector<double> sum, count;
    double cosine = 0;  // sums over edges of |normal.x|, |normal.y| and the line's width in pixels
    double sine = 0;
    double width = 0;
    int edges = 0;
  };
  // Angle of the normal (0 = across a vertical edge), how fast luma rises, width (0 = a step).
  struct Class {
    int angle = 0;
    int rise = 0;
    int width = 0;
    auto operator<=>(const Class&) const = default;
  };
  static constexpr int kReach = 8;
  static constexpr int kBinsPerPixel = 4;
  static constexpr int kBins = 2 * kReach * kBinsPerPixel + 1;

 private:
  DetailOptions options_;
  std::map<Class, Profile> profiles_;
};

}  // namespace touchline::compensate
