// Goals of a virtual view. In a plate a goal lies painted on what is behind it: cameras that look
// through a net are avoided for the ground behind, and the frames are drawn as what they are.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "hub/render/plate_texture_internal.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

struct PlateCamera;

class GoalFrames {
 public:
  explicit GoalFrames(const pitch::PitchModel& pitch) : bars_(pitch.bars), nets_(pitch.nets) {}

  // A net hangs between a camera and a point.
  bool hides(const Eigen::Vector3d& camera, const Eigen::Vector3d& point) const;

  // Nets as an even veil, bars in the colour that the plates show on them, white where none does.
  // `distance` is that of what the picture shows already, metres; farther bars stay behind it.
  void paint(const geometry::CameraEstimate& virtual_camera,
             const std::vector<PlateCamera>& cameras, const image::Image<float>& distance,
             image::Image<Eigen::Vector3f>& colour) const;

 private:
  std::vector<pitch::Bar> bars_;
  std::vector<pitch::NetPanel> nets_;
};

}  // namespace touchline::render
