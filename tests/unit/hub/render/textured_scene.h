// A small world that can be drawn exactly: spheres with a pattern over turf with a pattern, and the
// views and plates that cameras have of it.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "hub/scene/hull.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

struct Ball {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius = 0.5;
  Eigen::Vector3d colour = {200, 40, 40};  // 0..255, before the pattern
};

// A cheap pitch without crown.
pitch::PitchModel flat_pitch();

// Colours 0..255 of a point of a ball's surface, and of the turf.
Eigen::Vector3d ball_colour(const Ball& ball, const Eigen::Vector3d& point);
Eigen::Vector3d turf_colour(double x, double y);

// Colour and coverage by balls of a pixel, averaged over 4 x 4 rays.
struct Drawn {
  Eigen::Vector3d colour = Eigen::Vector3d::Zero();  // of balls over turf
  double coverage = 0;
};
Drawn draw(std::span<const Ball> balls, const geometry::CameraEstimate& camera, int x, int y);

// A whole view: exact matte, and one tile over everything that holds foreground.
codec::CameraView draw_view(const std::string& name, const geometry::CameraEstimate& camera,
                            std::span<const Ball> balls);

// A closed mesh round each ball, `fat` metres larger.
scene::Hull hull_of(std::span<const Ball> balls, double fat,
                    std::span<const codec::CameraView> views);

// What a camera at `centre` would learn of the empty turf: tiles over the part of the sphere that
// looks at x, y within `reach` of the pitch's centre. Colours are multiplied by `gain`.
image::PlateSnapshot draw_plate(const Eigen::Vector3d& centre, double radians_per_px, double reach,
                                const Eigen::Vector3d& gain = Eigen::Vector3d::Ones());

// A plate of any world, over the tiles given: `colour` gives that of a direction, false where there
// is none.
using ColourOfDirection =
    std::function<bool(const Eigen::Vector3d& direction, Eigen::Vector3d& rgb)>;
image::PlateSnapshot fill_plate(const Eigen::Vector3d& centre, double radians_per_px,
                                std::span<const image::PlateTileKey> keys,
                                const ColourOfDirection& colour);

}  // namespace touchline::render
