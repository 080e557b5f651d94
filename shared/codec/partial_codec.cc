#include "shared/codec/partial_codec.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "shared/codec/byte_stream.h"
#include "shared/codec/draco_cloud_internal.h"

// Version 1: numbers of vertices, rings and features (32 bits each), bytes a descriptor (16),
// tolerance in steps (32), then for each of the three that is not zero a Draco cloud with its
// length (32), then the descriptors as they are. Vertices: x, y. Rings: number of vertices, hole,
// near, far. Features: x, y, scale, angle.

namespace touchline::codec {
namespace {

using base::ErrorKind;
using geometry::Feature;
using geometry::Partial;
using geometry::SilhouettePolygon;

constexpr double kMaxPosition = 32768;
constexpr double kMaxDepth = 10'000;
constexpr double kMaxScale = 4096;
constexpr std::size_t kMaxFeatures = 200;

base::Error wrong(std::string what) {
  return {ErrorKind::kArgument, "partial", std::move(what), {}};
}

bool in_range(double value, double low, double high) { return value >= low && value <= high; }

std::int32_t steps(double value, double step) {
  return static_cast<std::int32_t>(std::lround(value / step));
}
// Down or up to the next step, unless it is on one already but for rounding.
std::int32_t steps_down(double value, double step) {
  const double n = value / step;
  const double nearest = std::round(n);
  return static_cast<std::int32_t>(std::abs(n - nearest) < 1e-3 ? nearest : std::floor(n));
}
std::int32_t steps_up(double value, double step) { return -steps_down(-value, step); }

base::Result<bool> put_position(const Eigen::Vector2f& position, std::vector<std::int32_t>& out) {
  bool on_grid = true;
  for (const float value : {position.x(), position.y()}) {
    if (!in_range(value, -kMaxPosition, kMaxPosition)) {
      return base::fail(wrong(fmt::format("position {} outside +-{} px", value, kMaxPosition)));
    }
    const std::int32_t n = steps(value, kPartialPositionStep);
    on_grid &= static_cast<float>(n) * kPartialPositionStep == value;
    out.push_back(n);
  }
  return on_grid;
}

Eigen::Vector2f position_at(const std::vector<std::int32_t>& values, std::size_t at) {
  return Eigen::Vector2f(static_cast<float>(values[at]), static_cast<float>(values[at + 1])) *
         kPartialPositionStep;
}

base::Status check_polygon(const SilhouettePolygon& polygon) {
  if (polygon.ring.size() < 3) {
    return base::fail(wrong(fmt::format("a ring of {} vertices", polygon.ring.size())));
  }
  if (!in_range(polygon.near_m, 0, kMaxDepth) || !in_range(polygon.far_m, 0, kMaxDepth) ||
      polygon.near_m > polygon.far_m) {
    return base::fail(wrong(fmt::format("depths {} to {} m, 0 to {} allowed", polygon.near_m,
                                        polygon.far_m, kMaxDepth)));
  }
  return {};
}

base::Status put_features(const std::vector<Feature>& features, Column& numbers) {
  for (const Feature& feature : features) {
    if (feature.descriptor.size() != features.front().descriptor.size() ||
        feature.descriptor.size() > kMaxDescriptorBytes) {
      return base::fail(wrong(fmt::format(
          "a descriptor of {} bytes beside one of {}, at most {}", feature.descriptor.size(),
          features.front().descriptor.size(), kMaxDescriptorBytes)));
    }
    if (!in_range(feature.scale, 0, kMaxScale) || !std::isfinite(feature.angle) ||
        std::abs(feature.angle) > 1e6f) {
      return base::fail(
          wrong(fmt::format("feature scale {}, angle {}", feature.scale, feature.angle)));
    }
    if (const auto put = put_position(feature.position, numbers.values); !put) {
      return base::fail(put.error());
    }
    numbers.values.push_back(steps(feature.scale, kPartialScaleStep));
    const std::int32_t turn =
        steps(feature.angle, 2 * std::numbers::pi / kPartialAngleSteps) % kPartialAngleSteps;
    numbers.values.push_back(turn < 0 ? turn + kPartialAngleSteps : turn);
  }
  return {};
}

base::Status put_cloud(ByteWriter& out, const Column& column) {
  const auto bytes = encode_cloud({column});
  if (!bytes) return base::fail(bytes.error());
  out.put(static_cast<std::uint32_t>(bytes->size()));
  out.put_bytes(*bytes);
  return {};
}

base::Result<Column> get_cloud(ByteReader& in, std::size_t points, int components) {
  const std::span<const std::uint8_t> bytes = in.get_bytes(in.get<std::uint32_t>());
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, "partial", "ends inside a Draco cloud");
  std::vector<Column> columns{{components, {}}};
  if (const base::Status status = decode_cloud(bytes, points, columns); !status) {
    return base::fail(status.error());
  }
  return std::move(columns.front());
}

base::Error damaged(std::string what) {
  return {ErrorKind::kFormat, "partial", std::move(what), {}};
}

base::Status get_polygons(const Column& vertices, const Column& rings, Partial& partial) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < rings.values.size(); i += 4) {
    const std::int32_t size = rings.values[i];
    const std::int32_t hole = rings.values[i + 1];
    const std::int32_t near = rings.values[i + 2];
    const std::int32_t far = rings.values[i + 3];
    if (size < 3 || static_cast<std::size_t>(size) > vertices.values.size() / 2 - next) {
      return base::fail(damaged("a ring with too few or too many vertices"));
    }
    if (hole < 0 || hole > 1 || near < 0 || near > far ||
        far > static_cast<std::int32_t>(kMaxDepth / kPartialDepthStep) + 1) {
      return base::fail(damaged("a ring with impossible depths"));
    }
    SilhouettePolygon polygon;
    polygon.hole = hole == 1;
    polygon.near_m = static_cast<float>(near) * kPartialDepthStep;
    polygon.far_m = static_cast<float>(far) * kPartialDepthStep;
    for (std::int32_t v = 0; v < size; ++v, ++next) {
      polygon.ring.push_back(position_at(vertices.values, 2 * next));
    }
    partial.polygons.push_back(std::move(polygon));
  }
  if (next != vertices.values.size() / 2) return base::fail(damaged("vertices without a ring"));
  return {};
}

