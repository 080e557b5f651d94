#include "edge/plate/frame_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace touchline::plate {
namespace {

constexpr int kStep = 16;

struct Plane {
  const std::uint16_t* data;
  std::ptrdiff_t stride;
  int width;
  int height;
  float scale_x;
  float scale_y;
  float shift_y;
};

Plane plane(const image::Frame& frame, std::size_t i) {
  const auto& p = frame.planes[i];
  const auto shift = i == 0 ? image::ChromaShift{} : image::chroma_shift(frame.format);
  // Chroma is co-sited across and, at 4:2:0, half way between two lines.
  return {p.data(),
          p.stride(),
          p.width(),
          p.height(),
          1.f / static_cast<float>(1 << shift.x),
          1.f / static_cast<float>(1 << shift.y),
          shift.y ? -0.25f : 0.f};
}

inline float bilinear(const Plane& p, float x, float y) {
  const float px = std::min(x * p.scale_x, static_cast<float>(p.width) - 1.001f);
  const float py =
      std::clamp(y * p.scale_y + p.shift_y, 0.f, static_cast<float>(p.height) - 1.001f);
  const int ix = static_cast<int>(px);
  const int iy = static_cast<int>(py);
  const float fx = px - static_cast<float>(ix);
  const float fy = py - static_cast<float>(iy);
  const std::uint16_t* a = p.data + iy * p.stride + ix;
  const std::uint16_t* b = a + p.stride;
  const float top = static_cast<float>(a[0]) + fx * static_cast<float>(a[1] - a[0]);
  const float bottom = static_cast<float>(b[0]) + fx * static_cast<float>(b[1] - b[0]);
  return top + fy * (bottom - top);
}

// Catmull-Rom, which keeps lines and lettering as sharp as the frame has them; falls back to
// bilinear at the border.
inline float bicubic(const Plane& p, float x, float y) {
  const int ix = static_cast<int>(x);
  const int iy = static_cast<int>(y);
  if (ix < 1 || iy < 1 || ix + 2 >= p.width || iy + 2 >= p.height) return bilinear(p, x, y);
  const float fx = x - static_cast<float>(ix);
  const float fy = y - static_cast<float>(iy);
  const auto weights = [](float f) {
    return std::array<float, 4>{f * (-0.5f + f * (1.f - 0.5f * f)), 1.f + f * f * (1.5f * f - 2.5f),
                                f * (0.5f + f * (2.f - 1.5f * f)), 0.5f * f * f * (f - 1.f)};
  };
  const auto wx = weights(fx);
  const auto wy = weights(fy);
  const std::uint16_t* row = p.data + (iy - 1) * p.stride + ix - 1;
  float sum = 0;
  for (std::size_t k = 0; k < 4; ++k, row += p.stride)
    sum += wy[k] * (wx[0] * static_cast<float>(row[0]) + wx[1] * static_cast<float>(row[1]) +
                    wx[2] * static_cast<float>(row[2]) + wx[3] * static_cast<float>(row[3]));
  return std::clamp(sum, 0.f, 1023.f);
}

}  // namespace

std::vector<image::PlateTileKey> touched_tiles(const image::PlateSnapshot& sphere,
                                               const geometry::CameraEstimate& camera, int most) {
  constexpr int kPixels = 32;
  const double turn = std::numbers::pi / sphere.radians_per_px;
  // Plate pixels between two of the rays below, with room for distortion.
  const double reach = 1.5 * kPixels / (camera.model.fx * sphere.radians_per_px);
  std::set<image::PlateTileKey> keys;
  for (int y = 0; y < camera.model.height + kPixels; y += kPixels)
    for (int x = 0; x < camera.model.width + kPixels; x += kPixels) {
      const Eigen::Vector2d pixel(std::min(x, camera.model.width - 1),
                                  std::min(y, camera.model.height - 1));
      const Eigen::Vector2d p =
          image::plate_from_direction(sphere, geometry::ray_in_world(camera, pixel));
      for (const double dy : {-reach, reach})
        for (const double dx : {-reach, reach}) {
          double u = p.x() + dx;
          if (u > turn) u -= 2 * turn;
          if (u < -turn) u += 2 * turn;
          keys.insert(
              {static_cast<std::int32_t>(std::floor(u / image::kPlateTileSize)),
               static_cast<std::int32_t>(std::floor((p.y() + dy) / image::kPlateTileSize))});
        }
      if (static_cast<int>(keys.size()) > most) return {};
    }
  return {keys.begin(), keys.end()};
}

