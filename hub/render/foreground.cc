#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "hub/render/foreground_internal.h"
#include "hub/render/ray_shape_internal.h"

namespace touchline::render {
namespace {

constexpr int kCell = 32;              // pixels of a part of the picture that is worked on at once
constexpr int kSpread = 3;             // pixels over which the weights of cameras are evened out
constexpr double kSameSurface = 0.15;  // metres in depth within which they are
constexpr float kLookedUp = 0.02f;     // shares of the colour below this are not

// One of the surfaces that a pixel shows, front to back.
struct Layer {
  double distance = 0;
  float coverage = 0;  // of what the layers before it leave open
  int group = -1;
  int card = -1;
};

// A kCell x kCell part of the picture.
struct Cell {
  bool hull = false;
  std::vector<int> cards;
  std::vector<Layer> layers;         // pixel by pixel
  std::vector<ViewWeight> weights;   // of all views, layer by layer
  std::vector<std::uint32_t> first;  // of each pixel's layers, and the end
  std::vector<double> share;
  std::vector<double> groups;
  std::vector<double> card_cover;
};

class Painter {
 public:
  Painter(const ForegroundScene& scene, const pitch::PitchModel& pitch,
          const geometry::CameraEstimate& camera, const RenderOptions& options)
      : scene_(scene),
        pitch_(pitch),
        camera_(camera),
        origin_(geometry::position_in_world(camera)),
        shape_(scene.views, scene.surfaces, options),
        columns_((camera.model.width + kCell - 1) / kCell),
        rows_((camera.model.height + kCell - 1) / kCell),
        cells_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  void mark(const image::Rect& r, bool hull, int card) {
    if (r.empty()) return;
    for (int y = r.y / kCell; y <= (r.y + r.height - 1) / kCell; ++y) {
      for (int x = r.x / kCell; x <= (r.x + r.width - 1) / kCell; ++x) {
        Cell& cell = cells_[static_cast<std::size_t>(y * columns_ + x)];
        cell.hull = cell.hull || hull;
        if (card >= 0) cell.cards.push_back(card);
      }
    }
  }

  void paint(Foreground& out) {
    tbb::parallel_for(std::size_t{0}, cells_.size(), [&](std::size_t k) { find(k); });
    tbb::parallel_for(std::size_t{0}, cells_.size(), [&](std::size_t k) { colour(k, out); });
    for (const Cell& cell : cells_) {
      for (std::size_t i = 0; i < cell.share.size(); ++i) out.share[i] += cell.share[i];
      for (std::size_t i = 0; i < cell.groups.size(); ++i) out.group_cover[i] += cell.groups[i];
      for (std::size_t i = 0; i < cell.card_cover.size(); ++i) {
        out.card_cover[i] += cell.card_cover[i];
      }
    }
  }

 private:
  Eye eye(int x, int y) const {
    return {origin_,
            geometry::ray_in_world(camera_, {static_cast<double>(x), static_cast<double>(y)}),
            1 / camera_.model.fx};
  }

  // First: the layers of each pixel and what each camera may give them.
  void find(std::size_t k) {
    Cell& cell = cells_[k];
    if (!cell.hull && cell.cards.empty()) return;
    const int x0 = static_cast<int>(k) % columns_ * kCell;
    const int y0 = static_cast<int>(k) / columns_ * kCell;
    cell.first.reserve(kCell * kCell + 1);
    for (int y = y0; y < y0 + kCell; ++y) {
      for (int x = x0; x < x0 + kCell; ++x) {
        cell.first.push_back(static_cast<std::uint32_t>(cell.layers.size()));
        if (x < camera_.model.width && y < camera_.model.height) find_layers(eye(x, y), cell);
      }
    }
    cell.first.push_back(static_cast<std::uint32_t>(cell.layers.size()));
  }

