// Views that no camera shot (chapter 4.5): people from the hull with view-dependent texture, pitch
// and stadium from the plates.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hub/render/colour_reference.h"
#include "hub/render/render_options.h"
#include "hub/render/stadium.h"
#include "hub/scene/hull.h"
#include "hub/scene/picture.h"
#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::render {

enum class Mode : std::uint8_t {
  kRefined,    // shown as hull, with a warning, where no refined layers are given
  kHull,       // surfaces of the hull, textured from the best cameras
  kBillboard,  // one card a group, from the nearest camera
};
std::string_view name(Mode mode);
base::Result<Mode> parse_mode(const std::string& text);

struct ShownGroup {
  std::uint32_t id = 0;  // of the hull group or billboard
  scene::Rendition rendition = scene::Rendition::kAbsent;
};

struct RenderReport {
  std::map<base::CameraId, double>
      share_by_camera;          // of the picture, by blending weight; sums to 1 - unseen
  double unseen_share = 0;      // of the picture that no camera's plate or tile shows
  double foreground_share = 0;  // of the picture, by coverage
  std::vector<ShownGroup> groups;
  std::vector<std::string> warnings;
};

struct RenderResult {
  scene::Picture picture;
  RenderReport report;
};

// Built once for a session (or when plates change): textures and stadium are prepared here. Const
// afterwards; render may be called from several threads. The same bytes at any thread count.
class Renderer {
 public:
  // Invalid options fail by name. Plates may be missing: what they would show is then unseen.
  static base::Result<Renderer> make(const pitch::PitchModel& pitch,
                                     const std::map<base::CameraId, image::PlateSnapshot>& plates,
                                     const ColourReference& colour,
                                     const RenderOptions& options = {});
  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

  // The picture of `virtual_camera` (its model's size), people over pitch and stadium; coverage is
  // 255 everywhere. Views without tiles give shape but no colour; lost views are not used.
  RenderResult render(std::span<const codec::CameraView> views, const scene::Hull& hull,
                      const geometry::CameraEstimate& virtual_camera, Mode mode) const;

  // People and ball alone: straight colour and coverage; 0 elsewhere.
  RenderResult render_foreground(std::span<const codec::CameraView> views, const scene::Hull& hull,
                                 const geometry::CameraEstimate& virtual_camera, Mode mode) const;

  const Stadium& stadium() const;

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace touchline::render
