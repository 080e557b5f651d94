// People and ball of a virtual view: along each ray inside the hull, the first point that the best
// cameras' mattes agree on, textured from the cameras that see it.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "hub/render/background_internal.h"
#include "hub/render/hull_surfaces_internal.h"
#include "hub/render/render_options.h"
#include "hub/render/source_view_internal.h"
#include "hub/scene/hull.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"

namespace touchline::render {

// An upright picture of somebody, as one camera shows him.
struct Card {
  int view = 0;            // index of the camera that it shows
  int group = -1;          // only what this hull group covers; -1: everything in `region`
  std::uint32_t id = 0;    // of the group or billboard
  image::Rect region;      // of that camera's frame
  Eigen::Vector3d point;   // on the card
  Eigen::Vector3d normal;  // horizontal, towards that camera
  double top_m = 0;        // above world zero
  double half_width_m = 0;
};

struct Foreground {
  image::Image<Eigen::Vector3f> colour;  // 0..255, multiplied by coverage
  image::Image<float> coverage;          // 0..1
  image::Image<float> distance;     // of the first person in a pixel, metres; infinite for none
  std::vector<double> share;        // of the picture by view
  std::vector<double> group_cover;  // pixels that each hull group covers
  std::vector<double> card_cover;
};

struct ForegroundScene {
  std::span<const SourceView> views;
  const scene::Hull& hull;
  const HullSurfaces& surfaces;
  std::vector<Card> cards;
  bool show_hull = true;  // false: cards alone
};

Foreground render_foreground(const ForegroundScene& scene, const pitch::PitchModel& pitch,
                             const geometry::CameraEstimate& virtual_camera,
                             const RenderOptions& options);

// One card for each hull group that is no phantom, from the camera that sees it at the least angle
// from the virtual camera; groups that no camera with tiles sees get none.
std::vector<Card> group_cards(std::span<const SourceView> views, const scene::Hull& hull,
                              const Eigen::Vector3d& eye);
// Cards of the billboards whose cameras are among the views.
std::vector<Card> billboard_cards(std::span<const SourceView> views, const scene::Hull& hull);

}  // namespace touchline::render