  void find_layers(const Eye& eye, Cell& cell) const {
    double ground = std::numeric_limits<double>::infinity();
    if (const auto turf = pitch::intersect_turf(pitch_, eye.origin, eye.direction)) {
      ground = (*turf - eye.origin).norm();
    }
    struct Piece {
      double distance = 0;
      int interval = -1;
      int card = -1;
    };
    std::array<Piece, 32> pieces;
    std::size_t count = 0;
    Intervals intervals;
    if (cell.hull) {
      intervals =
          scene_.surfaces.intervals(eye.origin, eye.direction, std::min(ground + 0.1, 1000.0));
    }
    for (int i = 0; i < intervals.count && count < pieces.size(); ++i) {
      pieces[count++] = {intervals.items[static_cast<std::size_t>(i)].enter, i, -1};
    }
    for (const int card : cell.cards) {
      const Card& c = scene_.cards[static_cast<std::size_t>(card)];
      const double facing = eye.direction.dot(c.normal);
      if (std::abs(facing) < 1e-6 || count == pieces.size()) continue;
      const double t = (c.point - eye.origin).dot(c.normal) / facing;
      if (t > 0 && t < ground + 0.3) pieces[count++] = {t, -1, card};
    }
    std::sort(pieces.begin(), pieces.begin() + static_cast<std::ptrdiff_t>(count),
              [](const Piece& a, const Piece& b) {
                if (a.distance != b.distance) return a.distance < b.distance;
                return a.interval != b.interval ? a.interval < b.interval : a.card < b.card;
              });
    float open = 1;
    const std::size_t views = scene_.views.size();
    for (std::size_t i = 0; i < count && open > 0.005f; ++i) {
      Layer layer;
      if (pieces[i].card >= 0) {
        layer.card = pieces[i].card;
        layer.distance = pieces[i].distance;
        layer.coverage = card_coverage(scene_.cards[static_cast<std::size_t>(layer.card)],
                                       eye.origin + layer.distance * eye.direction);
        if (layer.coverage < 0.02f) continue;
        cell.weights.resize(cell.weights.size() + views);
      } else {
        const Interval& interval = intervals.items[static_cast<std::size_t>(pieces[i].interval)];
        const double leave = std::min(interval.leave, ground + 0.05);
        const Candidates candidates = shape_.rank(eye, 0.5 * (interval.enter + leave));
        const SurfacePoint point = shape_.search(eye, candidates, interval.enter, leave);
        if (point.coverage < 0.02f) continue;
        layer.group = interval.group;
        layer.distance = point.distance;
        layer.coverage = point.coverage;
        cell.weights.resize(cell.weights.size() + views);
        const std::span<ViewWeight> weights(cell.weights.data() + cell.weights.size() - views,
                                            views);
        if (!shape_.weigh(eye, candidates, layer.distance, layer.group, weights)) {
          cell.weights.resize(cell.weights.size() - views);
          continue;
        }
      }
      cell.layers.push_back(layer);
      open *= 1 - layer.coverage;
    }
  }

  float card_coverage(const Card& card, const Eigen::Vector3d& point) const {
    if (point.z() > card.top_m) return 0;
    const SourceView& view = scene_.views[static_cast<std::size_t>(card.view)];
    float x = 0, y = 0;
    if (!view.project(point, x, y)) return 0;
    if (!card.region.contains(static_cast<int>(x + 0.5f), static_cast<int>(y + 0.5f))) return 0;
    const float alpha = view.alpha(x, y);
    if (alpha < 0.02f || view.foreground(x, y).weight <= 0) return 0;
    if (card.group < 0) return alpha;
    const Eigen::Vector3d way = (point - view.position()).normalized();
    return scene_.surfaces.first(view.position(), way) == card.group ? alpha : 0;
  }

  // Second: colours, with weights evened out over neighbouring pixels of the same surface.
  void colour(std::size_t k, Foreground& out) {
    Cell& cell = cells_[k];
    if (cell.layers.empty()) return;
    cell.share.assign(out.share.size(), 0);
    cell.groups.assign(out.group_cover.size(), 0);
    cell.card_cover.assign(out.card_cover.size(), 0);
    const int x0 = static_cast<int>(k) % columns_ * kCell;
    const int y0 = static_cast<int>(k) / columns_ * kCell;
    for (int y = 0; y < kCell; ++y) {
      for (int x = 0; x < kCell; ++x) {
        const auto p = static_cast<std::size_t>(y * kCell + x);
        if (cell.first[p] == cell.first[p + 1]) continue;
        const Eye ray = eye(x0 + x, y0 + y);
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        float covered = 0;
        for (std::uint32_t l = cell.first[p]; l < cell.first[p + 1]; ++l) {
          const Layer& layer = cell.layers[l];
          const float amount = (1 - covered) * layer.coverage;
          sum += amount * layer_colour(cell, l, ray, x0 + x, y0 + y, amount);
          covered += amount;
          if (layer.group >= 0) {
            cell.groups[static_cast<std::size_t>(layer.group)] += static_cast<double>(amount);
          } else {
            cell.card_cover[static_cast<std::size_t>(layer.card)] += static_cast<double>(amount);
          }
        }
        if (covered >= 0.5f) {
          out.distance(x0 + x, y0 + y) = static_cast<float>(cell.layers[cell.first[p]].distance);
        }
        out.colour(x0 + x, y0 + y) = sum;
        out.coverage(x0 + x, y0 + y) = covered;
      }
    }
  }

