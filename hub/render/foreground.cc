#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "hub/render/foreground_internal.h"

namespace touchline::render {
namespace {

constexpr int kTile = 32;  // pixels of a picture tile that share a list of candidates
constexpr int kMostViews = 32;
constexpr double kDropped = 0.02;  // shares of the colour below this are not looked up
constexpr double kNearSlope = 6;   // of log weight over steps of penalty

// How well a camera serves a point, in steps; 0 is a camera in the virtual one's place.
struct Candidate {
  int view = 0;
  double penalty = 0;
  float matter = 0;  // 0..1: how much its matte decides
};

struct Candidates {
  std::array<Candidate, kMostViews> items;
  int count = 0;
};

struct Eye {
  Eigen::Vector3d origin;
  Eigen::Vector3d direction;
  double pixel = 0;  // radians
};

struct Fragment {
  double distance = 0;
  int interval = -1;
  int card = -1;
};

class Painter {
 public:
  Painter(const ForegroundScene& scene, const pitch::PitchModel& pitch,
          const RenderOptions& options)
      : scene_(scene), pitch_(pitch), options_(options) {}

  struct Pixel {
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();
    float coverage = 0;
  };
  struct Tally {
    std::vector<double> share;
    std::vector<double> groups;
    std::vector<double> cards;
  };

  Pixel paint(const Eye& eye, bool hull_near, std::span<const int> cards, Tally& tally) const {
    double ground = std::numeric_limits<double>::infinity();
    if (const auto turf = pitch::intersect_turf(pitch_, eye.origin, eye.direction)) {
      ground = (*turf - eye.origin).norm();
    }
    Intervals intervals;
    if (hull_near) {
      intervals =
          scene_.surfaces.intervals(eye.origin, eye.direction, std::min(ground + 0.1, 1000.0));
    }
    std::array<Fragment, 32> fragments;
    std::size_t count = 0;
    for (int i = 0; i < intervals.count && count < fragments.size(); ++i) {
      fragments[count++] = {intervals.items[static_cast<std::size_t>(i)].enter, i, -1};
    }
    for (const int card : cards) {
      const Card& c = scene_.cards[static_cast<std::size_t>(card)];
      const double facing = eye.direction.dot(c.normal);
      if (std::abs(facing) < 1e-6 || count == fragments.size()) continue;
      const double t = (c.point - eye.origin).dot(c.normal) / facing;
      if (t > 0 && t < ground + 0.3) fragments[count++] = {t, -1, card};
    }
    std::sort(fragments.begin(), fragments.begin() + static_cast<std::ptrdiff_t>(count),
              [](const Fragment& a, const Fragment& b) {
                if (a.distance != b.distance) return a.distance < b.distance;
                return a.interval != b.interval ? a.interval < b.interval : a.card < b.card;
              });
    Pixel out;
    for (std::size_t i = 0; i < count && out.coverage < 0.995f; ++i) {
      const float open = 1 - out.coverage;
      Eigen::Vector3f colour = Eigen::Vector3f::Zero();
      float coverage = 0;
      if (fragments[i].card >= 0) {
        const Card& card = scene_.cards[static_cast<std::size_t>(fragments[i].card)];
        coverage = paint_card(card, eye.origin + fragments[i].distance * eye.direction, colour);
        tally.cards[static_cast<std::size_t>(fragments[i].card)] +=
            static_cast<double>(open * coverage);
        tally.share[static_cast<std::size_t>(card.view)] += static_cast<double>(open * coverage);
      } else {
        const Interval& interval = intervals.items[static_cast<std::size_t>(fragments[i].interval)];
        coverage = paint_interval(eye, interval, ground, open, colour, tally);
        tally.groups[static_cast<std::size_t>(interval.group)] +=
            static_cast<double>(open * coverage);
      }
      out.colour += open * coverage * colour;
      out.coverage += open * coverage;
    }
    return out;
  }

