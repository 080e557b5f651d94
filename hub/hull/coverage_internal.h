// Which foreground pixels each component explains: who supports a group, what is a phantom, and
// which silhouettes are left over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "hub/hull/silhouette_map_internal.h"
#include "hub/hull/volume_internal.h"
#include "hub/scene/hull.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::hull {

// One camera's view of the kept components.
struct CameraCoverage {
  // By component: foreground pixels (y * width + x, rising) inside its projection, and the size of
  // the projection.
  std::vector<std::vector<std::uint32_t>> pixels;
  std::vector<std::size_t> projected_px;
  // By pixel: how many components that are no phantoms cover it.
  image::Image<std::uint16_t> count;
};

// Projects the components for which keep is not 0 into each camera.
std::vector<CameraCoverage> project_components(std::span<const SilhouetteMap> maps,
                                               const Volume& volume, const Components& components,
                                               const std::vector<std::uint8_t>& keep);

// Foreground of a camera that no component covers: 255. Empty when there is none.
image::Image<std::uint8_t> unexplained_foreground(const SilhouetteMap& map,
                                                  const CameraCoverage& coverage);

// A camera saw a component when a twentieth of the projection is foreground.
bool supports(const CameraCoverage& camera, std::size_t component);

// Tries the kept components from the lightest; takes those that are phantoms out of the counts.
std::vector<std::uint8_t> find_phantoms(std::span<const SilhouetteMap> maps,
                                        std::vector<CameraCoverage>& cameras,
                                        const Components& components,
                                        const std::vector<std::uint8_t>& keep,
                                        const HullOptions& options);

// The silhouettes of one camera that no component covers; ids are left at 0.
std::vector<scene::Billboard> find_billboards(const SilhouetteMap& map,
                                              const base::CameraId& camera,
                                              const CameraCoverage& coverage,
                                              const pitch::PitchModel& pitch,
                                              const HullOptions& options);

}  // namespace touchline::hull
