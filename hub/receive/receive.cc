#include "hub/receive/receive.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

namespace touchline::receive {
namespace {

using base::ErrorKind;

// Media times beyond this (the year 2096) are no times; arithmetic on them stays within 64 bits.
constexpr std::int64_t kMaxTimeNs = 4'000'000'000'000'000'000;
constexpr double kUnitLengthSlack = 1e-3;

// Collects the first fault of a message, named by camera and field.
class Checker {
 public:
  explicit Checker(const std::string& camera) : camera_(camera) {
    if (!base::is_valid(base::CameraId{camera})) {
      camera_ = "camera";
      fault(ErrorKind::kFormat, fmt::format("an id of {} characters is none", camera.size()));
    }
  }

  void require(bool condition, std::string_view field, double value, std::string_view bound) {
    if (!condition) fault(ErrorKind::kFormat, fmt::format("{} {} is not {}", field, value, bound));
  }
  void require_size(std::string_view field, std::size_t size, std::size_t most) {
    if (size > most) fault(ErrorKind::kLimit, fmt::format("{} {} is above {}", field, size, most));
  }
  void within(std::string_view field, double value, double least, double most) {
    // Written so that a NaN fails.
    if (!(value >= least && value <= most)) {
      fault(ErrorKind::kFormat,
            fmt::format("{} {} is outside {} to {}", field, value, least, most));
    }
  }
  void fault(ErrorKind kind, std::string what) {
    if (!error_) error_ = base::Error{kind, camera_, std::move(what), {}};
  }
  const std::optional<base::Error>& error() const { return error_; }

 private:
  std::string camera_;
  std::optional<base::Error> error_;
};

base::FrameStamp to_stamp(const wire::StampFields& fields, Checker& check) {
  base::FrameStamp stamp;
  if (fields.media_time_ns < -kMaxTimeNs || fields.media_time_ns > kMaxTimeNs) {
    check.fault(ErrorKind::kFormat,
                fmt::format("media time {} ns is beyond the calendar", fields.media_time_ns));
  }
  if (fields.uncertainty_ns < 0 || fields.uncertainty_ns > kMaxTimeNs) {
    check.fault(ErrorKind::kFormat,
                fmt::format("time uncertainty {} ns is no width", fields.uncertainty_ns));
  }
  check.within("clock domain", fields.domain, 0,
               static_cast<double>(base::ClockDomain::kRecording));
  stamp.media_time.ns = fields.media_time_ns;
  stamp.uncertainty_ns = fields.uncertainty_ns;
  stamp.domain = static_cast<base::ClockDomain>(fields.domain);
  if (fields.has_timecode) {
    check.within("timecode hours", fields.hours, 0, 23);
    check.within("timecode minutes", fields.minutes, 0, 59);
    check.within("timecode seconds", fields.seconds, 0, 59);
    check.within("timecode frames", fields.frames, 0, 239);
    stamp.timecode = base::Timecode{fields.hours, fields.minutes, fields.seconds, fields.frames,
                                    fields.drop_frame};
  }
  return stamp;
}

geometry::CameraModel to_model(const wire::EstimateFields& fields, const ReceiveLimits& limits,
                               bool lost, Checker& check) {
  geometry::CameraModel model;
  const auto& [width, height, fx, fy, cx, cy, k1, k2] = fields.model;
  check.within("width", width, 1, limits.max_width);
  check.within("height", height, 1, limits.max_height);
  check.require(width == std::floor(width), "width", width, "whole");
  check.require(height == std::floor(height), "height", height, "whole");
  if (check.error()) return model;
  model.width = static_cast<int>(width);
  model.height = static_cast<int>(height);
  const bool finite = std::all_of(fields.model.begin(), fields.model.end(),
                                  [](double value) { return std::isfinite(value); });
  if (lost && (!finite || fx <= 0 || fy <= 0)) return model;
  if (!lost || finite) {
    model.fx = fx;
    model.fy = fy;
    model.cx = cx;
    model.cy = cy;
    model.k1 = k1;
    model.k2 = k2;
  }
  if (lost) return model;
  check.within("fx", fx, 1, limits.max_focal_px);
  check.within("fy", fy, 1, limits.max_focal_px);
  check.within("cx", cx, -width, 2 * width);
  check.within("cy", cy, -height, 2 * height);
  check.within("k1", k1, -1e3, 1e3);
  check.within("k2", k2, -1e6, 1e6);
  return model;
}

geometry::Rigid3 to_pose(const wire::EstimateFields& fields, const ReceiveLimits& limits, bool lost,
                         Checker& check) {
  geometry::Rigid3 pose;
  const auto& [qw, qx, qy, qz, tx, ty, tz] = fields.pose;
  const bool finite = std::all_of(fields.pose.begin(), fields.pose.end(),
                                  [](double value) { return std::isfinite(value); });
  const double length = std::sqrt(qw * qw + qx * qx + qy * qy + qz * qz);
  const bool unit = finite && std::abs(length - 1) <= kUnitLengthSlack;
  if (!unit) {
    if (!lost) check.require(false, "length of the quaternion", length, "1");
    return pose;
  }
  pose.rotation = Eigen::Quaterniond(qw, qx, qy, qz).normalized();
  pose.translation = {tx, ty, tz};
  const Eigen::Vector3d position = geometry::origin(pose);
  const bool near = position.cwiseAbs().maxCoeff() <= limits.max_distance_m;
  if (!near && lost) return geometry::Rigid3{};
  check.require(near, "distance of the camera", position.norm(),
                fmt::format("within {} m", limits.max_distance_m));
  return pose;
}

void read_covariance(const wire::EstimateFields& fields, bool lost,
                     geometry::CameraEstimate& estimate, Checker& check) {
  Eigen::Matrix<double, 9, 9> covariance;
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column) {
      covariance(row, column) = fields.covariance[static_cast<std::size_t>(9 * row + column)];
    }
  }
  if (lost) {
    if (covariance.allFinite()) estimate.covariance = covariance;
    return;
  }
  for (int row = 0; row < 9; ++row) {
    check.within("variance", covariance(row, row), 0, 1e12);
    for (int column = 0; column < row; ++column) {
      const double value = covariance(row, column);
      const double scale = std::sqrt(covariance(row, row) * covariance(column, column));
      check.within("covariance", value, -1e12, 1e12);
      check.require(std::abs(value - covariance(column, row)) <= 1e-6 * scale + 1e-12, "covariance",
                    value, "symmetric");
      check.require(std::abs(value) <= scale * (1 + 1e-6) + 1e-12, "covariance", value,
                    "within its variances");
    }
  }
  estimate.covariance = 0.5 * (covariance + covariance.transpose());
}