 private:
  Candidates rank(const Eye& eye, double distance) const {
    Candidates out;
    const Eigen::Vector3d point = eye.origin + distance * eye.direction;
    const double wanted = eye.pixel * distance;
    const double scale = options_.angle_scale_deg * std::numbers::pi / 180;
    for (std::size_t i = 0; i < scene_.views.size() && out.count < kMostViews; ++i) {
      const SourceView& view = scene_.views[i];
      float x = 0, y = 0;
      if (!view.project(point, x, y)) continue;
      const Eigen::Vector3d way = point - view.position();
      const double length = way.norm();
      const double angle = std::acos(std::clamp(way.dot(eye.direction) / length, -1.0, 1.0));
      const double octaves = std::max(0.0, std::log2(length / view.focal_px() / wanted));
      out.items[static_cast<std::size_t>(out.count++)] = {
          static_cast<int>(i), angle / scale + options_.resolution_weight * octaves, 0};
    }
    std::sort(out.items.begin(), out.items.begin() + out.count,
              [](const Candidate& a, const Candidate& b) {
                return a.penalty != b.penalty ? a.penalty < b.penalty : a.view < b.view;
              });
    // The best decide; a camera fades out before the next better ones replace it.
    const int most = std::min(out.count, options_.cameras_per_point);
    const double limit = out.count > most ? out.items[static_cast<std::size_t>(most)].penalty
                                          : std::numeric_limits<double>::infinity();
    const double least = out.count > 0 ? out.items[0].penalty : 0;
    for (int k = 0; k < most; ++k) {
      Candidate& c = out.items[static_cast<std::size_t>(k)];
      const double room = std::max(0.25 * (limit - least), 0.25);
      c.matter = std::isfinite(limit)
                     ? static_cast<float>(std::clamp((limit - c.penalty) / room, 0.0, 1.0))
                     : 1.f;
      if (k == 0) c.matter = 1;
    }
    return out;
  }

  // 0..1: what the mattes of the deciding cameras leave of a point.
  float agreement(const Candidates& candidates, const Eigen::Vector3d& point) const {
    float left = 1;
    for (int k = 0; k < candidates.count; ++k) {
      const Candidate& c = candidates.items[static_cast<std::size_t>(k)];
      if (c.matter <= 0) break;
      const SourceView& view = scene_.views[static_cast<std::size_t>(c.view)];
      float x = 0, y = 0;
      if (!view.project(point, x, y)) continue;
      left *= 1 - c.matter * (1 - view.support(x, y));
      if (left < 0.02f) return 0;
    }
    return left;
  }

  float paint_interval(const Eye& eye, const Interval& interval, double ground, float open,
                       Eigen::Vector3f& colour, Tally& tally) const {
    const double enter = interval.enter;
    const double leave = std::min(interval.leave, ground + 0.05);
    if (leave <= enter) return 0;
    const Candidates candidates = rank(eye, 0.5 * (enter + leave));
    if (candidates.count == 0) return 0;
    const int steps =
        std::clamp(static_cast<int>(std::ceil((leave - enter) / options_.step_m)), 1, 400);
    const double step = (leave - enter) / steps;
    float best = 0;
    double best_at = enter;
    bool found = false;
    for (int k = 0; k <= steps; ++k) {
      const double t = enter + k * step;
      const float value = agreement(candidates, eye.origin + t * eye.direction);
      if (value > best) {
        best = value;
        if (!found) best_at = t;
      }
      if (value >= 0.5f) found = true;
      if (best > 0.98f) break;
    }
    if (best < 0.02f) return 0;
    return texture(eye, candidates, best_at, interval.group, colour, open * best, tally) ? best
                                                                                         : 0.f;
  }

  double visibility(const SourceView& view, const Eigen::Vector3d& point, int group) const {
    const HullSurfaces::Blocking b = scene_.surfaces.blocking(point, view.position(), group);
    const double own = b.own / std::max(options_.visible_depth_m, 1e-3);
    return std::clamp(2 - own, 0.0, 1.0) * std::clamp(1 - b.other / 0.05, 0.0, 1.0);
  }