void sample_tile(const image::PlateSnapshot& sphere, const image::PlateTileKey& key, int apron,
                 const image::Frame& frame, const geometry::CameraEstimate& camera, int border,
                 TileSamples& out) {
  const int size = image::kPlateTileSize + 2 * apron;
  const auto area = static_cast<std::size_t>(size) * static_cast<std::size_t>(size);
  out.y.assign(area, 0);
  out.cb.assign(area, 0);
  out.cr.assign(area, 0);
  out.inside.assign(area, 0);
  out.seen = 0;

  const int nodes = size / kStep + 2;
  const float nowhere = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> node_x(static_cast<std::size_t>(nodes * nodes), nowhere);
  std::vector<float> node_y(static_cast<std::size_t>(nodes * nodes), nowhere);
  for (int j = 0; j < nodes; ++j)
    for (int i = 0; i < nodes; ++i) {
      const Eigen::Vector2d position(
          image::kPlateTileSize * static_cast<double>(key.column) - apron + i * kStep,
          image::kPlateTileSize * static_cast<double>(key.row) - apron + j * kStep);
      const auto pixel = camera.model.project(camera.cam_from_world.rotation *
                                              image::direction_from_plate(sphere, position));
      if (!pixel) continue;
      node_x[static_cast<std::size_t>(j * nodes + i)] = static_cast<float>(pixel->x());
      node_y[static_cast<std::size_t>(j * nodes + i)] = static_cast<float>(pixel->y());
    }

  const Plane luma = plane(frame, 0);
  const Plane blue = plane(frame, 1);
  const Plane red = plane(frame, 2);
  const auto low = static_cast<float>(border);
  const float right = static_cast<float>(frame.width() - 1 - border) - 0.001f;
  const float bottom = static_cast<float>(frame.height() - 1 - border) - 0.001f;
  for (int y = 0; y < size; ++y) {
    const int j = y / kStep;
    const float t = static_cast<float>(y - j * kStep) / kStep;
    for (int i = 0; i * kStep < size; ++i) {
      const auto n = static_cast<std::size_t>(j * nodes + i);
      const auto m = n + static_cast<std::size_t>(nodes);
      const float xa = node_x[n] + t * (node_x[m] - node_x[n]);
      const float xb = node_x[n + 1] + t * (node_x[m + 1] - node_x[n + 1]);
      const float ya = node_y[n] + t * (node_y[m] - node_y[n]);
      const float yb = node_y[n + 1] + t * (node_y[m + 1] - node_y[n + 1]);
      if (!(std::max(xa, xb) >= low && std::min(xa, xb) <= right && std::max(ya, yb) >= low &&
            std::min(ya, yb) <= bottom))
        continue;
      const float dx = (xb - xa) / kStep;
      const float dy = (yb - ya) / kStep;
      const int end = std::min(kStep, size - i * kStep);
      const auto start = static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                         static_cast<std::size_t>(i * kStep);
      for (int k = 0; k < end; ++k) {
        const float px = xa + dx * static_cast<float>(k);
        const float py = ya + dy * static_cast<float>(k);
        if (!(px >= low && px <= right && py >= low && py <= bottom)) continue;
        const auto at = start + static_cast<std::size_t>(k);
        out.y[at] = static_cast<std::uint16_t>(2.f * bicubic(luma, px, py) + 0.5f);
        out.cb[at] = static_cast<std::uint16_t>(bilinear(blue, px, py) + 0.5f);
        out.cr[at] = static_cast<std::uint16_t>(bilinear(red, px, py) + 0.5f);
        out.inside[at] = 1;
        ++out.seen;
      }
    }
  }
}

}  // namespace touchline::plate
