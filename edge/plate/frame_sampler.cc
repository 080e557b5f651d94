#include "edge/plate/frame_sampler.h"

#include <immintrin.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>

#include "shared/image/no_picture.h"

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

// Eight positions at a time.
constexpr int kLanes = 8;

struct Places {
  alignas(32) std::array<std::int32_t, kLanes> index;

  Places(__m256i row, __m256i column, std::ptrdiff_t stride) {
    const __m256i at = _mm256_add_epi32(
        _mm256_mullo_epi32(row, _mm256_set1_epi32(static_cast<int>(stride))), column);
    _mm256_store_si256(reinterpret_cast<__m256i*>(index.data()), at);
  }
};

// A sample and its right neighbour at each place.
__m256i pairs_at(const std::uint16_t* data, const Places& at) {
  const auto pair = [&](std::size_t i) {
    std::int32_t both;
    std::memcpy(&both, data + at.index[i], sizeof both);
    return both;
  };
  return _mm256_setr_epi32(pair(0), pair(1), pair(2), pair(3), pair(4), pair(5), pair(6), pair(7));
}
__m256i joined(__m256i low, __m256i high) {
  return _mm256_or_si256(_mm256_and_si256(low, _mm256_set1_epi32(0xffff)),
                         _mm256_slli_epi32(high, 16));
}
__m256 times(__m256 a, __m256 b) { return _mm256_mul_ps(a, b); }
__m256 all(float v) { return _mm256_set1_ps(v); }

// Where four places lie side by side in a row, in both halves of eight: a window of eight samples
// for each half, and which pair of them each place takes.
class Windows {
 public:
  // `back`: samples before a place that the window begins.
  Windows(__m256i row, __m256i column, const Plane& p, int back) {
    const __m256i base = _mm256_shuffle_epi32(column, 0);
    const __m256i off = _mm256_sub_epi32(column, base);
    const __m256i one_row = _mm256_cmpeq_epi32(row, _mm256_shuffle_epi32(row, 0));
    const __m256i close = _mm256_and_si256(_mm256_cmpgt_epi32(off, _mm256_set1_epi32(-1)),
                                           _mm256_cmpgt_epi32(_mm256_set1_epi32(5), off));
    const int low = _mm256_extract_epi32(column, 0) - back;
    const int high = _mm256_extract_epi32(column, 4) - back;
    fit_ = _mm256_movemask_epi8(_mm256_and_si256(one_row, close)) == -1 &&
           std::max(low, high) + 8 <= p.width;
    low_ = (_mm256_extract_epi32(row, 0) - back) * p.stride + low;
    high_ = (_mm256_extract_epi32(row, 4) - back) * p.stride + high;
    pairs_ = _mm256_add_epi32(_mm256_mullo_epi32(off, _mm256_set1_epi32(0x02020202)),
                              _mm256_set1_epi32(0x03020100));
  }
  bool fit() const { return fit_; }
  // `from`: the plane's first sample, some rows on.
  __m256i row(const std::uint16_t* from) const {
    return _mm256_set_m128i(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from + high_)),
                            _mm_loadu_si128(reinterpret_cast<const __m128i*>(from + low_)));
  }
  // The sample of each place of such a row with its right neighbour, and the two after these.
  __m256i pair(__m256i row) const { return _mm256_shuffle_epi8(row, pairs_); }
  __m256i next_pair(__m256i row) const {
    return _mm256_shuffle_epi8(row, _mm256_add_epi32(pairs_, _mm256_set1_epi32(0x04040404)));
  }

 private:
  bool fit_;
  std::ptrdiff_t low_;
  std::ptrdiff_t high_;
  __m256i pairs_;
};