geometry::CameraEstimate to_estimate(const wire::EstimateFields& fields,
                                     const ReceiveLimits& limits, Checker& check) {
  geometry::CameraEstimate estimate;
  check.within("evidence", fields.evidence, 0, static_cast<double>(geometry::Evidence::kPeers));
  if (check.error()) return estimate;
  estimate.evidence = static_cast<geometry::Evidence>(fields.evidence);
  const bool lost = estimate.lost();
  estimate.model = to_model(fields, limits, lost, check);
  if (check.error()) return estimate;
  estimate.cam_from_world = to_pose(fields, limits, lost, check);
  read_covariance(fields, lost, estimate, check);
  if (!lost) check.within("rms_px", fields.rms_px, 0, 1e6);
  if (std::isfinite(fields.rms_px) && fields.rms_px >= 0) estimate.rms_px = fields.rms_px;
  return estimate;
}

std::string printable(const std::string& text) {
  std::string clean = text;
  for (char& c : clean) {
    const auto code = static_cast<unsigned char>(c);
    if (code < 0x20 || code == 0x7F) c = ' ';
  }
  return clean;
}

}  // namespace

base::Result<codec::EncodedView> to_view(wire::FrameMessage message, const ReceiveLimits& limits) {
  Checker check(message.camera);
  codec::EncodedView view;
  view.id = {base::CameraId{message.camera}, message.epoch, message.sequence};
  view.stamp = to_stamp(message.stamp, check);
  view.estimate = to_estimate(message.estimate, limits, check);
  check.require_size("number of parts", message.parts.size(), wire::kMaxParts);
  if (check.error()) return base::fail(*check.error());
  for (wire::Part& part : message.parts) {
    const auto kind = static_cast<codec::PartKind>(part.kind);
    if (kind != codec::PartKind::kMatte && kind != codec::PartKind::kPartial &&
        kind != codec::PartKind::kTiles) {
      check.fault(ErrorKind::kUnsupported, fmt::format("a part of kind {} is unknown", part.kind));
      break;
    }
    if (view.find(kind) != nullptr) {
      check.fault(ErrorKind::kFormat,
                  fmt::format("part \"{}\" comes twice in one frame", codec::name(kind)));
      break;
    }
    check.require_size(fmt::format("size of part \"{}\"", codec::name(kind)), part.bytes.size(),
                       limits.max_part_bytes);
    view.parts.push_back({kind, part.version, std::move(part.bytes)});
  }
  if (check.error()) return base::fail(*check.error());
  return view;
}

