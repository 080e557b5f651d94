// Who stands where, by one camera's matte alone.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

// Someone whose feet a camera sees.
struct Standing {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();  // pitch frame, metres, on the turf
  double sd_m = 0;  // along the sight, by two pixels of the foot; across it is known better
};

// Turf points under silhouettes that stand on the turf, of plausible height, in scan order. Only
// those within 3 m of the pitch. None of a lost camera or a view without a matte.
std::vector<Standing> standing(const codec::CameraView& view, const pitch::PitchModel& pitch);

}  // namespace touchline::track