  // Colour from the cameras that see the point, the best ones first.
  bool texture(const Eye& eye, const Candidates& candidates, double distance, int group,
               Eigen::Vector3f& colour, float amount, Tally& tally) const {
    const Eigen::Vector3d point = eye.origin + distance * eye.direction;
    std::array<double, kMostViews> weight{};
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double total = 0;
    // Twice: cameras that see the point; and where none does, those whose matte holds foreground.
    for (int pass = 0; pass < 2 && total <= 0; ++pass) {
      for (int k = 0; k < candidates.count; ++k) {
        const Candidate& c = candidates.items[static_cast<std::size_t>(k)];
        const auto at = static_cast<std::size_t>(c.view);
        const SourceView& view = scene_.views[at];
        if (!view.has_texture()) continue;
        const double near = std::exp(-kNearSlope * (c.penalty - candidates.items[0].penalty));
        if (near < kDropped * total) break;
        float x = 0, y = 0;
        if (!view.project(point, x, y)) continue;
        const Sample s = view.foreground(x, y);
        if (s.weight <= 0) continue;
        double w = near * static_cast<double>(s.weight);
        if (pass == 0) w *= visibility(view, point, group);
        if (w <= 0) continue;
        sum += w * s.colour.cast<double>();
        total += w;
        weight[at] = w;
      }
    }
    if (total <= 0) return false;
    colour = (sum / total).cast<float>();
    for (std::size_t i = 0; i < scene_.views.size() && i < weight.size(); ++i) {
      tally.share[i] += static_cast<double>(amount) * weight[i] / total;
    }
    return true;
  }

  float paint_card(const Card& card, const Eigen::Vector3d& point, Eigen::Vector3f& colour) const {
    if (point.z() > card.top_m) return 0;
    const SourceView& view = scene_.views[static_cast<std::size_t>(card.view)];
    float x = 0, y = 0;
    if (!view.project(point, x, y)) return 0;
    if (!card.region.contains(static_cast<int>(x + 0.5f), static_cast<int>(y + 0.5f))) return 0;
    const float alpha = view.alpha(x, y);
    if (alpha < 0.02f) return 0;
    if (card.group >= 0 &&
        scene_.surfaces.first(view.position(), (point - view.position()).normalized()) !=
            card.group) {
      return 0;
    }
    const Sample s = view.foreground(x, y);
    if (s.weight <= 0) return 0;
    colour = s.colour;
    return alpha;
  }

  const ForegroundScene& scene_;
  const pitch::PitchModel& pitch_;
  const RenderOptions& options_;
};

// Pixels that a world box may cover, one pixel more on each side; the whole picture when a corner
// lies behind the camera.
image::Rect box_in_view(const geometry::CameraEstimate& camera, const Eigen::AlignedBox3d& box) {
  const image::Rect whole{0, 0, camera.model.width, camera.model.height};
  double x0 = 1e9, y0 = 1e9, x1 = -1e9, y1 = -1e9;
  int behind = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d corner = box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if ((camera.cam_from_world * corner).z() < 0.05) {
      ++behind;
      continue;
    }
    const auto p = geometry::project(camera, corner);
    if (!p) return whole;
    x0 = std::min(x0, p->x());
    y0 = std::min(y0, p->y());
    x1 = std::max(x1, p->x());
    y1 = std::max(y1, p->y());
  }
  if (behind == 8) return {};
  if (behind > 0) return whole;
  const int left = std::max(0, static_cast<int>(std::floor(std::max(x0, -1e6))) - 1);
  const int top = std::max(0, static_cast<int>(std::floor(std::max(y0, -1e6))) - 1);
  const int right = std::min(whole.width, static_cast<int>(std::ceil(std::min(x1, 1e6))) + 2);
  const int bottom = std::min(whole.height, static_cast<int>(std::ceil(std::min(y1, 1e6))) + 2);
  if (right <= left || bottom <= top) return {};
  return {left, top, right - left, bottom - top};
}

Eigen::AlignedBox3d box_of(const Card& card, const pitch::PitchModel& pitch) {
  const Eigen::Vector3d side(-card.normal.y(), card.normal.x(), 0);
  Eigen::AlignedBox3d box;
  for (const double s : {-card.half_width_m, card.half_width_m}) {
    for (const double z : {-pitch.crown_m - 0.5, card.top_m}) {
      Eigen::Vector3d p = card.point + s * side;
      p.z() = z;
      box.extend(p);
    }
  }
  return box;
}

}  // namespace

