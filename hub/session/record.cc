#include <fmt/format.h>

#include <cmath>

#include "hub/session/record_internal.h"
#include "shared/codec/byte_stream.h"

// Version 2. A view: version (16 bits), camera, epoch (32), sequence (64), media time (64), clock
// domain (8), uncertainty (64), whether there is a timecode (8) and it, camera model, rotation,
// translation, covariance, evidence (8), rms, number of parts (16), for each kind (8), version
// (16), length (32), then the parts' bytes. A tile: version, camera, epoch (32), plate version
// (32), column (32), row (32), radians a pixel, centre, format version (16), bytes to the end.

namespace touchline::session {
namespace {

using base::ErrorKind;
using codec::ByteReader;
using codec::ByteWriter;

constexpr std::uint16_t kRecordVersion = 2;

void put(ByteWriter& out, const base::FrameStamp& stamp) {
  out.put(stamp.media_time.ns);
  out.put(static_cast<std::uint8_t>(stamp.domain));
  out.put(stamp.uncertainty_ns);
  out.put(static_cast<std::uint8_t>(stamp.timecode ? 1 : 0));
  const base::Timecode code = stamp.timecode.value_or(base::Timecode{});
  for (const int value : {code.hours, code.minutes, code.seconds, code.frames}) {
    out.put(static_cast<std::int32_t>(value));
  }
  out.put(static_cast<std::uint8_t>(code.drop_frame ? 1 : 0));
}

bool get(ByteReader& in, base::FrameStamp& stamp) {
  stamp.media_time.ns = in.get<std::int64_t>();
  const auto domain = in.get<std::uint8_t>();
  stamp.domain = static_cast<base::ClockDomain>(domain);
  stamp.uncertainty_ns = in.get<std::int64_t>();
  const auto has_timecode = in.get<std::uint8_t>();
  base::Timecode code;
  for (int* const value : {&code.hours, &code.minutes, &code.seconds, &code.frames}) {
    *value = in.get<std::int32_t>();
  }
  const auto drop = in.get<std::uint8_t>();
  code.drop_frame = drop != 0;
  if (has_timecode != 0) stamp.timecode = code;
  return domain <= static_cast<std::uint8_t>(base::ClockDomain::kRecording) && has_timecode <= 1 &&
         drop <= 1;
}

void put(ByteWriter& out, const geometry::CameraEstimate& estimate) {
  const geometry::CameraModel& model = estimate.model;
  out.put(static_cast<std::int32_t>(model.width));
  out.put(static_cast<std::int32_t>(model.height));
  for (const double value : {model.fx, model.fy, model.cx, model.cy, model.k1, model.k2}) {
    out.put(value);
  }
  const Eigen::Quaterniond& q = estimate.cam_from_world.rotation;
  for (const double value : {q.w(), q.x(), q.y(), q.z()}) out.put(value);
  for (const double value : estimate.cam_from_world.translation) out.put(value);
  for (const double value : estimate.covariance.reshaped()) out.put(value);
  out.put(static_cast<std::uint8_t>(estimate.evidence));
  out.put(estimate.rms_px);
}

bool get(ByteReader& in, geometry::CameraEstimate& estimate) {
  geometry::CameraModel& model = estimate.model;
  model.width = in.get<std::int32_t>();
  model.height = in.get<std::int32_t>();
  for (double* const value : {&model.fx, &model.fy, &model.cx, &model.cy, &model.k1, &model.k2}) {
    *value = in.get<double>();
  }
  Eigen::Quaterniond& q = estimate.cam_from_world.rotation;
  for (double* const value : {&q.w(), &q.x(), &q.y(), &q.z()}) *value = in.get<double>();
  for (double& value : estimate.cam_from_world.translation) value = in.get<double>();
  for (double& value : estimate.covariance.reshaped()) value = in.get<double>();
  const auto evidence = in.get<std::uint8_t>();
  estimate.evidence = static_cast<geometry::Evidence>(evidence);
  estimate.rms_px = in.get<double>();
  return evidence <= static_cast<std::uint8_t>(geometry::Evidence::kPeers) && model.width >= 0 &&
         model.height >= 0;
}

base::Status check_version(ByteReader& in, const char* where) {
  const auto version = in.get<std::uint16_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, where, "empty");
  if (version != kRecordVersion) {
    return base::fail(
        ErrorKind::kUnsupported, where,
        fmt::format("record format {}, this program reads {}", version, kRecordVersion),
        "use the version of Touchline that wrote it");
  }
  return {};
}

}  // namespace