base::Status get_features(const Column& numbers, ByteReader& in, std::size_t descriptor_bytes,
                          Partial& partial) {
  for (std::size_t i = 0; i < numbers.values.size(); i += 4) {
    Feature feature;
    feature.position = position_at(numbers.values, i);
    const std::int32_t scale = numbers.values[i + 2];
    const std::int32_t turn = numbers.values[i + 3];
    if (!in_range(scale, 0, kMaxScale / kPartialScaleStep) ||
        !in_range(turn, 0, kPartialAngleSteps - 1)) {
      return base::fail(damaged("a feature with an impossible scale or angle"));
    }
    feature.scale = static_cast<float>(scale) * kPartialScaleStep;
    const std::int32_t signed_turn =
        turn > kPartialAngleSteps / 2 ? turn - kPartialAngleSteps : turn;
    feature.angle = static_cast<float>(signed_turn * 2 * std::numbers::pi / kPartialAngleSteps);
    const std::span<const std::uint8_t> descriptor = in.get_bytes(descriptor_bytes);
    if (!in.ok()) return base::fail(ErrorKind::kTruncated, "partial", "ends inside a descriptor");
    feature.descriptor.assign(descriptor.begin(), descriptor.end());
    partial.features.push_back(std::move(feature));
  }
  return {};
}

// Of the first two components.
bool positions_in_range(const Column& column) {
  const auto stride = static_cast<std::size_t>(column.components);
  const auto most = static_cast<std::int32_t>(kMaxPosition / kPartialPositionStep);
  for (std::size_t i = 0; i < column.values.size(); i += stride) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (column.values[i + k] < -most || column.values[i + k] > most) return false;
    }
  }
  return true;
}

}  // namespace

