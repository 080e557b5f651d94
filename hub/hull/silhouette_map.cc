#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "hub/hull/silhouette_map_internal.h"

namespace touchline::hull {

namespace {

constexpr int kChunk = 32;  // pixels; at least the largest reach

std::size_t offset(int x, int y, int columns) {
  return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns) +
         static_cast<std::size_t>(x);
}

// Which chunks of a row hold a pixel that is set.
void mark_chunks(const std::uint8_t* row, int width, std::uint8_t* chunks, int chunk_count) {
  for (int c = 0; c < chunk_count; ++c) {
    const int end = std::min((c + 1) * kChunk, width);
    std::uint8_t any = 0;
    for (int x = c * kChunk; x < end; ++x) any |= row[x];
    chunks[c] = any != 0;
  }
}

// Horizontal distance to the nearest set pixel, capped at `cap`, for x in [begin, end).
void row_distance(const std::uint8_t* mask, int begin, int end, int cap, std::uint8_t* out) {
  int last = cap;
  for (int x = begin; x < end; ++x) {
    last = mask[x] ? 0 : std::min(last + 1, cap);
    out[x] = static_cast<std::uint8_t>(last);
  }
  last = cap;
  for (int x = end - 1; x >= begin; --x) {
    last = mask[x] ? 0 : std::min(last + 1, cap);
    out[x] = static_cast<std::uint8_t>(std::min<int>(last, out[x]));
  }
}

}  // namespace

image::Image<std::uint8_t> banded_distance(const image::Image<std::uint8_t>& mask, int reach) {
  const int width = mask.width();
  const int height = mask.height();
  const int cap = reach + 1;
  const int chunk_count = (width + kChunk - 1) / kChunk;
  std::vector<std::uint8_t> holds(static_cast<std::size_t>(chunk_count) *
                                  static_cast<std::size_t>(height));
  // Chunks of the horizontal pass: those with a set pixel and their neighbours in the row.
  std::vector<std::uint8_t> near(holds.size());
  image::Image<std::uint8_t> across(width, height, static_cast<std::uint8_t>(cap));
  for (int y = 0; y < height; ++y) {
    std::uint8_t* here = &holds[offset(0, y, chunk_count)];
    std::uint8_t* wide = &near[offset(0, y, chunk_count)];
    mark_chunks(mask.row(y), width, here, chunk_count);
    for (int c = 0; c < chunk_count; ++c) {
      wide[c] = here[c] || (c > 0 && here[c - 1]) || (c + 1 < chunk_count && here[c + 1]);
    }
    for (int c = 0; c < chunk_count;) {
      if (!wide[c]) {
        ++c;
        continue;
      }
      int end = c;
      while (end < chunk_count && wide[end]) ++end;
      row_distance(mask.row(y), c * kChunk, std::min(end * kChunk, width), cap, across.row(y));
      c = end;
    }
  }
  std::vector<std::uint8_t> root(2 * static_cast<std::size_t>(cap * cap) + 1);
  for (std::size_t i = 0; i < root.size(); ++i) {
    const double distance = std::sqrt(static_cast<double>(i));
    root[i] =
        distance > reach
            ? 255
            : static_cast<std::uint8_t>(std::min(255.0, std::round(distance / kDistanceStep)));
  }
  image::Image<std::uint8_t> out(width, height, 255);
  std::array<std::uint16_t, kChunk> best{};
  for (int y = 0; y < height; ++y) {
    const int y0 = std::max(y - reach, 0);
    const int y1 = std::min(y + reach, height - 1);
    for (int c = 0; c < chunk_count; ++c) {
      const int x0 = c * kChunk;
      const int count = std::min(kChunk, width - x0);
      bool any = false;
      best.fill(static_cast<std::uint16_t>(2 * cap * cap));
      for (int yy = y0; yy <= y1; ++yy) {
        if (!near[offset(c, yy, chunk_count)]) continue;
        any = true;
        const std::uint8_t* row = across.row(yy) + x0;
        const int down = (yy - y) * (yy - y);
        if (count == kChunk) {
          for (int i = 0; i < kChunk; ++i) {
            const auto d = static_cast<std::uint16_t>(row[i] * row[i] + down);
            best[static_cast<std::size_t>(i)] = std::min(best[static_cast<std::size_t>(i)], d);
          }
        } else {
          for (int i = 0; i < count; ++i) {
            const auto d = static_cast<std::uint16_t>(row[i] * row[i] + down);
            best[static_cast<std::size_t>(i)] = std::min(best[static_cast<std::size_t>(i)], d);
          }
        }
      }
      if (!any) continue;
      std::uint8_t* to = out.row(y) + x0;
      for (int i = 0; i < count; ++i) to[i] = root[best[static_cast<std::size_t>(i)]];
    }
  }
  return out;
}

