// Where a ray of the virtual camera meets people inside the hull, and which cameras colour them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>

#include "hub/render/hull_surfaces_internal.h"
#include "hub/render/render_options.h"
#include "hub/render/source_view_internal.h"

namespace touchline::render {

inline constexpr int kMostViews = 32;

// A ray of the virtual camera.
struct Eye {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;  // unit
  double pixel = 0;           // radians
};

// How well a camera serves a point, in steps; 0 is a camera in the virtual one's place.
struct Candidate {
  int view = 0;
  double penalty = 0;
  float matter = 0;  // 0..1: how much its matte decides
};

// Best first.
struct Candidates {
  std::array<Candidate, kMostViews> items;
  int count = 0;
};

// The first point of a ray inside an interval that the mattes agree on.
struct SurfacePoint {
  double distance = 0;
  float coverage = 0;
};

// What a view may contribute to the colour of a point.
struct ViewWeight {
  float weight = 0;  // by angle, resolution, tile border and visibility
  float open = 0;    // 0..1: no other group stands between
};

class RayShape {
 public:
  RayShape(std::span<const SourceView> views, const HullSurfaces& surfaces,
           const RenderOptions& options)
      : views_(views), surfaces_(surfaces), options_(options) {}

  // Cameras that have the point in their picture.
  Candidates rank(const Eye& eye, double distance) const;

  // `leave` cuts the interval short.
  SurfacePoint search(const Eye& eye, const Candidates& candidates, double enter,
                      double leave) const;

  // Weights of all views for a point, adding up to 1; false when no tile shows it. Where no camera
  // sees it those whose matte holds foreground there are taken.
  bool weigh(const Eye& eye, const Candidates& candidates, double distance, int group,
             std::span<ViewWeight> weights) const;

 private:
  float agreement(const Candidates& candidates, const Eigen::Vector3d& point) const;

  std::span<const SourceView> views_;
  const HullSurfaces& surfaces_;
  const RenderOptions& options_;
};

}  // namespace touchline::render
