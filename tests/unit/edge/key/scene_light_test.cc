// Light and noise of a frame against a learnt plate.
#include "edge/key/scene_light.h"

#include <gtest/gtest.h>

#include "edge/key/packed_plate.h"
#include "tests/unit/edge/key/key_scene.h"

namespace touchline::key {
namespace {

constexpr double kStated = 4;

class LightOfAScene : public KeyScene {
 protected:
  SceneLight look(const image::Frame& frame) const {
    const FrameGrid grid = make_grid(camera_, pitch_, 5, 2.6);
    PackedPlate packed;
    packed.show(plate_);
    PlateWarper warper(*plate_, packed, grid, frame.width(), frame.height(), kStated);
    return scene_light(frame, warper, grid, kStated);
  }
};

TEST_F(LightOfAScene, NoiseIsMeasuredWhereItIsLargerThanThePlates) {
  for (const double noise : {3.0, 5.0, 7.0}) {
    const SceneLight light = look(scene_->frame({}, 7, noise));
    EXPECT_NEAR(light.luma_noise, noise, 0.35 * noise);
    EXPECT_NEAR(light.chroma_noise, noise, 0.35 * noise);
  }
}

TEST_F(LightOfAScene, PeopleDoNotPassForNoise) {
  const SceneLight empty = look(scene_->frame({}, 7, 3));
  std::vector<plate::Disc> people;
  for (int k = 0; k < 12; ++k) people.push_back({{40.0 + 34 * k, 130.0 + 9 * (k % 7)}, 8});
  const SceneLight with_people = look(scene_->frame(people, 7, 3));
  EXPECT_LT(with_people.luma_noise, 1.25F * empty.luma_noise);
  EXPECT_LT(with_people.chroma_noise, 1.25F * empty.chroma_noise);
}

TEST_F(LightOfAScene, NoiseIsBelievedUpToTwiceWhatWasStated) {
  const SceneLight light = look(scene_->frame({}, 7, 30));
  EXPECT_LE(light.luma_noise, 2 * kStated);
  EXPECT_LE(light.chroma_noise, 2 * kStated);
}

TEST_F(LightOfAScene, ASkyHasNoNoiseOfTurf) {
  camera_ = plate::test_camera(0, 0.4);
  const SceneLight light = look(plate::render(camera_, pitch_, {}));
  EXPECT_EQ(light.luma_noise, 0);
  EXPECT_EQ(light.chroma_noise, 0);
}

}  // namespace
}  // namespace touchline::key
