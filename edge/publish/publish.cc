#include "edge/publish/publish.h"

#include <algorithm>
#include <string>

#include "shared/geometry/camera_estimate.h"

namespace touchline::publish {
namespace {

// At most `most` bytes, without a NUL and without cutting a UTF-8 character in two.
std::string cut(const std::string& text, std::size_t most) {
  std::size_t size = std::min(text.size(), text.find('\0'));
  if (size > most) {
    size = most;
    while (size > 0 && (static_cast<unsigned char>(text[size]) & 0xC0u) == 0x80u) --size;
  }
  return text.substr(0, size);
}

wire::StampFields stamp_fields(const base::FrameStamp& stamp) {
  wire::StampFields fields;
  fields.media_time_ns = stamp.media_time.ns;
  fields.uncertainty_ns = stamp.uncertainty_ns;
  fields.domain = static_cast<std::uint8_t>(stamp.domain);
  if (stamp.timecode) {
    fields.has_timecode = true;
    fields.drop_frame = stamp.timecode->drop_frame;
    fields.hours = static_cast<std::uint8_t>(stamp.timecode->hours);
    fields.minutes = static_cast<std::uint8_t>(stamp.timecode->minutes);
    fields.seconds = static_cast<std::uint8_t>(stamp.timecode->seconds);
    fields.frames = static_cast<std::uint8_t>(stamp.timecode->frames);
  }
  return fields;
}

wire::EstimateFields estimate_fields(const geometry::CameraEstimate& estimate) {
  wire::EstimateFields fields;
  const geometry::CameraModel& model = estimate.model;
  fields.model = {static_cast<double>(model.width),
                  static_cast<double>(model.height),
                  model.fx,
                  model.fy,
                  model.cx,
                  model.cy,
                  model.k1,
                  model.k2};
  const geometry::Rigid3& pose = estimate.cam_from_world;
  fields.pose = {pose.rotation.w(),    pose.rotation.x(),    pose.rotation.y(),   pose.rotation.z(),
                 pose.translation.x(), pose.translation.y(), pose.translation.z()};
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      fields.covariance[static_cast<std::size_t>(9 * row + column)] =
          estimate.covariance(row, column);
    }
  }
  fields.rms_px = estimate.rms_px;
  fields.evidence = static_cast<std::uint8_t>(estimate.evidence);
  return fields;
}

}  // namespace

wire::FrameMessage to_message(const codec::EncodedView& view) {
  wire::FrameMessage message;
  message.camera = view.id.camera.value;
  message.epoch = view.id.epoch;
  message.sequence = view.id.sequence;
  message.stamp = stamp_fields(view.stamp);
  message.estimate = estimate_fields(view.estimate);
  message.parts.reserve(view.parts.size());
  for (const codec::EncodedPart& part : view.parts) {
    message.parts.push_back({static_cast<std::uint8_t>(part.kind), part.version, part.bytes});
  }
  return message;
}

wire::PlateMessage to_message(const codec::EncodedPlateTile& tile, std::uint32_t epoch) {
  wire::PlateMessage message;
  message.camera = tile.camera.value;
  message.epoch = epoch;
  message.plate_version = tile.plate_version;
  message.column = tile.key.column;
  message.row = tile.key.row;
  message.radians_per_px = tile.radians_per_px;
  message.centre_in_world = {tile.centre_in_world.x(), tile.centre_in_world.y(),
                             tile.centre_in_world.z()};
  message.format_version = tile.format_version;
  message.bytes = tile.bytes;
  return message;
}

wire::StatusMessage to_message(const UnitStatus& status) {
  wire::StatusMessage message;
  message.camera = status.camera.value;
  message.epoch = status.epoch;
  switch (status.state) {
    case UnitState::kStarting:
      message.state = wire::UnitState::kStarting;
      break;
    case UnitState::kRunning:
      message.state = wire::UnitState::kRunning;
      break;
    case UnitState::kEnded:
      message.state = wire::UnitState::kEnded;
      break;
    case UnitState::kFailed:
      message.state = wire::UnitState::kFailed;
      break;
  }
  message.source = cut(status.source, wire::kMaxSourceChars);
  for (const StageRate& rate : status.stages) {
    if (message.stages.size() == wire::kMaxListEntries) break;
    message.stages.push_back({cut(rate.stage, wire::kMaxNameChars), rate.hz, rate.mean_ms});
  }
  for (const auto& [reason, count] : status.drops) {
    if (message.drops.size() == wire::kMaxListEntries) break;
    message.drops.push_back({cut(reason, wire::kMaxNameChars), count});
  }
  message.frames_read = status.frames_read;
  message.frames_sent = status.frames_sent;
  message.calibration = std::string(geometry::name(status.calibration));
  message.text = cut(status.text, wire::kMaxTextChars);
  return message;
}

}  // namespace touchline::publish
