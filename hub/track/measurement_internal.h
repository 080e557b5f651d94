// What one instant says about where people and the ball are.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "hub/scene/hull.h"
#include "hub/track/people_tracker.h"
#include "shared/codec/camera_view.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::track {

struct Measurement {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();  // people: on the turf; ball: its centre
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  // of x and y
  std::vector<std::uint32_t> groups;
};

struct Measurements {
  std::vector<Measurement> people;  // by rising x
  std::vector<Measurement> balls;   // the most likely first
};

// `expected` are the places where people are awaited.
Measurements measure(const scene::Hull& hull, std::span<const codec::CameraView> views,
                     std::span<const Eigen::Vector2d> expected, const pitch::PitchModel& pitch,
                     const TrackOptions& options);

}  // namespace touchline::track