Foreground render_foreground(const ForegroundScene& scene, const pitch::PitchModel& pitch,
                             const geometry::CameraEstimate& camera, const RenderOptions& options) {
  const int width = camera.model.width;
  const int height = camera.model.height;
  Foreground out;
  out.colour = image::Image<Eigen::Vector3f>(width, height, Eigen::Vector3f::Zero());
  out.coverage = image::Image<float>(width, height, 0.f);
  out.share.assign(scene.views.size(), 0);
  out.group_cover.assign(scene.hull.groups.size(), 0);
  out.card_cover.assign(scene.cards.size(), 0);

  // What each tile of the picture may show.
  const int columns = (width + kTile - 1) / kTile;
  const int rows = (height + kTile - 1) / kTile;
  struct Cell {
    bool hull = false;
    std::vector<int> cards;
  };
  std::vector<Cell> cells(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const auto mark = [&](const image::Rect& r, auto&& action) {
    if (r.empty()) return;
    for (int y = r.y / kTile; y <= (r.y + r.height - 1) / kTile; ++y) {
      for (int x = r.x / kTile; x <= (r.x + r.width - 1) / kTile; ++x) {
        action(cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
                     static_cast<std::size_t>(x)]);
      }
    }
  };
  if (scene.show_hull) {
    for (const scene::HullGroup& group : scene.hull.groups) {
      if (group.phantom || group.surface.triangles.empty()) continue;
      mark(box_in_view(camera, group.bounds), [](Cell& cell) { cell.hull = true; });
    }
  }
  for (std::size_t i = 0; i < scene.cards.size(); ++i) {
    mark(box_in_view(camera, box_of(scene.cards[i], pitch)),
         [i](Cell& cell) { cell.cards.push_back(static_cast<int>(i)); });
  }

  const Painter painter(scene, pitch, options);
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  std::vector<Painter::Tally> tallies(cells.size());
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t k) {
    const Cell& cell = cells[k];
    if (!cell.hull && cell.cards.empty()) return;
    Painter::Tally& tally = tallies[k];
    tally.share.assign(out.share.size(), 0);
    tally.groups.assign(out.group_cover.size(), 0);
    tally.cards.assign(out.card_cover.size(), 0);
    const int x0 = static_cast<int>(k) % columns * kTile;
    const int y0 = static_cast<int>(k) / columns * kTile;
    for (int y = y0; y < std::min(height, y0 + kTile); ++y) {
      for (int x = x0; x < std::min(width, x0 + kTile); ++x) {
        const Eye eye{
            origin,
            geometry::ray_in_world(camera, {static_cast<double>(x), static_cast<double>(y)}),
            1 / camera.model.fx};
        const Painter::Pixel pixel = painter.paint(eye, cell.hull, cell.cards, tally);
        out.colour(x, y) = pixel.colour;
        out.coverage(x, y) = pixel.coverage;
      }
    }
  });
  for (const Painter::Tally& tally : tallies) {
    for (std::size_t i = 0; i < tally.share.size(); ++i) out.share[i] += tally.share[i];
    for (std::size_t i = 0; i < tally.groups.size(); ++i) out.group_cover[i] += tally.groups[i];
    for (std::size_t i = 0; i < tally.cards.size(); ++i) out.card_cover[i] += tally.cards[i];
  }
  for (double& s : out.share) s /= static_cast<double>(width) * height;
  return out;
}

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
