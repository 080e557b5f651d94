// Pictures of a simulated match: ray traced, with the lens of geometry::CameraModel, motion blur
// and the coverage of people and ball. The same arguments give the same bytes at any thread count.
#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include "shared/geometry/camera_model.h"
#include "shared/geometry/mesh.h"
#include "shared/geometry/rigid3.h"
#include "shared/image/image.h"
#include "tools/sim/world/world.h"

namespace touchline::sim::people {
class Cast;
}

namespace touchline::sim::render {

struct ShutterPose {
  geometry::CameraModel model;
  geometry::Rigid3 cam_from_world;
};

// The camera moves evenly from one pose to the other while the shutter is open; people likewise
// between their postures at the two times. Both poses have the same picture size.
struct Exposure {
  ShutterPose open;
  ShutterPose close;
  double open_s = 0;   // seconds from the first frame
  double close_s = 0;  // >= open_s
};

struct RenderOptions {
  int edge_samples = 16;  // a pixel at outlines of people: 4, 16 or 64; half at others
  int crowd_samples = 1;  // a pixel in the stands: 1, 2, 4
  bool shadows = true;
};

struct Picture {
  image::Image<std::array<float, 3>> radiance;  // linear; 1.0 = diffuse white in the key light
  image::Image<std::uint8_t> matte;  // coverage by people and ball, cut by posts, nets and flags
};

class Renderer {
 public:
  // Without a cast the ground is empty. World is shared; the cast must outlive the renderer.
  Renderer(const world::World& world, const people::Cast* cast);
  ~Renderer();
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;

  // Uses the task arena of the caller (oneTBB). Exposures with the same times one after the other
  // share the people's geometry: render all cameras of a frame before the next frame. Thread-safe.
  Picture render(const Exposure& exposure, const RenderOptions& options = {}) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// All people and the ball at one time, world metres; clothes may be open shells.
geometry::Mesh mesh_of(const people::Cast& cast, double time_s);

}  // namespace touchline::sim::render