base::Result<codec::EncodedPlateTile> to_plate_tile(wire::PlateMessage message,
                                                    const ReceiveLimits& limits) {
  Checker check(message.camera);
  check.within("plate column", message.column, -limits.max_plate_index, limits.max_plate_index);
  check.within("plate row", message.row, -limits.max_plate_index, limits.max_plate_index);
  check.within("radians per pixel", message.radians_per_px, 1e-7, 0.1);
  for (const double coordinate : message.centre_in_world) {
    check.within("plate centre", coordinate, -limits.max_distance_m, limits.max_distance_m);
  }
  check.require_size("size of a plate tile", message.bytes.size(), limits.max_plate_bytes);
  if (check.error()) return base::fail(*check.error());
  codec::EncodedPlateTile tile;
  tile.camera.value = std::move(message.camera);
  tile.epoch = message.epoch;
  tile.plate_version = message.plate_version;
  tile.key = {message.column, message.row};
  tile.radians_per_px = message.radians_per_px;
  tile.centre_in_world = {message.centre_in_world[0], message.centre_in_world[1],
                          message.centre_in_world[2]};
  tile.format_version = message.format_version;
  tile.bytes = std::move(message.bytes);
  return tile;
}

base::Result<UnitStatus> to_status(const wire::StatusMessage& message) {
  Checker check(message.camera);
  UnitStatus status;
  status.camera.value = message.camera;
  status.epoch = message.epoch;
  switch (message.state) {
    case wire::UnitState::kStarting:
      status.state = UnitState::kStarting;
      break;
    case wire::UnitState::kRunning:
      status.state = UnitState::kRunning;
      break;
    case wire::UnitState::kEnded:
      status.state = UnitState::kEnded;
      break;
    case wire::UnitState::kFailed:
      status.state = UnitState::kFailed;
      break;
    default:
      check.fault(ErrorKind::kFormat, "the unit's state is unknown");
  }
  check.require_size("number of stages", message.stages.size(), wire::kMaxListEntries);
  check.require_size("number of drop reasons", message.drops.size(), wire::kMaxListEntries);
  check.require_size("length of the source", message.source.size(), wire::kMaxSourceChars);
  check.require_size("length of the text", message.text.size(), wire::kMaxTextChars);
  if (check.error()) return base::fail(*check.error());
  status.source = printable(message.source);
  status.text = printable(message.text);
  for (const wire::StageRate& rate : message.stages) {
    check.require_size("length of a stage's name", rate.stage.size(), wire::kMaxNameChars);
    check.within("stage rate", rate.hz, 0, 1e6);
    check.within("stage time", rate.mean_ms, 0, 1e9);
    status.stages.push_back({printable(rate.stage), rate.hz, rate.mean_ms});
  }
  for (const wire::DropCount& drop : message.drops) {
    check.require_size("length of a drop reason", drop.reason.size(), wire::kMaxNameChars);
    status.drops[printable(drop.reason)] += drop.count;
  }
  status.frames_read = message.frames_read;
  status.frames_sent = message.frames_sent;
  // Empty: the unit has not looked at a frame yet.
  status.calibration = geometry::Evidence::kLost;
  bool known = message.calibration.empty();
  for (const geometry::Evidence evidence :
       {geometry::Evidence::kLost, geometry::Evidence::kLines, geometry::Evidence::kPlate,
        geometry::Evidence::kEncoder, geometry::Evidence::kPeers}) {
    if (geometry::name(evidence) == message.calibration) {
      status.calibration = evidence;
      known = true;
    }
  }
  if (!known) check.fault(ErrorKind::kFormat, "the calibration's state is unknown");
  if (check.error()) return base::fail(*check.error());
  return status;
}

}  // namespace touchline::receive
