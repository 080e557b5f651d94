// Views as our renderer draws them from true cameras and true mattes: what a perfect edge would
// allow.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "tools/score/truth.h"
#include "tools/score/view_score.h"

namespace touchline::score {

struct RenderedView {
  Picture picture;
  Mask foreground;  // coverage of people and ball alone
};

// Videos are compensated as an edge does; plates are learnt from them (the first 100 frames) with
// the true cameras, so they are those of a perfect calibration. The renderer's hull mode.
class ViewOracle {
 public:
  static base::Result<ViewOracle> open(const recording::Recording& recording, const Truth& truth,
                                       double voxel_m);
  ViewOracle(ViewOracle&&) noexcept;
  ViewOracle& operator=(ViewOracle&&) noexcept;
  ~ViewOracle();

  // The pictures of virtual cameras at an instant, in their order; instants must rise.
  base::Result<std::vector<RenderedView>> render(
      std::int64_t instant, const std::vector<geometry::CameraEstimate>& cameras);

 private:
  struct Impl;
  explicit ViewOracle(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::score
