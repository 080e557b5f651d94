// Whose a pixel of true foreground is, and which pixels show forearms and shanks.
#pragma once

#include <cstdint>
#include <vector>

#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "tools/score/truth.h"

namespace touchline::score {

inline constexpr std::uint8_t kNobody = 255;

// The person (index into `people`, at most 254 of them) nearest to each pixel where `matte` is 128
// or more, by the distance in the picture to their bones (to an upright line of 1.8 m where there
// are no joints) over their size there; kNobody beyond 0.45 m (the ball: 0.2 m), and elsewhere. Of
// people who cover each other the nearer bone counts, not the nearer body.
image::Image<std::uint8_t> body_map(const image::Image<std::uint8_t>& matte,
                                    const geometry::CameraEstimate& camera,
                                    const std::vector<TruePerson>& people,
                                    const std::vector<TrueJoint>& joints);

// The person whose capsule of `radius_m` round elbow-wrist or knee-ankle holds the pixel, where
// `matte` is 128 or more: kNobody elsewhere, the later person where several do.
image::Image<std::uint8_t> limb_map(const image::Image<std::uint8_t>& matte,
                                    const geometry::CameraEstimate& camera,
                                    const std::vector<TruePerson>& people,
                                    const std::vector<TrueJoint>& joints, double radius_m = 0.06);

}  // namespace touchline::score
