#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hub/hull/coverage_internal.h"

namespace touchline::hull {

namespace {

constexpr std::uint8_t kOutside = 255;
constexpr double kFloating = 0.3;      // metres above the turf
constexpr double kBallPicture = 0.45;  // a ball's silhouette is no larger than this, metres

// The projection of one component as a mask over its box in the picture.
struct Projection {
  BoxFootprint box;
  image::Image<std::uint8_t> mask;
};

Projection project_component(const SilhouetteMap& map, const Volume& volume,
                             const Components& components, std::size_t component,
                             const std::vector<std::uint32_t>& bricks) {
  Projection out;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(volume.voxel_m);
  const Eigen::AlignedBox3d& bounds = components.list[component].bounds;
  out.box = map.footprint(bounds.min() - margin, bounds.max() + margin);
  if (out.box.place == BoxPlace::kOutside) return out;
  const int width = out.box.x1 - out.box.x0 + 1;
  const int height = out.box.y1 - out.box.y0 + 1;
  out.mask = image::Image<std::uint8_t>(width, height);
  const auto voxel = static_cast<float>(volume.voxel_m);
  const auto focal = static_cast<float>(map.camera().model.fx);
  const Eigen::Vector3d along = map.turned({volume.voxel_m, 0, 0});
  std::array<float, kBrick> u;
  std::array<float, kBrick> v;
  std::array<float, kBrick> z;
  for (const std::uint32_t b : bricks) {
    const Brick& brick = volume.bricks[b];
    for (int row = 0; row < kBrick * kBrick; ++row) {
      // Samples a voxel and more inside add nothing to the outline.
      std::array<bool, kBrick> wanted{};
      bool any = false;
      for (int i = 0; i < kBrick; ++i) {
        const auto s = static_cast<std::size_t>(row * kBrick + i);
        const bool is = brick.label[s] != kOutside && brick.field[s] < voxel &&
                        components.at(brick, static_cast<int>(s)) == component;
        wanted[static_cast<std::size_t>(i)] = is;
        any |= is;
      }
      if (!any) continue;
      const Eigen::Vector3d start =
          map.in_cam(volume.sample_in_world(brick.key, 0, row % kBrick, row / kBrick));
      map.project_row(start, along, kBrick, u.data(), v.data(), z.data());
      for (std::size_t i = 0; i < kBrick; ++i) {
        if (!wanted[i] || z[i] <= 0) continue;
        const int reach = static_cast<int>(std::ceil(0.6F * voxel * focal / z[i] + 0.2F));
        const int x = static_cast<int>(std::lround(u[i])) - out.box.x0;
        const int y = static_cast<int>(std::lround(v[i])) - out.box.y0;
        const int x0 = std::max(x - reach, 0);
        const int x1 = std::min(x + reach, width - 1);
        for (int yy = std::max(y - reach, 0); yy <= std::min(y + reach, height - 1); ++yy) {
          std::uint8_t* to = out.mask.row(yy);
          for (int xx = x0; xx <= x1; ++xx) to[xx] = 1;
        }
      }
    }
  }
  return out;
}

// The connected foreground that holds any of `pixels` is no larger than `limit` pixels either way.
bool is_small_silhouette(const image::Image<std::uint8_t>& foreground,
                         const std::vector<std::uint32_t>& pixels, int limit) {
  if (pixels.empty()) return false;
  const int width = foreground.width();
  const int x_first = static_cast<int>(pixels.front()) % width;
  const int y_first = static_cast<int>(pixels.front()) / width;
  // Whatever is small enough lies inside this window; its rim is never reached.
  const int x0 = std::max(x_first - limit - 1, 0);
  const int y0 = std::max(y_first - limit - 1, 0);
  const int x1 = std::min(x_first + limit + 1, width - 1);
  const int y1 = std::min(y_first + limit + 1, foreground.height() - 1);
  image::Image<std::uint8_t> done(x1 - x0 + 1, y1 - y0 + 1);
  std::vector<std::pair<int, int>> stack;
  for (const std::uint32_t pixel : pixels) {
    const int x = static_cast<int>(pixel) % width;
    const int y = static_cast<int>(pixel) / width;
    if (x < x0 || x > x1 || y < y0 || y > y1) return false;
    if (done(x - x0, y - y0)) continue;
    done(x - x0, y - y0) = 1;
    stack.emplace_back(x, y);
  }
  int left = width;
  int right = 0;
  int top = foreground.height();
  int bottom = 0;
  while (!stack.empty()) {
    const auto [x, y] = stack.back();
    stack.pop_back();
    left = std::min(left, x);
    right = std::max(right, x);
    top = std::min(top, y);
    bottom = std::max(bottom, y);
    if (right - left >= limit || bottom - top >= limit) return false;
    for (int yy = std::max(y - 1, y0); yy <= std::min(y + 1, y1); ++yy) {
      for (int xx = std::max(x - 1, x0); xx <= std::min(x + 1, x1); ++xx) {
        if (!foreground(xx, yy) || done(xx - x0, yy - y0)) continue;
        done(xx - x0, yy - y0) = 1;
        stack.emplace_back(xx, yy);
      }
    }
  }
  return true;
}

// Small, and alone in the picture of a camera at least.
bool looks_like_ball(std::span<const SilhouetteMap> maps,
                     const std::vector<CameraCoverage>& cameras, const Components& components,
                     std::size_t c, const HullOptions& options) {
  if (!may_be_ball(components.list[c], options)) return false;
  for (std::size_t m = 0; m < maps.size(); ++m) {
    const double depth = maps[m].in_cam(components.list[c].bounds.center()).z();
    const int limit = static_cast<int>(kBallPicture * maps[m].camera().model.fx / depth) + 2;
    if (is_small_silhouette(maps[m].foreground(), cameras[m].pixels[c], limit)) return true;
  }
  return false;
}

}  // namespace

std::vector<CameraCoverage> project_components(std::span<const SilhouetteMap> maps,
                                               const Volume& volume, const Components& components,
                                               const std::vector<std::uint8_t>& keep) {
  const std::size_t count = components.list.size();
  std::vector<std::vector<std::uint32_t>> bricks(count);
  for (std::uint32_t b = 0; b < volume.bricks.size(); ++b) {
    const Brick& brick = volume.bricks[b];
    for (int s = 0; s < kBrickSamples; ++s) {
      if (brick.label[static_cast<std::size_t>(s)] == kOutside) continue;
      const std::uint32_t component = components.at(brick, s);
      if (keep[component] && (bricks[component].empty() || bricks[component].back() != b)) {
        bricks[component].push_back(b);
      }
    }
  }
  for (auto& list : bricks) list.erase(std::unique(list.begin(), list.end()), list.end());
  std::vector<std::size_t> kept;
  for (std::size_t c = 0; c < count; ++c) {
    if (keep[c]) kept.push_back(c);
  }
  std::vector<CameraCoverage> cameras(maps.size());
  for (std::size_t m = 0; m < maps.size(); ++m) {
    cameras[m].pixels.resize(count);
    cameras[m].projected_px.resize(count);
    cameras[m].count =
        image::Image<std::uint16_t>(maps[m].foreground().width(), maps[m].foreground().height());
  }
  tbb::parallel_for(
      tbb::blocked_range<std::size_t>(0, kept.size() * maps.size(), 1), [&](const auto& range) {
        for (std::size_t n = range.begin(); n < range.end(); ++n) {
          const std::size_t m = n % maps.size();
          const std::size_t c = kept[n / maps.size()];
          const Projection p = project_component(maps[m], volume, components, c, bricks[c]);
          const image::Image<std::uint8_t>& foreground = maps[m].foreground();
          for (int y = 0; y < p.mask.height(); ++y) {
            const std::uint8_t* mask = p.mask.row(y);
            const std::uint8_t* seen = foreground.row(y + p.box.y0) + p.box.x0;
            const auto base =
                static_cast<std::uint32_t>((y + p.box.y0) * foreground.width() + p.box.x0);
            for (int x = 0; x < p.mask.width(); ++x) {
              if (!mask[x]) continue;
              ++cameras[m].projected_px[c];
              if (seen[x]) cameras[m].pixels[c].push_back(base + static_cast<std::uint32_t>(x));
            }
          }
        }
      });
  tbb::parallel_for(std::size_t{0}, maps.size(), [&](std::size_t m) {
    for (const std::size_t c : kept) {
      for (const std::uint32_t pixel : cameras[m].pixels[c]) ++cameras[m].count.data()[pixel];
    }
  });
  return cameras;
}

image::Image<std::uint8_t> unexplained_foreground(const SilhouetteMap& map,
                                                  const CameraCoverage& coverage) {
  const image::Image<std::uint8_t>& foreground = map.foreground();
  image::Image<std::uint8_t> mask(foreground.width(), foreground.height());
  std::uint8_t any = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    mask.data()[i] = coverage.count.data()[i] == 0 ? foreground.data()[i] : 0;
    any |= mask.data()[i];
  }
  if (!any) return {};
  return mask;
}