base::Result<std::vector<std::uint8_t>> encode_partial(const Partial& partial) {
  Column vertices{2, {}};
  Column rings{4, {}};
  bool on_grid = true;
  for (const SilhouettePolygon& polygon : partial.polygons) {
    if (const base::Status status = check_polygon(polygon); !status) {
      return base::fail(status.error());
    }
    rings.values.push_back(static_cast<std::int32_t>(polygon.ring.size()));
    rings.values.push_back(polygon.hole ? 1 : 0);
    rings.values.push_back(steps_down(polygon.near_m, kPartialDepthStep));
    rings.values.push_back(steps_up(polygon.far_m, kPartialDepthStep));
    for (const Eigen::Vector2f& vertex : polygon.ring) {
      const auto put = put_position(vertex, vertices.values);
      if (!put) return base::fail(put.error());
      on_grid &= *put;
    }
  }
  if (partial.features.size() > kMaxFeatures) {
    return base::fail(wrong(
        fmt::format("{} features, at most {} allowed", partial.features.size(), kMaxFeatures)));
  }
  const std::size_t descriptor_bytes =
      partial.features.empty() ? 0 : partial.features.front().descriptor.size();
  Column numbers{4, {}};
  if (const base::Status status = put_features(partial.features, numbers); !status) {
    return base::fail(status.error());
  }
  if (!in_range(partial.tolerance_px, 0, kMaxPosition)) {
    return base::fail(wrong(fmt::format("tolerance {} px", partial.tolerance_px)));
  }
  const double rounding = on_grid ? 0 : kPartialPositionStep / 2 * std::numbers::sqrt2;

  ByteWriter out;
  out.put(static_cast<std::uint32_t>(vertices.values.size() / 2));
  out.put(static_cast<std::uint32_t>(partial.polygons.size()));
  out.put(static_cast<std::uint32_t>(partial.features.size()));
  out.put(static_cast<std::uint16_t>(descriptor_bytes));
  out.put(
      static_cast<std::uint32_t>(steps_up(partial.tolerance_px + rounding, kPartialToleranceStep)));
  for (Column* column : {&vertices, &rings, &numbers}) {
    if (column->values.empty()) continue;
    if (const base::Status status = put_cloud(out, *column); !status) {
      return base::fail(status.error());
    }
  }
  for (const Feature& feature : partial.features) out.put_bytes(feature.descriptor);
  return out.take();
}

base::Result<Partial> decode_partial(std::span<const std::uint8_t> bytes, std::uint16_t version,
                                     const DecodeLimits& limits) {
  if (version != kPartialVersion) {
    return base::fail(
        ErrorKind::kUnsupported, "partial",
        fmt::format("format version {}, this program reads {}", version, kPartialVersion),
        "update the older of edge and hub");
  }
  const auto beyond = [](std::string_view what, std::size_t n, std::size_t most) {
    return base::fail(ErrorKind::kLimit, "partial",
                      fmt::format("{} {}, at most {} allowed", n, what, most));
  };
  if (bytes.size() > limits.max_part_bytes) {
    return beyond("bytes", bytes.size(), limits.max_part_bytes);
  }
  ByteReader in(bytes);
  const std::size_t vertex_count = in.get<std::uint32_t>();
  const std::size_t ring_count = in.get<std::uint32_t>();
  const std::size_t feature_count = in.get<std::uint32_t>();
  const std::size_t descriptor_bytes = in.get<std::uint16_t>();
  const auto tolerance = in.get<std::uint32_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, "partial", "ends inside its header");
  if (vertex_count > limits.max_vertices) {
    return beyond("vertices", vertex_count, limits.max_vertices);
  }
  if (ring_count > limits.max_polygons) return beyond("polygons", ring_count, limits.max_polygons);
  if (feature_count > limits.max_features) {
    return beyond("features", feature_count, limits.max_features);
  }
  if (descriptor_bytes > kMaxDescriptorBytes) {
    return beyond("bytes a descriptor", descriptor_bytes, kMaxDescriptorBytes);
  }
  if (vertex_count < 3 * ring_count || (ring_count == 0 && vertex_count > 0)) {
    return base::fail(damaged("vertices and rings disagree"));
  }
  if (tolerance > kMaxPosition / kPartialToleranceStep) {
    return base::fail(damaged("impossible tolerance"));
  }

  Partial partial;
  partial.tolerance_px = static_cast<float>(tolerance) * kPartialToleranceStep;
  if (ring_count > 0) {
    const auto vertices = get_cloud(in, vertex_count, 2);
    if (!vertices) return base::fail(vertices.error());
    const auto rings = get_cloud(in, ring_count, 4);
    if (!rings) return base::fail(rings.error());
    if (!positions_in_range(*vertices)) return base::fail(damaged("impossible position"));
    const base::Status status = get_polygons(*vertices, *rings, partial);
    if (!status) return base::fail(status.error());
  }
  if (feature_count > 0) {
    const auto numbers = get_cloud(in, feature_count, 4);
    if (!numbers) return base::fail(numbers.error());
    if (!positions_in_range(*numbers)) return base::fail(damaged("impossible position"));
    const base::Status status = get_features(*numbers, in, descriptor_bytes, partial);
    if (!status) return base::fail(status.error());
  }
  if (in.remaining() != 0) return base::fail(damaged("bytes after its end"));
  return partial;
}

}  // namespace touchline::codec
