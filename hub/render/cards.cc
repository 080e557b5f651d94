#include <algorithm>

#include "hub/render/foreground_internal.h"

namespace touchline::render {

std::vector<Card> group_cards(std::span<const SourceView> views, const scene::Hull& hull,
                              const Eigen::Vector3d& eye) {
  std::vector<Card> out;
  for (std::size_t g = 0; g < hull.groups.size(); ++g) {
    const scene::HullGroup& group = hull.groups[g];
    if (group.phantom || group.surface.triangles.empty()) continue;
    const Eigen::Vector3d centre = group.bounds.center();
    const Eigen::Vector3d ray = (centre - eye).normalized();
    int best = -1;
    double best_cosine = -2;
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (!views[i].has_texture()) continue;
      if (std::find(group.support.begin(), group.support.end(), views[i].id()) ==
          group.support.end()) {
        continue;
      }
      float x = 0, y = 0;
      if (!views[i].project(centre, x, y)) continue;
      const double cosine = (centre - views[i].position()).normalized().dot(ray);
      if (cosine > best_cosine) {
        best_cosine = cosine;
        best = static_cast<int>(i);
      }
    }
    if (best < 0) continue;
    const SourceView& view = views[static_cast<std::size_t>(best)];
    Card card;
    card.view = best;
    card.group = static_cast<int>(g);
    card.id = group.id;
    card.region = {0, 0, view.view().estimate.model.width, view.view().estimate.model.height};
    card.point = centre;
    card.normal = view.position() - centre;
    card.normal.z() = 0;
    card.normal.normalize();
    card.top_m = group.bounds.max().z() + 0.5;
    card.half_width_m = group.bounds.diagonal().head<2>().norm() / 2 + 0.2;
    out.push_back(card);
  }
  return out;
}

std::vector<Card> billboard_cards(std::span<const SourceView> views, const scene::Hull& hull) {
  std::vector<Card> out;
  for (const scene::Billboard& billboard : hull.billboards) {
    for (std::size_t i = 0; i < views.size(); ++i) {
      const SourceView& view = views[i];
      if (view.id() != billboard.camera || !view.has_texture()) continue;
      Card card;
      card.view = static_cast<int>(i);
      card.id = billboard.id;
      card.region = billboard.region;
      card.point = billboard.foot_in_world;
      card.normal = view.position() - billboard.foot_in_world;
      card.normal.z() = 0;
      card.normal.normalize();
      card.top_m = billboard.foot_in_world.z() + std::max(0.5, billboard.height_m * 1.1);
      const double metres_per_px =
          (view.position() - billboard.foot_in_world).norm() / view.focal_px();
      card.half_width_m = 0.6 * metres_per_px * billboard.region.width + 0.2;
      out.push_back(card);
      break;
    }
  }
  return out;
}

}  // namespace touchline::render