BlockCount::BlockCount(const image::Image<std::uint8_t>& distance, std::uint8_t limit) {
  const int across = (distance.width() + kBlock - 1) / kBlock;
  const int down = (distance.height() + kBlock - 1) / kBlock;
  columns_ = across + 1;
  sums_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(down + 1), 0);
  std::vector<std::uint8_t> least(static_cast<std::size_t>(distance.width()));
  for (int by = 0; by < down; ++by) {
    std::copy_n(distance.row(by * kBlock), distance.width(), least.begin());
    const int y_end = std::min((by + 1) * kBlock, distance.height());
    for (int y = by * kBlock + 1; y < y_end; ++y) {
      const std::uint8_t* row = distance.row(y);
      for (std::size_t x = 0; x < least.size(); ++x) least[x] = std::min(least[x], row[x]);
    }
    std::int32_t sum = 0;
    for (int bx = 0; bx < across; ++bx) {
      const int end = std::min((bx + 1) * kBlock, distance.width());
      std::uint8_t low = 255;
      for (int x = bx * kBlock; x < end; ++x)
        low = std::min(low, least[static_cast<std::size_t>(x)]);
      sum += low <= limit;
      sums_[offset(bx + 1, by + 1, columns_)] = sums_[offset(bx + 1, by, columns_)] + sum;
    }
  }
}

SilhouetteMap::SilhouetteMap(const codec::CameraView& view, int alpha_threshold, double dilation_px)
    : camera_(view.estimate),
      rotation_(view.estimate.cam_from_world.rotation.toRotationMatrix()),
      dilation_px_(dilation_px) {
  const image::Matte& matte = *view.matte;
  const int width = matte.alpha.width();
  const int height = matte.alpha.height();
  const double fold = camera_.model.fold_radius_squared();
  fold_radius_squared_ =
      static_cast<float>(std::min(fold, static_cast<double>(std::numeric_limits<float>::max())));
  foreground_ = image::Image<std::uint8_t>(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* alpha = matte.alpha.row(y);
    std::uint8_t* out = foreground_.row(y);
    unsigned count = 0;
    for (int x = 0; x < width; ++x) {
      const bool set = alpha[x] >= alpha_threshold;
      out[x] = set ? 255 : 0;
      count += set;
    }
    foreground_px_ += count;
  }
  seen_ = banded_distance(foreground_, reach());
  seen_blocks_ = BlockCount(seen_, block_limit());

  image::Image<std::uint8_t> possible = foreground_;
  std::uint8_t any_unknown = 0;
  for (const image::Image<std::uint8_t>* extra : {&matte.unknown, &matte.occluders}) {
    if (extra->width() != width || extra->height() != height) continue;
    for (std::size_t i = 0; i < possible.size(); ++i) {
      const std::uint8_t set = extra->data()[i] ? 255 : 0;
      possible.data()[i] |= set;
      any_unknown |= set;
    }
  }
  if (any_unknown) {
    possible_ = banded_distance(possible, reach());
    possible_blocks_ = BlockCount(possible_, block_limit());
  } else {
    possible_blocks_ = seen_blocks_;
  }
}

int SilhouetteMap::reach() const {
  return std::min(15, static_cast<int>(std::ceil(dilation_px_)) + 4);
}

std::uint8_t SilhouetteMap::block_limit() const {
  // A sample is interpolated between pixels, hence one more than the dilation.
  return static_cast<std::uint8_t>(
      std::min(254.0, std::ceil((dilation_px_ + 0.5 + 1) / static_cast<double>(kDistanceStep))));
}

void SilhouetteMap::set_unexplained(const image::Image<std::uint8_t>& mask) {
  unexplained_ = banded_distance(mask, reach());
  unexplained_blocks_ = BlockCount(unexplained_, block_limit());
}

