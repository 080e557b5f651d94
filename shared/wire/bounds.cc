#include "shared/wire/bounds.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "shared/base/ids.h"

namespace touchline::wire {
namespace {

using base::ErrorKind;

base::Status check_camera(const std::string& camera) {
  if (!base::is_valid(base::CameraId{camera})) {
    return base::fail(ErrorKind::kFormat, "camera",
                      fmt::format("\"{}\" is no camera id", camera.substr(0, kMaxNameChars)),
                      "use 1 to 32 letters, digits, '-' or '_'");
  }
  return {};
}

base::Status check_size(const std::string& camera, std::string_view field, std::size_t size,
                        std::size_t bound) {
  if (size > bound) {
    return base::fail(ErrorKind::kLimit, camera,
                      fmt::format("{} of {} is beyond {}", field, size, bound));
  }
  return {};
}

base::Status check_text(const std::string& camera, std::string_view field, const std::string& text,
                        std::size_t bound) {
  if (text.find('\0') != std::string::npos) {
    return base::fail(ErrorKind::kFormat, camera, fmt::format("{} contains a NUL", field));
  }
  return check_size(camera, fmt::format("length of {}", field), text.size(), bound);
}

}  // namespace

std::size_t payload_bytes(const FrameMessage& message) {
  std::size_t bytes = 0;
  for (const Part& part : message.parts) bytes += part.bytes.size();
  return bytes;
}

std::size_t payload_bytes(const PlateMessage& message) { return message.bytes.size(); }

base::Status check_bounds(const FrameMessage& message) {
  if (auto ok = check_camera(message.camera); !ok) return ok;
  if (auto ok = check_size(message.camera, "number of parts", message.parts.size(), kMaxParts);
      !ok) {
    return ok;
  }
  for (const Part& part : message.parts) {
    if (auto ok = check_size(message.camera, "part size", part.bytes.size(), kMaxPartBytes); !ok) {
      return ok;
    }
  }
  return check_size(message.camera, "frame size", payload_bytes(message), kMaxFrameBytes);
}

base::Status check_bounds(const PlateMessage& message) {
  if (auto ok = check_camera(message.camera); !ok) return ok;
  return check_size(message.camera, "plate tile size", message.bytes.size(), kMaxPlateBytes);
}

base::Status check_bounds(const StatusMessage& message) {
  if (auto ok = check_camera(message.camera); !ok) return ok;
  const std::string& camera = message.camera;
  if (auto ok = check_text(camera, "source", message.source, kMaxSourceChars); !ok) return ok;
  if (auto ok = check_text(camera, "text", message.text, kMaxTextChars); !ok) return ok;
  if (auto ok = check_text(camera, "calibration", message.calibration, kMaxNameChars); !ok) {
    return ok;
  }
  if (auto ok = check_size(camera, "number of stages", message.stages.size(), kMaxListEntries);
      !ok) {
    return ok;
  }
  if (auto ok = check_size(camera, "number of drop reasons", message.drops.size(), kMaxListEntries);
      !ok) {
    return ok;
  }
  for (const StageRate& rate : message.stages) {
    if (auto ok = check_text(camera, "stage name", rate.stage, kMaxNameChars); !ok) return ok;
  }
  for (const DropCount& drop : message.drops) {
    if (auto ok = check_text(camera, "drop reason", drop.reason, kMaxNameChars); !ok) return ok;
  }
  return {};
}

base::Status check_bounds(const CommandMessage& message) {
  if (!message.camera.empty()) {
    if (auto ok = check_camera(message.camera); !ok) return ok;
  }
  return check_text(message.camera, "text", message.text, kMaxTextChars);
}

base::Status check_bounds(const PeopleMessage& message) {
  if (auto ok = check_camera(message.camera); !ok) return ok;
  if (auto ok = check_size(message.camera, "number of places", message.places.size(), kMaxPlaces);
      !ok) {
    return ok;
  }
  for (const Place& place : message.places) {
    // Written so that what is not a number is refused.
    if (std::abs(place.x) <= kMostPlaceM && std::abs(place.y) <= kMostPlaceM && place.sd_m > 0 &&
        place.sd_m <= kMostPlaceM) {
      continue;
    }
    return base::fail(
        ErrorKind::kFormat, message.camera,
        fmt::format("someone stands at {}, {} m to within {} m", place.x, place.y, place.sd_m));
  }
  return {};
}

}  // namespace touchline::wire
