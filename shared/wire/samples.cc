#include <fmt/format.h>

#include <utility>

#include "shared/wire/bounds.h"
#include "shared/wire/samples_internal.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;

base::Status check_schema(std::uint16_t schema) {
  if (schema != kSchemaVersion) {
    return base::fail(
        ErrorKind::kUnsupported, "wire",
        fmt::format("a sample of schema {}; this program speaks schema {}", schema, kSchemaVersion),
        "run the same release on units and hub");
  }
  return {};
}

}  // namespace

void to_sample(const FrameMessage& message, idl::Frame& sample) {
  sample.schema(kSchemaVersion);
  sample.camera() = message.camera;
  sample.epoch(message.epoch);
  sample.sequence_number(message.sequence);
  idl::Stamp& stamp = sample.stamp();
  stamp.media_time_ns(message.stamp.media_time_ns);
  stamp.uncertainty_ns(message.stamp.uncertainty_ns);
  stamp.domain(message.stamp.domain);
  stamp.has_timecode(message.stamp.has_timecode);
  stamp.drop_frame(message.stamp.drop_frame);
  stamp.hours(message.stamp.hours);
  stamp.minutes(message.stamp.minutes);
  stamp.seconds(message.stamp.seconds);
  stamp.frames(message.stamp.frames);
  sample.estimate().model(message.estimate.model);
  sample.estimate().pose(message.estimate.pose);
  sample.estimate().covariance(message.estimate.covariance);
  sample.estimate().rms_px(message.estimate.rms_px);
  sample.estimate().evidence(message.estimate.evidence);
  sample.parts().resize(message.parts.size());
  for (std::size_t i = 0; i < message.parts.size(); ++i) {
    sample.parts()[i].kind(message.parts[i].kind);
    sample.parts()[i].version(message.parts[i].version);
    sample.parts()[i].bytes(message.parts[i].bytes);
  }
}

void to_sample(const PlateMessage& message, idl::Plate& sample) {
  sample.schema(kSchemaVersion);
  sample.camera() = message.camera;
  sample.epoch(message.epoch);
  sample.plate_version(message.plate_version);
  sample.column(message.column);
  sample.row(message.row);
  sample.radians_per_px(message.radians_per_px);
  sample.centre(message.centre_in_world);
  sample.format_version(message.format_version);
  sample.bytes(message.bytes);
}

void to_sample(const UnitReport& report, idl::Status& sample) {
  sample.schema(report.schema);
  sample.camera() = report.status.camera;
  sample.epoch(report.status.epoch);
  sample.mode(static_cast<std::uint8_t>(report.mode));
  sample.state(static_cast<std::uint8_t>(report.status.state));
  sample.source() = report.status.source;
  sample.stages().resize(report.status.stages.size());
  for (std::size_t i = 0; i < report.status.stages.size(); ++i) {
    sample.stages()[i].stage() = report.status.stages[i].stage;
    sample.stages()[i].hz(report.status.stages[i].hz);
    sample.stages()[i].mean_ms(report.status.stages[i].mean_ms);
  }
  sample.drops().resize(report.status.drops.size());
  for (std::size_t i = 0; i < report.status.drops.size(); ++i) {
    sample.drops()[i].reason() = report.status.drops[i].reason;
    sample.drops()[i].count(report.status.drops[i].count);
  }
  sample.frames_read(report.status.frames_read);
  sample.frames_sent(report.status.frames_sent);
  sample.calibration() = report.status.calibration;
  sample.text() = report.status.text;
  sample.end().clear();
  if (report.end) {
    idl::Counts counts;
    counts.frames(report.end->frames_sent);
    counts.plates(report.end->plates_sent);
    sample.end().push_back(counts);
  }
}

idl::Command to_sample(const Reply& reply) {
  idl::Command sample;
  sample.schema(kSchemaVersion);
  sample.unit(reply.unit);
  sample.camera() = reply.camera;
  sample.epoch(reply.epoch);
  sample.kind(static_cast<std::uint8_t>(reply.kind));
  sample.credit_bytes(reply.credit_bytes);
  sample.text() = reply.text;
  return sample;
}

idl::Command to_sample(const Reply& address, const CommandMessage& message) {
  idl::Command sample = to_sample(address);
  sample.kind(static_cast<std::uint8_t>(kFirstCommandKind + static_cast<int>(message.kind)));
  sample.text() = message.text;
  return sample;
}

