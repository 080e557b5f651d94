// How an edge unit fares: what it tells the hub about once a second.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "shared/base/ids.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::publish {

enum class UnitState : std::uint8_t { kStarting, kRunning, kEnded, kFailed };

struct StageRate {
  std::string stage;  // "capture", "calibrate", "key", ...
  double hz = 0;
  double mean_ms = 0;  // time spent on a frame
};

struct UnitStatus {
  base::CameraId camera;
  std::uint32_t epoch = 0;
  UnitState state = UnitState::kStarting;
  std::string source;
  std::vector<StageRate> stages;
  std::map<std::string, std::uint64_t> drops;  // by reason
  std::uint64_t frames_read = 0;
  std::uint64_t frames_sent = 0;
  geometry::Evidence calibration = geometry::Evidence::kLost;  // of the latest frame
  std::string text;                                            // for people
};

}  // namespace touchline::publish