bool SilhouetteMap::may_be_unexplained(const BoxFootprint& box) const {
  if (unexplained_.empty() || box.place == BoxPlace::kOutside) return false;
  return unexplained_blocks_.any(box.x0, box.y0, box.x1, box.y1);
}

void SilhouetteMap::measure_unexplained_row(int count, const float* u, const float* v,
                                            const float* z, float* unexplained) const {
  const auto bound = static_cast<float>(dilation_px_ + 0.5);
  const auto per_focal = static_cast<float>(1 / camera_.model.fx);
  for (int i = 0; i < count; ++i) {
    unexplained[i] = z[i] <= 0 || unexplained_.empty()
                         ? -std::numeric_limits<float>::infinity()
                         : (bound - sample(unexplained_, u[i], v[i])) * z[i] * per_focal;
  }
}

BoxFootprint SilhouetteMap::footprint(const Eigen::Vector3d& low,
                                      const Eigen::Vector3d& high) const {
  const geometry::CameraModel& model = camera_.model;
  const Eigen::Vector3d base = in_cam(low);
  const Eigen::Vector3d extent = high - low;
  double u0 = std::numeric_limits<double>::infinity();
  double v0 = u0;
  double u1 = -u0;
  double v1 = -u0;
  int behind = 0;
  int folded = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d p = base;
    if (corner & 1) p += rotation_.col(0) * extent.x();
    if (corner & 2) p += rotation_.col(1) * extent.y();
    if (corner & 4) p += rotation_.col(2) * extent.z();
    if (p.z() < 0.05) {
      ++behind;
      continue;
    }
    const double x = p.x() / p.z();
    const double y = p.y() / p.z();
    const double r2 = x * x + y * y;
    if (r2 >= fold_radius_squared_) {
      ++folded;
      continue;
    }
    const double d = 1 + r2 * (model.k1 + model.k2 * r2);
    const double u = model.fx * d * x + model.cx;
    const double v = model.fy * d * y + model.cy;
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
  BoxFootprint box;
  if (behind == 8 || folded == 8) return box;
  if (behind + folded > 0) {
    box = {BoxPlace::kPartly, 0, 0, model.width - 1, model.height - 1};
    return box;
  }
  // The lens bends the box's edges: by far less than this share of its size.
  const double slack = 1.5 + 0.02 * std::max(u1 - u0, v1 - v0);
  u0 -= slack;
  v0 -= slack;
  u1 += slack;
  v1 += slack;
  if (u1 < -0.5 || v1 < -0.5 || u0 >= model.width - 0.5 || v0 >= model.height - 0.5) return box;
  const bool inside = u0 >= -0.5 && v0 >= -0.5 && u1 < model.width - 0.5 && v1 < model.height - 0.5;
  box.place = inside ? BoxPlace::kInside : BoxPlace::kPartly;
  // Clipped before they become integers: beside a camera they can be huge.
  const auto clip = [](double pixel, int size) {
    return static_cast<int>(std::clamp(pixel, 0.0, static_cast<double>(size - 1)));
  };
  box.x0 = clip(std::floor(u0), model.width);
  box.y0 = clip(std::floor(v0), model.height);
  box.x1 = clip(std::ceil(u1), model.width);
  box.y1 = clip(std::ceil(v1), model.height);
  return box;
}

bool SilhouetteMap::may_hold(const BoxFootprint& box) const {
  if (box.place != BoxPlace::kInside) return true;
  // Within the dilation of the border nothing is carved.
  const int band = static_cast<int>(std::ceil(dilation_px_ + 1));
  if (box.x0 <= band || box.y0 <= band || box.x1 >= camera_.model.width - 1 - band ||
      box.y1 >= camera_.model.height - 1 - band) {
    return true;
  }
  return possible_blocks_.any(box.x0, box.y0, box.x1, box.y1);
}

bool SilhouetteMap::may_support(const BoxFootprint& box) const {
  if (box.place == BoxPlace::kOutside) return false;
  return seen_blocks_.any(box.x0, box.y0, box.x1, box.y1);
}

bool SilhouetteMap::may_be_foreground(const BoxFootprint& box) const {
  if (box.place == BoxPlace::kOutside) return false;
  return possible_blocks_.any(box.x0, box.y0, box.x1, box.y1);
}