void to_sample(const PeopleMessage& message, idl::People& sample) {
  sample.schema(kSchemaVersion);
  sample.camera() = message.camera;
  sample.media_time_ns(message.media_time_ns);
  sample.domain(message.domain);
  sample.places().resize(message.places.size());
  for (std::size_t i = 0; i < message.places.size(); ++i) {
    sample.places()[i].x(message.places[i].x);
    sample.places()[i].y(message.places[i].y);
    sample.places()[i].sd_m(message.places[i].sd_m);
  }
}

base::Result<FrameMessage> from_sample(idl::Frame& sample) {
  if (auto ok = check_schema(sample.schema()); !ok) return base::fail(ok.error());
  FrameMessage message;
  message.camera = sample.camera().to_string();
  message.epoch = sample.epoch();
  message.sequence = sample.sequence_number();
  const idl::Stamp& stamp = sample.stamp();
  message.stamp = {stamp.media_time_ns(), stamp.uncertainty_ns(), stamp.domain(),
                   stamp.has_timecode(),  stamp.drop_frame(),     stamp.hours(),
                   stamp.minutes(),       stamp.seconds(),        stamp.frames()};
  message.estimate.model = sample.estimate().model();
  message.estimate.pose = sample.estimate().pose();
  message.estimate.covariance = sample.estimate().covariance();
  message.estimate.rms_px = sample.estimate().rms_px();
  message.estimate.evidence = sample.estimate().evidence();
  message.parts.reserve(sample.parts().size());
  for (idl::Part& part : sample.parts()) {
    message.parts.push_back({part.kind(), part.version(), std::move(part.bytes())});
  }
  if (auto ok = check_bounds(message); !ok) return base::fail(ok.error());
  return message;
}

base::Result<PlateMessage> from_sample(idl::Plate& sample) {
  if (auto ok = check_schema(sample.schema()); !ok) return base::fail(ok.error());
  PlateMessage message;
  message.camera = sample.camera().to_string();
  message.epoch = sample.epoch();
  message.plate_version = sample.plate_version();
  message.column = sample.column();
  message.row = sample.row();
  message.radians_per_px = sample.radians_per_px();
  message.centre_in_world = sample.centre();
  message.format_version = sample.format_version();
  message.bytes = std::move(sample.bytes());
  if (auto ok = check_bounds(message); !ok) return base::fail(ok.error());
  return message;
}

base::Result<UnitReport> from_sample(const idl::Status& sample) {
  UnitReport report;
  report.schema = sample.schema();
  report.status.camera = sample.camera().to_string();
  if (report.schema != kSchemaVersion) return report;
  if (sample.mode() > static_cast<std::uint8_t>(Mode::kReplay) ||
      sample.state() > static_cast<std::uint8_t>(UnitState::kFailed)) {
    return base::fail(
        ErrorKind::kFormat, report.status.camera,
        fmt::format("mode {} or state {} of a status is unknown", sample.mode(), sample.state()));
  }
  report.mode = static_cast<Mode>(sample.mode());
  StatusMessage& status = report.status;
  status.epoch = sample.epoch();
  status.state = static_cast<UnitState>(sample.state());
  status.source = sample.source().to_string();
  for (const idl::StageRate& rate : sample.stages()) {
    status.stages.push_back({rate.stage().to_string(), rate.hz(), rate.mean_ms()});
  }
  for (const idl::DropCount& drop : sample.drops()) {
    status.drops.push_back({drop.reason().to_string(), drop.count()});
  }
  status.frames_read = sample.frames_read();
  status.frames_sent = sample.frames_sent();
  status.calibration = sample.calibration().to_string();
  status.text = sample.text().to_string();
  if (!sample.end().empty()) {
    report.end = EndOfStream{status.camera, status.epoch, sample.end().front().frames(),
                             sample.end().front().plates()};
  }
  if (auto ok = check_bounds(status); !ok) return base::fail(ok.error());
  return report;
}

base::Result<PeopleMessage> from_sample(const idl::People& sample) {
  if (auto ok = check_schema(sample.schema()); !ok) return base::fail(ok.error());
  PeopleMessage message;
  message.camera = sample.camera().to_string();
  message.media_time_ns = sample.media_time_ns();
  message.domain = sample.domain();
  for (const idl::Place& place : sample.places()) {
    message.places.push_back({place.x(), place.y(), place.sd_m()});
  }
  if (auto ok = check_bounds(message); !ok) return base::fail(ok.error());
  return message;
}

}  // namespace touchline::wire
