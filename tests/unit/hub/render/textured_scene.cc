#include "tests/unit/hub/render/textured_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "shared/image/colour.h"

namespace touchline::render {

pitch::PitchModel flat_pitch() {
  pitch::PitchModel pitch;
  pitch.length_m = 20;
  pitch.width_m = 14;
  return pitch;
}

Eigen::Vector3d ball_colour(const Ball& ball, const Eigen::Vector3d& point) {
  const Eigen::Vector3d n = (point - ball.centre) / ball.radius;
  const double wave = 0.5 + 0.25 * std::sin(9 * n.x()) * std::cos(7 * n.y()) + 0.25 * n.z();
  return ball.colour * (0.5 + 0.5 * wave);
}

Eigen::Vector3d turf_colour(double x, double y) {
  const double stripe = std::sin(1.3 * x) + 0.6 * std::sin(2.1 * y + 0.4 * x);
  return Eigen::Vector3d(60, 120, 50) * (1 + 0.2 * stripe);
}

Drawn draw(std::span<const Ball> balls, const geometry::CameraEstimate& camera, int x, int y) {
  Drawn out;
  constexpr int kRays = 4;
  const Eigen::Vector3d origin = geometry::position_in_world(camera);
  for (int j = 0; j < kRays; ++j) {
    for (int i = 0; i < kRays; ++i) {
      const Eigen::Vector3d ray = geometry::ray_in_world(
          camera, {x + (i + 0.5) / kRays - 0.5, y + (j + 0.5) / kRays - 0.5});
      double nearest = 1e9;
      const Ball* hit = nullptr;
      for (const Ball& ball : balls) {
        const Eigen::Vector3d way = ball.centre - origin;
        const double along = way.dot(ray);
        const double off = way.squaredNorm() - along * along;
        if (along <= 0 || off >= ball.radius * ball.radius) continue;
        const double t = along - std::sqrt(ball.radius * ball.radius - off);
        if (t < nearest) {
          nearest = t;
          hit = &ball;
        }
      }
      if (hit != nullptr) {
        out.colour += ball_colour(*hit, origin + nearest * ray);
        out.coverage += 1;
      } else if (ray.z() < -1e-6) {
        const Eigen::Vector3d p = origin - origin.z() / ray.z() * ray;
        out.colour += turf_colour(p.x(), p.y());
      } else {
        out.colour += Eigen::Vector3d(180, 190, 200);
      }
    }
  }
  out.colour /= kRays * kRays;
  out.coverage /= kRays * kRays;
  return out;
}

codec::CameraView draw_view(const std::string& name, const geometry::CameraEstimate& camera,
                            std::span<const Ball> balls) {
  codec::CameraView view;
  view.id.camera.value = name;
  view.estimate = camera;
  const int width = camera.model.width;
  const int height = camera.model.height;
  image::Matte matte;
  matte.region = {0, 0, width, height};
  matte.alpha = image::Image<std::uint8_t>(width, height);
  matte.unknown = matte.alpha;
  matte.occluders = matte.alpha;
  image::Image<image::Rgb8> picture(width, height);
  const auto byte = [](double v) {
    return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0));
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Drawn drawn = draw(balls, camera, x, y);
      matte.alpha(x, y) = byte(255 * drawn.coverage);
      picture(x, y) = {byte(drawn.colour[0]), byte(drawn.colour[1]), byte(drawn.colour[2])};
    }
  }
  view.matte = std::move(matte);
  view.tiles = std::vector<codec::TextureTile>{{{0, 0, width, height}, std::move(picture)}};
  return view;
}

