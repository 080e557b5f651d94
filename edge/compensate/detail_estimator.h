// Blind estimate of a camera's detail (aperture) setting from the response at straight edges and
// lines (chapter 4.3.1).
#pragma once

#include <cstdint>
#include <vector>

#include "edge/compensate/edge_profile.h"
#include "edge/state/detail_model.h"
#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::compensate {

struct DetailOptions {
  int edges_per_frame = 40;   // edges taken from one frame at most, the clearest; 8..10000
  double step_codes = 60;     // least height of a step or line, 10-bit code values; 10..500
  int edges_needed = 12;      // with fewer edges nothing is estimated; 4..100000
  double least_boost = 0.04;  // an axis with less in sum is reported as without detail; 0..0.2

  base::Status validate() const;
};

// Collects isolated straight edges and bars over frames, at any angle: painted lines, boards. All
// are fitted together: each has its own place, width, levels, blur and overexposure, all share the
// boost. Nothing but the boost undershoots beside an edge, and a blur alone explains a slow rise,
// so the two are told apart where edges are sharper than about 1.5 pixels. What the edges leave
// open is decided for less boost. One frame costs tens of milliseconds: a background job.
class DetailEstimator {
 public:
  // Options out of their bounds are replaced by the nearest bound.
  explicit DetailEstimator(const DetailOptions& options = {});

  // Luma of a frame, 10-bit code values; at least 64 by 64, else ignored.
  void add(image::ImageView<const std::uint16_t> luma);

  // From all frames added; all zero where there were too few edges, or too few towards an axis.
  state::DetailModel estimate() const;

 private:
  DetailOptions options_;
  std::vector<EdgeProfile> edges_;
};

}  // namespace touchline::compensate
