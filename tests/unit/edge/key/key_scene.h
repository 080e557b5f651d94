// A painted pitch whose plate is learnt: what the key's tests look at.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "edge/plate/plate_builder.h"
#include "tests/unit/edge/plate/turf_scene.h"

namespace touchline::key {

class KeyScene : public ::testing::Test {
 protected:
  void SetUp() override {
    scene_.emplace(camera_, pitch_);
    plate::PlateBuilder builder(pitch_, geometry::position_in_world(camera_), 1.0 / 500);
    for (unsigned k = 0; k < 6; ++k) builder.add(scene_->frame({}, 50 + k), camera_);
    plate_ = builder.snapshot(true);
  }

  pitch::PitchModel pitch_ = plate::test_pitch();
  geometry::CameraEstimate camera_ = plate::test_camera(0);
  std::optional<plate::Backdrop> scene_;
  std::shared_ptr<const image::PlateSnapshot> plate_;
};

}  // namespace touchline::key
