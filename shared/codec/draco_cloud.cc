#include <draco/compression/decode.h>
#include <draco/compression/expert_encode.h>
#include <draco/core/decoder_buffer.h>
#include <draco/core/encoder_buffer.h>
#include <draco/point_cloud/point_cloud.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>

#include "shared/codec/byte_stream.h"
#include "shared/codec/draco_cloud_internal.h"

namespace touchline::codec {
namespace {

using base::ErrorKind;

constexpr int kSpeed = 3;

// How a stream with these columns begins: Draco's header (bitstream 2.3, point cloud, sequential,
// no metadata), the number of points, one group of attributes with their types, one integer
// decoder each.
std::vector<std::uint8_t> header(std::size_t points, const std::vector<Column>& columns) {
  ByteWriter out;
  for (const char letter : {'D', 'R', 'A', 'C', 'O'}) out.put(letter);
  for (const int value : {2, 3, 0, 0, 0, 0}) out.put(static_cast<std::uint8_t>(value));
  out.put(static_cast<std::uint32_t>(points));
  out.put(std::uint8_t{1});
  out.put(static_cast<std::uint8_t>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) {
    out.put(static_cast<std::uint8_t>(draco::GeometryAttribute::GENERIC));
    out.put(static_cast<std::uint8_t>(draco::DT_INT32));
    out.put(static_cast<std::uint8_t>(columns[i].components));
    out.put(std::uint8_t{0});
    out.put(static_cast<std::uint8_t>(i));
  }
  for (std::size_t i = 0; i < columns.size(); ++i) out.put(std::uint8_t{1});
  return out.take();
}

bool begins_with(std::span<const std::uint8_t> bytes, const std::vector<std::uint8_t>& start) {
  return bytes.size() >= start.size() && std::equal(start.begin(), start.end(), bytes.begin());
}

std::vector<std::uint8_t> encode(const std::vector<Column>& columns, std::size_t points,
                                 std::string& error) {
  draco::PointCloudBuilder builder;
  builder.Start(static_cast<std::uint32_t>(points));
  for (const Column& column : columns) {
    const int id =
        builder.AddAttribute(draco::GeometryAttribute::GENERIC,
                             static_cast<std::int8_t>(column.components), draco::DT_INT32);
    builder.SetAttributeValuesForAllPoints(id, column.values.data(), 0);
  }
  const std::unique_ptr<draco::PointCloud> cloud = builder.Finalize(false);
  draco::ExpertEncoder encoder(*cloud);
  encoder.SetEncodingMethod(draco::POINT_CLOUD_SEQUENTIAL_ENCODING);  // keeps the order
  encoder.SetSpeedOptions(kSpeed, kSpeed);
  draco::EncoderBuffer buffer;
  const draco::Status status = encoder.EncodeToBuffer(&buffer);
  if (!status.ok()) {
    error = status.error_msg_string();
    return {};
  }
  return {buffer.data(), buffer.data() + buffer.size()};
}

bool read_column(const draco::PointAttribute& attribute, std::size_t points, Column& column) {
  const auto n = static_cast<std::size_t>(column.components);
  column.values.resize(points * n);
  for (std::size_t i = 0; i < points; ++i) {
    const auto at = attribute.mapped_index(draco::PointIndex(static_cast<std::uint32_t>(i)));
    if (at.value() >= attribute.size()) return false;
    attribute.GetValue(at, column.values.data() + i * n);
  }
  return true;
}

bool decode(std::span<const std::uint8_t> bytes, std::size_t points, std::vector<Column>& columns,
            std::string& error) {
  draco::DecoderBuffer buffer;
  const std::vector<char> copy(bytes.begin(), bytes.end());
  buffer.Init(copy.data(), copy.size());
  draco::Decoder decoder;
  auto result = decoder.DecodePointCloudFromBuffer(&buffer);
  if (!result.ok()) {
    error = result.status().error_msg_string();
    return false;
  }
  const std::unique_ptr<draco::PointCloud> cloud = std::move(result).value();
  if (!cloud || cloud->num_points() != points ||
      cloud->num_attributes() != static_cast<int>(columns.size())) {
    error = "other points or attributes than announced";
    return false;
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    Column& column = columns[i];
    const draco::PointAttribute& attribute = *cloud->attribute(static_cast<int>(i));
    if (attribute.num_components() != column.components ||
        attribute.data_type() != draco::DT_INT32) {
      error = "an attribute of another type than announced";
      return false;
    }
    if (!read_column(attribute, points, column)) {
      error = "a value missing";
      return false;
    }
  }
  return true;
}

}  // namespace

base::Result<std::vector<std::uint8_t>> encode_cloud(const std::vector<Column>& columns) {
  const std::size_t points =
      columns.front().values.size() / static_cast<std::size_t>(columns.front().components);
  try {
    std::string error;
    std::vector<std::uint8_t> bytes = encode(columns, points, error);
    if (bytes.empty()) return base::fail(ErrorKind::kInternal, "draco", error);
    if (!begins_with(bytes, header(points, columns))) {
      return base::fail(ErrorKind::kUnsupported, "draco",
                        "this Draco library writes another bitstream than 2.3",
                        "use the Draco of the supported system");
    }
    return bytes;
  } catch (const std::exception& e) {
    return base::fail(ErrorKind::kInternal, "draco", e.what());
  }
}

base::Status decode_cloud(std::span<const std::uint8_t> bytes, std::size_t points,
                          std::vector<Column>& columns) {
  if (!begins_with(bytes, header(points, columns))) {
    return base::fail(ErrorKind::kFormat, "draco", "other header than announced");
  }
  try {
    std::string error;
    if (!decode(bytes, points, columns, error)) {
      return base::fail(ErrorKind::kFormat, "draco", error);
    }
    return {};
  } catch (const std::exception& e) {
    return base::fail(ErrorKind::kFormat, "draco", e.what());
  }
}

}  // namespace touchline::codec
