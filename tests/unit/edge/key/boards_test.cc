// What changes behind the pitch without being people: boards, and the light.
#include "edge/key/boards.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "edge/key/key.h"
#include "tests/unit/edge/key/key_scene.h"

namespace touchline::key {
namespace {

class Boards : public KeyScene {
 protected:
  void SetUp() override {
    KeyScene::SetUp();
    origin_ = geometry::position_in_world(camera_);
  }
  // Metres that a pixel's ray ends beyond the far touchline; far beyond for none.
  double beyond(int x, int y) const {
    const auto hit = pitch::intersect_turf(
        pitch_, origin_,
        geometry::ray_in_world(camera_, {static_cast<double>(x), static_cast<double>(y)}));
    return hit ? std::abs(hit->y()) - pitch_.width_m / 2 : 1e3;
  }
  // The picture with other code values where `where` says so.
  image::Frame changed(const std::vector<plate::Disc>& discs,
                       const std::function<bool(int, int)>& where, double luma_gain, int luma,
                       int chroma) const {
    image::Frame frame = scene_->frame(discs, 3);
    const image::ChromaShift shift = image::chroma_shift(frame.format);
    for (int y = 0; y < frame.height(); ++y)
      for (int x = 0; x < frame.width(); ++x) {
        if (!where(x, y)) continue;
        frame.planes[0](x, y) =
            static_cast<std::uint16_t>(64 + luma_gain * (frame.planes[0](x, y) - 64) + luma);
        for (std::size_t c = 1; c < 3; ++c) {
          auto& value = frame.planes[c](x >> shift.x, y >> shift.y);
          value = static_cast<std::uint16_t>(512 + luma_gain * (value - 512) + chroma);
        }
      }
    return frame;
  }
  static int foreground(const image::Matte& matte) {
    return static_cast<int>(std::count_if(matte.alpha.data(),
                                          matte.alpha.data() + matte.alpha.size(),
                                          [](std::uint8_t a) { return a >= 128; }));
  }

  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
};

TEST_F(Boards, ABoardThatShowsSomethingElseIsNobodyButUnknown) {
  const auto band = [&](int x, int y) { return beyond(x, y) > 3 && beyond(x, y) < 12; };
  const plate::Disc player{{240, 200}, 6};
  const image::Frame frame = changed({player}, band, 0.2, 600, 0);
  const image::Matte matte = key(frame, camera_, *plate_, pitch_).matte;
  int hidden = 0, of = 0;
  for (int y = 0; y < frame.height(); ++y)
    for (int x = 0; x < frame.width(); ++x) {
      if (!band(x, y)) continue;
      EXPECT_LT(matte.alpha(x, y), 128) << x << ' ' << y;
      ++of;
      hidden += matte.unknown(x, y) != 0;
    }
  EXPECT_GT(of, 500);
  EXPECT_GT(hidden, 0.5 * of);
  EXPECT_GE(matte.alpha(240, 200), 128);
  EXPECT_NEAR(foreground(matte), 3.14159 * 36, 0.15 * 3.14159 * 36);
}

TEST_F(Boards, OnePersonBehindThePitchIsKept) {
  int y = 0;
  while (beyond(240, y) > 3) ++y;
  const plate::Disc person{{240, y - 5.0}, 5};
  const image::Matte matte = key(scene_->frame({person}, 3), camera_, *plate_, pitch_).matte;
  EXPECT_GE(matte.alpha(240, y - 5), 128);
}

TEST_F(Boards, ARowOfPeopleOnThePitchIsKept) {
  std::vector<plate::Disc> wall;
  for (int k = 0; k < 30; ++k) wall.push_back({{150 + 5.0 * k, 190}, 5});
  const image::Matte matte = key(scene_->frame(wall, 3), camera_, *plate_, pitch_).matte;
  for (const plate::Disc& d : wall)
    EXPECT_GE(matte.alpha(static_cast<int>(d.centre.x()), 190), 128) << d.centre.x();
}

TEST_F(Boards, ALightStepIsNobody) {
  for (const double gain : {0.7, 1.3}) {
    const auto everywhere = [](int, int) { return true; };
    const image::Frame frame = changed({}, everywhere, gain, 0, 0);
    EXPECT_EQ(foreground(key(frame, camera_, *plate_, pitch_).matte), 0) << gain;
  }
}

}  // namespace
}  // namespace touchline::key