scene::Hull hull_of(std::span<const Ball> balls, double fat,
                    std::span<const codec::CameraView> views) {
  constexpr int kRings = 24;
  constexpr int kSectors = 48;
  scene::Hull hull;
  for (const Ball& ball : balls) {
    scene::HullGroup group;
    group.id = static_cast<std::uint32_t>(hull.groups.size() + 1);
    const double radius = ball.radius + fat;
    const auto add = [&](double polar, double around) {
      const Eigen::Vector3d p =
          ball.centre + radius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                 std::sin(polar) * std::sin(around),
                                                 std::cos(polar));
      group.bounds.extend(p);
      group.surface.vertices.push_back(p.cast<float>());
    };
    add(0, 0);
    for (int r = 1; r < kRings; ++r) {
      for (int s = 0; s < kSectors; ++s) {
        add(std::numbers::pi * r / kRings, 2 * std::numbers::pi * s / kSectors);
      }
    }
    add(std::numbers::pi, 0);
    const auto at = [&](int r, int s) {
      return static_cast<std::uint32_t>(1 + (r - 1) * kSectors + s % kSectors);
    };
    const auto last = static_cast<std::uint32_t>(group.surface.vertices.size() - 1);
    for (int s = 0; s < kSectors; ++s) {
      group.surface.triangles.push_back({0, at(1, s), at(1, s + 1)});
      group.surface.triangles.push_back({last, at(kRings - 1, s + 1), at(kRings - 1, s)});
      for (int r = 1; r + 1 < kRings; ++r) {
        group.surface.triangles.push_back({at(r, s), at(r + 1, s), at(r + 1, s + 1)});
        group.surface.triangles.push_back({at(r, s), at(r + 1, s + 1), at(r, s + 1)});
      }
    }
    for (const codec::CameraView& view : views) group.support.push_back(view.id.camera);
    hull.groups.push_back(std::move(group));
  }
  return hull;
}

image::PlateSnapshot fill_plate(const Eigen::Vector3d& centre, double radians_per_px,
                                std::span<const image::PlateTileKey> keys,
                                const ColourOfDirection& colour) {
  image::PlateSnapshot plate;
  plate.version = 1;
  plate.centre_in_world = centre;
  plate.radians_per_px = radians_per_px;
  for (const image::PlateTileKey& key : keys) {
    image::PlateTile tile;
    for (std::size_t k = 0; k < 3; ++k) {
      tile.mean[k] = image::Image<std::uint16_t>(image::kPlateTileSize, image::kPlateTileSize);
      tile.deviation[k] = tile.mean[k];
    }
    tile.count = image::Image<std::uint8_t>(image::kPlateTileSize, image::kPlateTileSize);
    bool any = false;
    for (int y = 0; y < image::kPlateTileSize; ++y) {
      for (int x = 0; x < image::kPlateTileSize; ++x) {
        const double u = key.column * image::kPlateTileSize + x;
        const double v = key.row * image::kPlateTileSize + y;
        if (std::abs(u * radians_per_px) > 3.14159265358979) continue;
        Eigen::Vector3d rgb;
        if (!colour(image::direction_from_plate(plate, {u, v}), rgb)) continue;
        const auto code =
            image::rgb_to_ycbcr(static_cast<float>(rgb[0] / 255), static_cast<float>(rgb[1] / 255),
                                static_cast<float>(rgb[2] / 255), plate.colour);
        for (std::size_t k = 0; k < 3; ++k) {
          tile.mean[k](x, y) = static_cast<std::uint16_t>(std::lround(16 * code[k]));
        }
        tile.count(x, y) = 50;
        any = true;
      }
    }
    if (any) plate.tiles.emplace(key, std::move(tile));
  }
  return plate;
}

image::PlateSnapshot draw_plate(const Eigen::Vector3d& centre, double radians_per_px, double reach,
                                const Eigen::Vector3d& gain) {
  image::PlateSnapshot sphere;
  sphere.centre_in_world = centre;
  sphere.radians_per_px = radians_per_px;
  const auto turf_at = [&](const Eigen::Vector3d& direction) -> std::optional<Eigen::Vector2d> {
    if (direction.z() > -1e-6) return std::nullopt;
    const Eigen::Vector3d p = centre - centre.z() / direction.z() * direction;
    if (std::abs(p.x()) > reach || std::abs(p.y()) > reach) return std::nullopt;
    return p.head<2>();
  };
  std::map<image::PlateTileKey, int> keys;
  for (double y = -reach; y <= reach; y += reach / 100) {
    for (double x = -reach; x <= reach; x += reach / 100) {
      const Eigen::Vector2d p =
          image::plate_from_direction(sphere, Eigen::Vector3d(x, y, 0) - centre);
      keys[{static_cast<std::int32_t>(std::floor(p.x() / image::kPlateTileSize)),
            static_cast<std::int32_t>(std::floor(p.y() / image::kPlateTileSize))}] = 1;
    }
  }
  std::vector<image::PlateTileKey> list;
  for (const auto& [key, one] : keys) list.push_back(key);
  return fill_plate(centre, radians_per_px, list,
                    [&](const Eigen::Vector3d& direction, Eigen::Vector3d& rgb) {
                      const auto p = turf_at(direction);
                      if (!p) return false;
                      rgb = turf_colour(p->x(), p->y()).cwiseProduct(gain);
                      return true;
                    });
}

}  // namespace touchline::render
