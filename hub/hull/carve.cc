#include "hub/hull/carve.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "hub/hull/coverage_internal.h"
#include "hub/hull/silhouette_map_internal.h"
#include "hub/hull/surface_internal.h"
#include "hub/hull/volume_internal.h"
#include "shared/base/bounds.h"

namespace touchline::hull {

namespace {

Participation participation_of(const codec::CameraView& view) {
  if (view.estimate.lost()) return Participation::kLost;
  if (!view.matte) return Participation::kWithoutMatte;
  const geometry::CameraModel& model = view.estimate.model;
  const image::Image<std::uint8_t>& alpha = view.matte->alpha;
  const bool fits = alpha.width() == model.width && alpha.height() == model.height &&
                    alpha.width() >= 2 && alpha.height() >= 2;
  return fits ? Participation::kCarved : Participation::kWrongSize;
}

Components label_anew(Volume& volume, const pitch::PitchModel& pitch, const HullOptions& options) {
  Components components = label_components(volume, pitch);
  if (cut_above_people(volume, components, pitch, options)) {
    components = label_components(volume, pitch);
  }
  return components;
}

// Components that become groups.
std::vector<std::uint8_t> choose_components(const Components& components,
                                            const HullOptions& options) {
  const double sample_m3 = options.voxel_m * options.voxel_m * options.voxel_m;
  std::vector<std::uint8_t> keep(components.list.size());
  for (std::size_t c = 0; c < keep.size(); ++c) {
    const Component& component = components.list[c];
    const bool high = component.lowest_m > options.people_height_m;
    // What is unknown to cameras makes a component larger; it makes none.
    const auto sure = static_cast<double>(component.witnessed + component.healed);
    keep[c] = sure * sample_m3 >= options.min_volume_m3 && component.healed < component.samples &&
              (!high || may_be_ball(component, options));
  }
  return keep;
}

}  // namespace

std::string_view name(Participation participation) {
  switch (participation) {
    case Participation::kCarved:
      return "carved";
    case Participation::kLost:
      return "lost";
    case Participation::kWithoutMatte:
      return "without matte";
    case Participation::kWrongSize:
      return "matte of another size";
  }
  return "without matte";
}

base::Status HullOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("hull.voxel_m", voxel_m, 0.005, 0.2),
        base::in_bounds("hull.dilation_px", dilation_px, 0, 10),
        base::in_bounds("hull.alpha_threshold", alpha_threshold, 1, 255),
        base::in_bounds("hull.min_support", min_support, 1, 6),
        base::in_bounds("hull.margin_m", margin_m, 0, 50),
        base::in_bounds("hull.below_turf_m", below_turf_m, 0, 0.5),
        base::in_bounds("hull.people_height_m", people_height_m, 1, 6),
        base::in_bounds("hull.ball_height_m", ball_height_m, people_height_m, 40),
        base::in_bounds("hull.min_volume_m3", min_volume_m3, 0, 1),
        base::in_bounds("hull.max_ball_m", max_ball_m, 0.2, 3),
        base::in_bounds("hull.phantom_share", phantom_share, 0, 1),
        base::in_bounds("hull.min_billboard_px", min_billboard_px, 1, 100'000)}) {
    if (!status) return status;
  }
  return {};
}

HullResult carve(std::span<const codec::CameraView> views, const pitch::PitchModel& pitch,
                 const HullOptions& options) {
  HullResult result;
  result.hull.voxel_m = options.voxel_m;
  result.hull.dilation_px = options.dilation_px;
  std::vector<std::size_t> used;  // indices of the views that carve
  for (std::size_t i = 0; i < views.size(); ++i) {
    CameraReport report;
    report.camera = views[i].id.camera;
    report.participation = participation_of(views[i]);
    if (report.participation == Participation::kCarved) used.push_back(i);
    result.report.cameras.push_back(std::move(report));
  }
  std::vector<std::optional<SilhouetteMap>> built(used.size());
  tbb::parallel_for(std::size_t{0}, used.size(), [&](std::size_t n) {
    built[n].emplace(views[used[n]], options.alpha_threshold, options.dilation_px);
  });
  std::vector<SilhouetteMap> maps;
  for (auto& map : built) maps.push_back(std::move(*map));

  Volume volume = carve_volume(maps, pitch, options);
  Components components = label_anew(volume, pitch, options);
  std::vector<std::uint8_t> keep = choose_components(components, options);
  std::vector<CameraCoverage> coverage = project_components(maps, volume, components, keep);
  if (options.heal) {
    tbb::parallel_for(std::size_t{0}, maps.size(), [&](std::size_t m) {
      const image::Image<std::uint8_t> mask = unexplained_foreground(maps[m], coverage[m]);
      if (!mask.empty()) maps[m].set_unexplained(mask);
    });
    if (heal_volume(volume, maps, pitch, options)) {
      components = label_anew(volume, pitch, options);
      keep = choose_components(components, options);
      coverage = project_components(maps, volume, components, keep);
    }
  }
  const std::vector<std::uint8_t> phantom =
      find_phantoms(maps, coverage, components, keep, options);
  std::vector<geometry::Mesh> meshes = extract_surfaces(volume, components, keep);

  for (std::size_t c = 0; c < keep.size(); ++c) {
    result.report.inside_samples += components.list[c].samples;
    if (keep[c]) result.report.healed_samples += components.list[c].healed;
    if (!keep[c]) {
      ++result.report.dropped;
      continue;
    }
    scene::HullGroup group;
    group.surface = std::move(meshes[c]);
    for (const Eigen::Vector3f& vertex : group.surface.vertices) {
      group.bounds.extend(vertex.cast<double>());
    }
    group.volume_m3 = enclosed_volume(group.surface);
    for (std::size_t m = 0; m < maps.size(); ++m) {
      if (supports(coverage[m], c)) group.support.push_back(views[used[m]].id.camera);
    }
    group.phantom = phantom[c] != 0;
    result.report.phantoms += group.phantom;
    result.hull.groups.push_back(std::move(group));
  }
  std::stable_sort(result.hull.groups.begin(), result.hull.groups.end(),
                   [](const scene::HullGroup& a, const scene::HullGroup& b) {
                     const Eigen::Vector3d p = a.bounds.center();
                     const Eigen::Vector3d q = b.bounds.center();
                     return p.x() != q.x() ? p.x() < q.x() : p.y() < q.y();
                   });
  for (std::size_t g = 0; g < result.hull.groups.size(); ++g) {
    result.hull.groups[g].id = static_cast<std::uint32_t>(g);
  }

  std::vector<std::vector<scene::Billboard>> cards(maps.size());
  tbb::parallel_for(std::size_t{0}, maps.size(), [&](std::size_t m) {
    cards[m] = find_billboards(maps[m], views[used[m]].id.camera, coverage[m], pitch, options);
  });
  for (auto& of_camera : cards) {
    for (scene::Billboard& card : of_camera) {
      card.id = static_cast<std::uint32_t>(result.hull.billboards.size());
      result.hull.billboards.push_back(std::move(card));
    }
  }
  for (std::size_t m = 0; m < maps.size(); ++m) {
    CameraReport& report = result.report.cameras[used[m]];
    report.foreground_px = maps[m].foreground_px();
    for (std::size_t i = 0; i < coverage[m].count.size(); ++i) {
      report.covered_px += maps[m].foreground().data()[i] && coverage[m].count.data()[i] > 0;
    }
  }
  result.report.cells = volume.cells_tested;
  result.report.bricks = volume.bricks_tested;
  return result;
}

}  // namespace touchline::hull