std::vector<std::uint8_t> pack(const codec::EncodedView& view) {
  ByteWriter out;
  out.put(kRecordVersion);
  out.put_text(view.id.camera.value);
  out.put(view.id.epoch);
  out.put(view.id.sequence);
  put(out, view.stamp);
  put(out, view.estimate);
  out.put(static_cast<std::uint16_t>(view.parts.size()));
  for (const codec::EncodedPart& part : view.parts) {
    out.put(static_cast<std::uint8_t>(part.kind));
    out.put(part.version);
    out.put(static_cast<std::uint32_t>(part.bytes.size()));
  }
  for (const codec::EncodedPart& part : view.parts) out.put_bytes(part.bytes);
  return out.take();
}

std::vector<std::uint8_t> pack(const codec::EncodedPlateTile& tile) {
  ByteWriter out;
  out.put(kRecordVersion);
  out.put_text(tile.camera.value);
  out.put(tile.epoch);
  out.put(tile.plate_version);
  out.put(tile.key.column);
  out.put(tile.key.row);
  out.put(tile.radians_per_px);
  for (const double value : tile.centre_in_world) out.put(value);
  out.put(tile.format_version);
  out.put_bytes(tile.bytes);
  return out.take();
}

base::Result<codec::EncodedView> unpack_view(std::span<const std::uint8_t> bytes) {
  constexpr const char* kWhere = "view record";
  ByteReader in(bytes);
  if (const base::Status status = check_version(in, kWhere); !status) {
    return base::fail(status.error());
  }
  codec::EncodedView view;
  view.id.camera.value = in.get_text();
  view.id.epoch = in.get<std::uint32_t>();
  view.id.sequence = in.get<std::uint64_t>();
  const bool stamp_ok = get(in, view.stamp);
  const bool estimate_ok = get(in, view.estimate);
  const auto count = in.get<std::uint16_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its header");
  if (!stamp_ok || !estimate_ok || !base::is_valid(view.id.camera)) {
    return base::fail(ErrorKind::kFormat, kWhere, "impossible values in its header");
  }
  std::vector<std::size_t> lengths;
  for (int i = 0; i < count; ++i) {
    codec::EncodedPart part;
    part.kind = static_cast<codec::PartKind>(in.get<std::uint8_t>());
    part.version = in.get<std::uint16_t>();
    lengths.push_back(in.get<std::uint32_t>());
    if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its parts");
    view.parts.push_back(std::move(part));
  }
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    const std::span<const std::uint8_t> part = in.get_bytes(lengths[i]);
    if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its parts");
    view.parts[i].bytes.assign(part.begin(), part.end());
  }
  if (in.remaining() != 0) return base::fail(ErrorKind::kFormat, kWhere, "bytes after its end");
  return view;
}

base::Result<codec::EncodedPlateTile> unpack_plate_tile(std::span<const std::uint8_t> bytes) {
  constexpr const char* kWhere = "plate tile record";
  ByteReader in(bytes);
  if (const base::Status status = check_version(in, kWhere); !status) {
    return base::fail(status.error());
  }
  codec::EncodedPlateTile tile;
  tile.camera.value = in.get_text();
  tile.epoch = in.get<std::uint32_t>();
  tile.plate_version = in.get<std::uint32_t>();
  tile.key.column = in.get<std::int32_t>();
  tile.key.row = in.get<std::int32_t>();
  tile.radians_per_px = in.get<double>();
  for (double& value : tile.centre_in_world) value = in.get<double>();
  tile.format_version = in.get<std::uint16_t>();
  if (!in.ok()) return base::fail(ErrorKind::kTruncated, kWhere, "ends inside its header");
  if (!base::is_valid(tile.camera) || !std::isfinite(tile.radians_per_px) ||
      !tile.centre_in_world.allFinite()) {
    return base::fail(ErrorKind::kFormat, kWhere, "impossible values in its header");
  }
  const std::span<const std::uint8_t> rest = in.get_bytes(in.remaining());
  tile.bytes.assign(rest.begin(), rest.end());
  return tile;
}

}  // namespace touchline::session
