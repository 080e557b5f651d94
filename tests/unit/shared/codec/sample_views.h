// Small views with everything in them, the same in every run, for tests of codecs and sessions.
#pragma once

#include <cmath>
#include <cstdint>

#include "shared/codec/camera_view.h"
#include "shared/image/plate_snapshot.h"

namespace touchline::samples {

// A generator that gives the same numbers with any library.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed * 2 + 1) {}
  std::uint32_t next() {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(state_ >> 33);
  }
  int below(int n) { return static_cast<int>(next() % static_cast<std::uint32_t>(n)); }

 private:
  std::uint64_t state_;
};

// Soft-edged discs, with an unknown band under some and an occluder through the picture.
inline image::Matte matte(int width, int height, std::uint64_t seed) {
  Numbers numbers(seed);
  image::Matte out;
  out.region = {0, 0, width, height};
  out.alpha = image::Image<std::uint8_t>(width, height);
  out.unknown = image::Image<std::uint8_t>(width, height);
  out.occluders = image::Image<std::uint8_t>(width, height);
  out.plate_version = numbers.next() % 1000;
  for (int i = 0; i < 4; ++i) {
    const int cx = numbers.below(width);
    const int cy = numbers.below(height);
    const int r = 2 + numbers.below(height / 4 + 1);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double d = std::hypot(x - cx, y - cy);
        const auto a =
            static_cast<int>(std::lround(255 * std::min(1.0, std::max(0.0, r - d + 0.5))));
        if (a > out.alpha(x, y)) out.alpha(x, y) = static_cast<std::uint8_t>(a);
        if (i == 0 && d >= r && d < r + 2 && y > cy) out.unknown(x, y) = 255;
      }
    }
  }
  const int post = numbers.below(width);
  for (int y = height / 3; y < height; ++y) {
    out.occluders(post, y) = 255;
    out.unknown(post, y) = 255;
  }
  return out;
}

// Any values that a matte may hold, without structure.
inline image::Matte noise_matte(int width, int height, std::uint64_t seed) {
  Numbers numbers(seed);
  image::Matte out = matte(width, height, seed);
  for (std::size_t i = 0; i < out.alpha.size(); ++i) {
    out.alpha.data()[i] = static_cast<std::uint8_t>(numbers.below(256));
    out.unknown.data()[i] = numbers.below(3) == 0 ? 255 : 0;
    out.occluders.data()[i] = numbers.below(5) == 0 ? 255 : 0;
  }
  return out;
}

inline geometry::Partial partial(std::uint64_t seed) {
  Numbers numbers(seed);
  geometry::Partial out;
  out.tolerance_px = 0.25f;
  for (int i = 0; i < 3; ++i) {
    geometry::SilhouettePolygon polygon;
    const int n = 3 + numbers.below(20);
    for (int k = 0; k < n; ++k) {
      // Braces: the numbers are drawn from left to right by every compiler.
      polygon.ring.push_back(Eigen::Vector2f{static_cast<float>(numbers.below(20000)) / 11 - 3,
                                             static_cast<float>(numbers.below(12000)) / 11 - 3});
    }
    polygon.hole = i == 2;
    polygon.near_m = static_cast<float>(numbers.below(5000)) / 77;
    polygon.far_m = polygon.near_m + static_cast<float>(numbers.below(5000)) / 77;
    out.polygons.push_back(polygon);
  }
  for (int i = 0; i < 7; ++i) {
    geometry::Feature feature;
    feature.position = {static_cast<float>(numbers.below(20000)) / 11,
                        static_cast<float>(numbers.below(12000)) / 11};
    feature.scale = 31;
    feature.angle = static_cast<float>(numbers.below(628)) / 100 - 3.14f;
    for (int k = 0; k < 32; ++k) {
      feature.descriptor.push_back(static_cast<std::uint8_t>(numbers.below(256)));
    }
    out.features.push_back(feature);
  }
  return out;
}

inline codec::TextureTile tile(image::Rect place, std::uint64_t seed) {
  Numbers numbers(seed);
  codec::TextureTile out{place, image::Image<image::Rgb8>(place.width, place.height)};
  const int phase = numbers.below(100);
  for (int y = 0; y < place.height; ++y) {
    for (int x = 0; x < place.width; ++x) {
      const auto wave = [&](int a) {
        return static_cast<std::uint8_t>(128 + 90 * std::sin((x * a + y * 3 + phase) * 0.02));
      };
      out.pixels(x, y) = {wave(2), wave(3), wave(5)};
    }
  }
  return out;
}

inline codec::CameraView view(const std::string& camera, std::uint64_t sequence) {
  codec::CameraView out;
  out.id = {{camera}, 1, sequence};
  out.stamp.media_time.ns = static_cast<std::int64_t>(sequence) * 40'000'000;
  out.stamp.domain = base::ClockDomain::kRecording;
  out.stamp.timecode = base::Timecode{10, 0, 0, static_cast<int>(sequence % 25), false};
  out.estimate.model = {64, 48, 80, 80, 31.5, 23.5, -0.1, 0.01};
  out.estimate.cam_from_world.translation = {1, 2, 3};
  out.estimate.covariance.setIdentity();
  out.estimate.evidence = geometry::Evidence::kLines;
  out.estimate.rms_px = 0.25;
  out.matte = matte(64, 48, sequence + 7);
  out.partial = partial(sequence + 7);
  out.tiles = std::vector<codec::TextureTile>{tile({8, 8, 24, 16}, sequence),
                                              tile({40, 16, 16, 32}, sequence + 1)};
  return out;
}

inline image::PlateTile plate_tile(std::uint64_t seed) {
  Numbers numbers(seed);
  image::PlateTile out;
  const int n = image::kPlateTileSize;
  out.count = image::Image<std::uint8_t>(n, n);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    out.mean[channel] = image::Image<std::uint16_t>(n, n);
    out.deviation[channel] = image::Image<std::uint16_t>(n, n);
  }
  const int edge = 20 + numbers.below(200);
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      if (x + y / 2 < edge) continue;
      out.count(x, y) = static_cast<std::uint8_t>(1 + (x / 50 + y / 70) * 9);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double wave = std::sin(0.03 * (x + 2 * y) + static_cast<double>(channel));
        out.mean[channel](x, y) = static_cast<std::uint16_t>(8000 + 3000 * wave);
      }
    }
  }
  return out;
}

}  // namespace touchline::samples