// As bicubic(), with weights in 1/8192; positions at least a sample inside, two at right and
// bottom.
__m256 bicubic8(const Plane& p, __m256 x, __m256 y) {
  const __m256i ix = _mm256_cvttps_epi32(x);
  const __m256i iy = _mm256_cvttps_epi32(y);
  const __m256 fx = _mm256_sub_ps(x, _mm256_cvtepi32_ps(ix));
  const __m256 fy = _mm256_sub_ps(y, _mm256_cvtepi32_ps(iy));
  struct Weights {
    __m256 before, next, last;  // the second is what they lack of 1
  };
  const auto weights = [](__m256 f) {
    const __m256 half = all(0.5f);
    const __m256 f2 = times(f, f);
    const __m256 before =
        times(f, _mm256_fmadd_ps(f, _mm256_fnmadd_ps(half, f, all(1.f)), all(-0.5f)));
    const __m256 next =
        times(f, _mm256_fmadd_ps(f, _mm256_fnmadd_ps(all(1.5f), f, all(2.f)), half));
    return Weights{before, next, times(times(half, f2), _mm256_sub_ps(f, all(1.f)))};
  };
  const Weights wx = weights(fx);
  const Weights wy = weights(fy);
  const __m256 scale = all(8192.f);
  const __m256i a = _mm256_cvtps_epi32(times(wx.before, scale));
  const __m256i c = _mm256_cvtps_epi32(times(wx.next, scale));
  const __m256i d = _mm256_cvtps_epi32(times(wx.last, scale));
  const __m256i b =
      _mm256_sub_epi32(_mm256_set1_epi32(8192), _mm256_add_epi32(a, _mm256_add_epi32(c, d)));
  const __m256i left = joined(a, b);
  const __m256i right = joined(c, d);
  const __m256 second =
      _mm256_sub_ps(all(1.f), _mm256_add_ps(wy.before, _mm256_add_ps(wy.next, wy.last)));
  const __m256 rows[4] = {wy.before, second, wy.next, wy.last};
  __m256 sum = _mm256_setzero_ps();
  const auto finished = [&] {
    sum = times(sum, all(1.f / 8192));
    return _mm256_min_ps(_mm256_max_ps(sum, _mm256_setzero_ps()), all(1023.f));
  };
  const std::uint16_t* from = p.data;
  const Windows windows(iy, ix, p, 1);
  if (windows.fit()) {
    for (const __m256& row : rows) {
      const __m256i samples = windows.row(from);
      const __m256i across = _mm256_add_epi32(_mm256_madd_epi16(windows.pair(samples), left),
                                              _mm256_madd_epi16(windows.next_pair(samples), right));
      sum = _mm256_fmadd_ps(row, _mm256_cvtepi32_ps(across), sum);
      from += p.stride;
    }
    return finished();
  }
  // Four weights a pixel, of pixels 0 1 4 5 and of 2 3 6 7.
  const __m256i outer = _mm256_unpacklo_epi32(left, right);
  const __m256i inner = _mm256_unpackhi_epi32(left, right);
  Places at(_mm256_sub_epi32(iy, _mm256_set1_epi32(1)), _mm256_sub_epi32(ix, _mm256_set1_epi32(1)),
            p.stride);
  for (const __m256& row : rows) {
    const auto quads = [&](std::size_t i, std::size_t j) {
      return _mm_unpacklo_epi64(
          _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from + at.index[i])),
          _mm_loadl_epi64(reinterpret_cast<const __m128i*>(from + at.index[j])));
    };
    const __m256i across =
        _mm256_hadd_epi32(_mm256_madd_epi16(_mm256_set_m128i(quads(4, 5), quads(0, 1)), outer),
                          _mm256_madd_epi16(_mm256_set_m128i(quads(6, 7), quads(2, 3)), inner));
    sum = _mm256_fmadd_ps(row, _mm256_cvtepi32_ps(across), sum);
    from += p.stride;
  }
  return finished();
}

// Where bilinear() looks, for both planes of chroma.
class ChromaPlaces {
 public:
  ChromaPlaces(const Plane& p, __m256 x, __m256 y)
      : ChromaPlaces(p, _mm256_cvttps_epi32(row_of(p, y)), times(x, all(p.scale_x)), row_of(p, y)) {
  }
  __m256 value(const Plane& p) const {
    const std::uint16_t* below = p.data + p.stride;
    const bool fit = windows_.fit();
    const __m256i a = fit ? windows_.pair(windows_.row(p.data)) : pairs_at(p.data, at_);
    const __m256i b = fit ? windows_.pair(windows_.row(below)) : pairs_at(below, at_);
    const __m256 top = _mm256_cvtepi32_ps(_mm256_madd_epi16(a, across_));
    const __m256 bottom = _mm256_cvtepi32_ps(_mm256_madd_epi16(b, across_));
    return times(_mm256_fmadd_ps(down_, _mm256_sub_ps(bottom, top), top), all(1.f / 8192));
  }

 private:
  static __m256 row_of(const Plane& p, __m256 y) {
    return _mm256_max_ps(_mm256_fmadd_ps(y, all(p.scale_y), all(p.shift_y)), _mm256_setzero_ps());
  }
  ChromaPlaces(const Plane& p, __m256i row, __m256 x, __m256 y)
      : windows_(row, _mm256_cvttps_epi32(x), p, 0), at_(row, _mm256_cvttps_epi32(x), p.stride) {
    const __m256 fx = _mm256_sub_ps(x, _mm256_round_ps(x, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC));
    const __m256i f = _mm256_cvtps_epi32(times(fx, all(8192.f)));
    across_ = joined(_mm256_sub_epi32(_mm256_set1_epi32(8192), f), f);
    down_ = _mm256_sub_ps(y, _mm256_round_ps(y, _MM_FROUND_TO_ZERO | _MM_FROUND_NO_EXC));
  }

  Windows windows_;
  Places at_;       // where the windows do not fit
  __m256i across_;  // weights in 1/8192
  __m256 down_;
};

// Rounded to the nearest, half upwards.
void store8(__m256 values, std::uint16_t* to) {
  const __m256i whole = _mm256_cvttps_epi32(_mm256_add_ps(values, all(0.5f)));
  const __m256i packed = _mm256_permute4x64_epi64(_mm256_packus_epi32(whole, whole), 0x08);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_castsi256_si128(packed));
}

