// Pitch and stadium of a virtual view, from the plates.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "hub/render/goal_frames_internal.h"
#include "hub/render/plate_texture_internal.h"
#include "hub/render/render_options.h"
#include "hub/render/stadium.h"
#include "shared/base/ids.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

struct PlateCamera {
  base::CameraId id;
  PlateTexture texture;
};

// What lies behind a pixel.
inline constexpr int kTurfSurface = -1;
inline constexpr int kSkySurface = -2;

struct GroundPoint {
  int surface = kSkySurface;                        // turf, sky, or a PitchSide as number
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // world
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double distance = 0;  // along the ray, metres; infinite for the sky
};

struct Background {
  image::Image<Eigen::Vector3f> colour;  // 0..255
  image::Image<float> seen;              // 0..1: how far a plate shows it
  image::Image<std::int8_t> surface;     // as in GroundPoint
  image::Image<float> distance;          // from the virtual camera, metres
  std::vector<double> share;             // of the picture by camera, in the order of the cameras
};

class BackgroundRenderer {
 public:
  BackgroundRenderer(const pitch::PitchModel& pitch, Stadium stadium,
                     std::vector<PlateCamera> cameras, const RenderOptions& options);

  // Two bands: what is coarser than some 16 pixels is mixed smoothly over the cameras, finer detail
  // comes from the best camera, so that neither seams nor doubled lines appear.
  Background render(const geometry::CameraEstimate& virtual_camera) const;

  // `direction` of unit length.
  GroundPoint ground_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

  const std::vector<PlateCamera>& cameras() const { return cameras_; }
  const Stadium& stadium() const { return stadium_; }
  const pitch::PitchModel& pitch() const { return pitch_; }
  const GoalFrames& goals() const { return goals_; }

 private:
  // How a camera's plate serves one point of the view.
  struct Term {
    float u = 0, v = 0;  // plate position
    float soft = 0;      // weights of coarse and fine detail, each adding up to 1
    float sharp = 0;
    float texels = 1;  // plate samples a pixel of the view
  };
  struct Corner {
    int surface = kSkySurface;
    double distance = 0;
    float seen = 0;
    Eigen::Vector3f correction = Eigen::Vector3f::Zero();  // coarse band: soft less sharp
  };
  struct View;

  void evaluate(const View& view, double x, double y, Corner& corner, Term* terms) const;
  void render_block(const View& view, int bx, int by, Background& out, double* share) const;
  void fill_unseen(const View& view, Background& out) const;
  Eigen::Vector3f mean_turf() const;

  pitch::PitchModel pitch_;
  Stadium stadium_;
  std::vector<PlateCamera> cameras_;
  RenderOptions options_;
  GoalFrames goals_;
  Eigen::Vector3f turf_colour_ = {70, 110, 60};
};

}  // namespace touchline::render