void SilhouetteMap::project_row(const Eigen::Vector3d& start_in_cam,
                                const Eigen::Vector3d& step_in_cam, int count, float* u, float* v,
                                float* z) const {
  const geometry::CameraModel& model = camera_.model;
  const auto sx = static_cast<float>(start_in_cam.x());
  const auto sy = static_cast<float>(start_in_cam.y());
  const auto sz = static_cast<float>(start_in_cam.z());
  const auto dx = static_cast<float>(step_in_cam.x());
  const auto dy = static_cast<float>(step_in_cam.y());
  const auto dz = static_cast<float>(step_in_cam.z());
  const auto fx = static_cast<float>(model.fx);
  const auto fy = static_cast<float>(model.fy);
  const auto cx = static_cast<float>(model.cx);
  const auto cy = static_cast<float>(model.cy);
  const auto k1 = static_cast<float>(model.k1);
  const auto k2 = static_cast<float>(model.k2);
  const float right = static_cast<float>(model.width) - 0.5F;
  const float bottom = static_cast<float>(model.height) - 0.5F;
  for (int i = 0; i < count; ++i) {
    const auto t = static_cast<float>(i);
    const float depth = sz + t * dz;
    const float scale = 1 / std::max(depth, 0.05F);
    const float x = (sx + t * dx) * scale;
    const float y = (sy + t * dy) * scale;
    const float r2 = x * x + y * y;
    const float d = 1 + r2 * (k1 + k2 * r2);
    const float pu = fx * d * x + cx;
    const float pv = fy * d * y + cy;
    const bool sees = (depth > 0.05F) & (r2 < fold_radius_squared_) & (pu >= -0.5F) &
                      (pv >= -0.5F) & (pu < right) & (pv < bottom);
    u[i] = pu;
    v[i] = pv;
    z[i] = sees ? depth : 0;
  }
}

float SilhouetteMap::sample(const image::Image<std::uint8_t>& map, float u, float v) const {
  const int x = std::clamp(static_cast<int>(u), 0, map.width() - 2);
  const int y = std::clamp(static_cast<int>(v), 0, map.height() - 2);
  const float a = std::clamp(u - static_cast<float>(x), 0.0F, 1.0F);
  const float b = std::clamp(v - static_cast<float>(y), 0.0F, 1.0F);
  const std::uint8_t* p = map.row(y) + x;
  const std::uint8_t* q = p + map.stride();
  const auto p0 = static_cast<float>(p[0]);
  const auto q0 = static_cast<float>(q[0]);
  const float top = p0 + a * (static_cast<float>(p[1]) - p0);
  const float low = q0 + a * (static_cast<float>(q[1]) - q0);
  return (top + b * (low - top)) * kDistanceStep;
}

void SilhouetteMap::measure_row(int count, const float* u, const float* v, const float* z,
                                float* possible, float* support, float* seen) const {
  // The silhouette's boundary runs half a pixel beyond the centres of its outermost pixels.
  const auto bound = static_cast<float>(dilation_px_ + 0.5);
  const auto per_focal = static_cast<float>(1 / camera_.model.fx);
  const auto right = static_cast<float>(camera_.model.width);
  const auto bottom = static_cast<float>(camera_.model.height);
  constexpr float kInfinite = std::numeric_limits<float>::infinity();
  for (int i = 0; i < count; ++i) {
    if (z[i] <= 0) {
      possible[i] = kInfinite;
      support[i] = -kInfinite;
      seen[i] = -kInfinite;
      continue;
    }
    const float metres = z[i] * per_focal;
    const float to_seen = sample(seen_, u[i], v[i]);
    const float to_foreground = possible_.empty() ? to_seen : sample(possible_, u[i], v[i]);
    // Whatever is outside the picture may be foreground.
    const float border =
        std::min(std::min(u[i] + 1, right - u[i]), std::min(v[i] + 1, bottom - v[i]));
    const float to_possible = std::min(to_foreground, border);
    seen[i] = (bound - to_seen) * metres;
    support[i] = (bound - to_foreground) * metres;
    possible[i] = (bound - to_possible) * metres;
  }
}

}  // namespace touchline::hull