// Asks for samples that a row below will need: rows are too far apart for the processor to guess.
constexpr float kAhead = 8;
void fetch(const Plane& p, float x, float y) {
  const int ix = std::clamp(static_cast<int>(x * p.scale_x), 0, p.width - 1);
  const int iy = std::clamp(static_cast<int>(y * p.scale_y), 0, p.height - 1);
  _mm_prefetch(reinterpret_cast<const char*>(p.data + iy * p.stride + ix), _MM_HINT_T0);
}

bool between(float a, float b, float low, float high) {
  return std::min(a, b) >= low && std::max(a, b) <= high;
}

Eigen::Vector2d tile_corner(const image::PlateTileKey& key) {
  return {static_cast<double>(image::kPlateTileSize) * key.column,
          static_cast<double>(image::kPlateTileSize) * key.row};
}

}  // namespace

std::uint64_t nodes_in_view(const image::PlateSnapshot& sphere, const image::PlateTileKey& key,
                            const geometry::CameraEstimate& camera, double margin_px) {
  std::uint64_t nodes = 0;
  for (int i = 0; i < kViewNodes * kViewNodes; ++i) {
    const Eigen::Vector2d place(i % kViewNodes, i / kViewNodes);
    const auto pixel = camera.model.project(
        camera.cam_from_world.rotation *
        image::direction_from_plate(
            sphere, tile_corner(key) + place * (image::kPlateTileSize / (kViewNodes - 1.0))));
    if (pixel && pixel->x() >= -margin_px && pixel->y() >= -margin_px &&
        pixel->x() <= camera.model.width - 1 + margin_px &&
        pixel->y() <= camera.model.height - 1 + margin_px)
      nodes |= std::uint64_t{1} << i;
  }
  return nodes;
}

std::vector<image::PlateTileKey> touched_tiles(const image::PlateSnapshot& sphere,
                                               const geometry::CameraEstimate& camera, int most) {
  constexpr int kPixels = 64;
  const double turn = std::numbers::pi / sphere.radians_per_px;
  // Plate pixels between two of the rays below, with room for distortion.
  const double reach = 0.75 * kPixels / (camera.model.fx * sphere.radians_per_px);
  std::vector<image::PlateTileKey> keys;
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
          const image::PlateTileKey key{
              static_cast<std::int32_t>(std::floor(u / image::kPlateTileSize)),
              static_cast<std::int32_t>(std::floor((p.y() + dy) / image::kPlateTileSize))};
          if (std::find(keys.rbegin(), keys.rend(), key) == keys.rend()) keys.push_back(key);
        }
      if (static_cast<int>(keys.size()) > most) return {};
    }
  std::sort(keys.begin(), keys.end());
  return keys;
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
  out.top = size;
  out.bottom = 0;

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
  const float first = std::max(low, 1.f);
  const float right = static_cast<float>(frame.width() - 1 - border) - 0.001f;
  const float bottom = static_cast<float>(frame.height() - 1 - border) - 0.001f;
  for (int y = 0; y < size; ++y) {
    const int j = y / kStep;
    const float t = static_cast<float>(y - j * kStep) / kStep;
    const int before = out.seen;
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
      fetch(luma, xa, ya + kAhead);
      fetch(blue, xa, ya + kAhead);
      fetch(red, xa, ya + kAhead);
      const auto start = static_cast<std::size_t>(y) * static_cast<std::size_t>(size) +
                         static_cast<std::size_t>(i * kStep);
      int k = 0;
      if (between(xa, xb, first, right - 2) && between(ya, yb, first, bottom - 2)) {
        const __m256 lanes = _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7);
        for (; k + kLanes <= end; k += kLanes) {
          const __m256 along = _mm256_add_ps(lanes, all(static_cast<float>(k)));
          const __m256 px = _mm256_fmadd_ps(along, all(dx), all(xa));
          const __m256 py = _mm256_fmadd_ps(along, all(dy), all(ya));
          const auto at = start + static_cast<std::size_t>(k);
          const __m256 value = bicubic8(luma, px, py);
          store8(_mm256_add_ps(value, value), &out.y[at]);
          const ChromaPlaces chroma(blue, px, py);
          store8(chroma.value(blue), &out.cb[at]);
          store8(chroma.value(red), &out.cr[at]);
          std::memset(&out.inside[at], 1, kLanes);
          out.seen += kLanes;
        }
      }
      for (; k < end; ++k) {
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
    if (out.seen == before) continue;
    out.top = std::min(out.top, y);
    out.bottom = y + 1;
  }
  const auto row = static_cast<std::size_t>(size);
  const auto end = static_cast<std::size_t>(out.bottom) * row;
  for (std::size_t at = static_cast<std::size_t>(out.top) * row; at < end; ++at) {
    if (!image::no_picture(out.cb[at], out.cr[at])) continue;
    out.seen -= out.inside[at];
    out.inside[at] = 0;
  }
}

}  // namespace touchline::plate