bool supports(const CameraCoverage& camera, std::size_t component) {
  return !camera.pixels[component].empty() &&
         camera.pixels[component].size() * 20 >= camera.projected_px[component];
}

std::vector<std::uint8_t> find_phantoms(std::span<const SilhouetteMap> maps,
                                        std::vector<CameraCoverage>& cameras,
                                        const Components& components,
                                        const std::vector<std::uint8_t>& keep,
                                        const HullOptions& options) {
  const std::size_t count = components.list.size();
  std::vector<double> weight(count);
  std::vector<std::uint8_t> floats(count);
  std::vector<std::size_t> order;
  for (std::size_t c = 0; c < count; ++c) {
    if (!keep[c]) continue;
    const Component& component = components.list[c];
    weight[c] = static_cast<double>(component.samples);
    floats[c] =
        component.lowest_m > kFloating && !looks_like_ball(maps, cameras, components, c, options);
    if (floats[c]) weight[c] /= 4;
    order.push_back(c);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return weight[a] < weight[b]; });
  std::vector<std::uint8_t> phantom(count, 0);
  for (const std::size_t c : order) {
    int needed_by = 0;  // cameras
    for (const CameraCoverage& camera : cameras) {
      std::size_t alone = 0;
      for (const std::uint32_t pixel : camera.pixels[c]) alone += camera.count.data()[pixel] == 1;
      needed_by += static_cast<double>(alone) >
                   options.phantom_share * static_cast<double>(camera.pixels[c].size());
    }
    if (needed_by >= (floats[c] ? 2 : 1)) continue;
    phantom[c] = 1;
    for (CameraCoverage& camera : cameras) {
      for (const std::uint32_t pixel : camera.pixels[c]) --camera.count.data()[pixel];
    }
  }
  return phantom;
}

}  // namespace touchline::hull