  Eigen::Vector3f layer_colour(Cell& cell, std::uint32_t l, const Eye& ray, int x, int y,
                               float amount) const {
    const Layer& layer = cell.layers[l];
    const Eigen::Vector3d point = ray.origin + layer.distance * ray.direction;
    const std::size_t views = scene_.views.size();
    std::array<float, kMostViews> weight{};
    if (layer.card >= 0) {
      weight[static_cast<std::size_t>(scene_.cards[static_cast<std::size_t>(layer.card)].view)] = 1;
    } else {
      gather(layer, x, y, weight);
      const ViewWeight* own = cell.weights.data() + l * views;
      float total = 0;
      for (std::size_t i = 0; i < views && i < weight.size(); ++i) {
        // Not from a camera that another person hides here.
        weight[i] *= own[i].weight > 0 ? 1.f : own[i].open;
        total += weight[i];
      }
      for (std::size_t i = 0; i < views && i < weight.size(); ++i) {
        weight[i] = total > 1e-3f ? weight[i] / total : own[i].weight;
      }
    }
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    float total = 0;
    for (std::size_t i = 0; i < views && i < weight.size(); ++i) {
      if (weight[i] < kLookedUp) continue;
      const SourceView& view = scene_.views[i];
      float px = 0, py = 0;
      if (!view.has_texture() || !view.project(point, px, py)) continue;
      const Sample s = view.foreground(px, py);
      if (s.weight <= 0) continue;
      sum += weight[i] * s.colour;
      total += weight[i];
      cell.share[i] += static_cast<double>(amount * weight[i]);
    }
    return total > 0 ? Eigen::Vector3f(sum / total) : Eigen::Vector3f::Zero();
  }

  void gather(const Layer& layer, int x, int y, std::array<float, kMostViews>& weight) const {
    const std::size_t views = std::min<std::size_t>(scene_.views.size(), weight.size());
    for (int ny = std::max(0, y - kSpread); ny <= std::min(camera_.model.height - 1, y + kSpread);
         ++ny) {
      for (int nx = std::max(0, x - kSpread); nx <= std::min(camera_.model.width - 1, x + kSpread);
           ++nx) {
        const Cell& cell = cells_[static_cast<std::size_t>(ny / kCell * columns_ + nx / kCell)];
        if (cell.layers.empty()) continue;
        const auto p = static_cast<std::size_t>(ny % kCell * kCell + nx % kCell);
        for (std::uint32_t l = cell.first[p]; l < cell.first[p + 1]; ++l) {
          const Layer& other = cell.layers[l];
          if (other.group != layer.group || other.card >= 0) continue;
          if (std::abs(other.distance - layer.distance) > kSameSurface) continue;
          const ViewWeight* w = cell.weights.data() + l * scene_.views.size();
          for (std::size_t i = 0; i < views; ++i) weight[i] += w[i].weight;
          break;
        }
      }
    }
  }

  const ForegroundScene& scene_;
  const pitch::PitchModel& pitch_;
  const geometry::CameraEstimate& camera_;
  const Eigen::Vector3d origin_;
  const RayShape shape_;
  const int columns_;
  const int rows_;
  std::vector<Cell> cells_;
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
  Foreground out;
  out.colour = image::Image<Eigen::Vector3f>(camera.model.width, camera.model.height,
                                             Eigen::Vector3f::Zero());
  out.coverage = image::Image<float>(camera.model.width, camera.model.height, 0.f);
  out.distance = image::Image<float>(camera.model.width, camera.model.height,
                                     std::numeric_limits<float>::infinity());
  out.share.assign(scene.views.size(), 0);
  out.group_cover.assign(scene.hull.groups.size(), 0);
  out.card_cover.assign(scene.cards.size(), 0);
  Painter painter(scene, pitch, camera, options);
  for (const scene::HullGroup& group : scene.hull.groups) {
    if (!scene.show_hull || group.phantom || group.surface.triangles.empty()) continue;
    painter.mark(box_in_view(camera, group.bounds), true, -1);
  }
  for (std::size_t i = 0; i < scene.cards.size(); ++i) {
    painter.mark(box_in_view(camera, box_of(scene.cards[i], pitch)), false, static_cast<int>(i));
  }
  painter.paint(out);
  for (double& s : out.share) s /= static_cast<double>(out.coverage.size());
  return out;
}

}  // namespace touchline::render
