#include "edge/key/active_cells.h"

#include <gtest/gtest.h>

#include <vector>

#include "edge/key/workspace.h"
#include "tests/unit/edge/key/key_scene.h"

namespace touchline::key {
namespace {

using plate::Disc;

class ActiveCells : public KeyScene {
 protected:
  // With the patches of the plate, or with none: every cell is looked at then.
  CellMask of(const image::Frame& frame, bool with_patches) {
    const KeyOptions options;
    const FrameGrid grid = make_grid(camera_, pitch_, options.margin_m, options.tallest_m);
    PackedPlate packed;
    packed.show(plate_);
    PlateWarper warper(*plate_, packed, grid, frame.width(), frame.height(), options.noise_codes);
    PlatePatches patches;
    patches.show(with_patches ? plate_ : std::make_shared<const image::PlateSnapshot>());
    const SceneLight light = scene_light(frame, warper, grid, options.noise_codes);
    return find_active(frame, warper, patches, grid, light, options);
  }
};

TEST_F(ActiveCells, TurfThatLooksLikeItsPatchHidesNobody) {
  for (unsigned seed = 1; seed < 9; ++seed) {
    std::vector<Disc> discs;
    for (unsigned k = 0; k < 6; ++k) {
      const unsigned n = seed * 6 + k;
      // A ball, limbs, heads, bodies; red, white, black, and green that is not turf's.
      const std::array<float, 3> colours[] = {
          {400, 440, 760}, {900, 512, 512}, {80, 512, 512}, {500, 380, 380}};
      discs.push_back(
          {{40.0 + (97 * n) % 400, 140.0 + (53 * n) % 120}, 1.5 + 2.0 * (n % 4), colours[n % 4]});
    }
    const auto frame = scene_->frame(discs, seed);
    const CellMask plain = of(frame, false);
    const CellMask fast = of(frame, true);
    for (const Disc& disc : discs)
      for (int y = 0; y < frame.height(); ++y)
        for (int x = 0; x < frame.width(); ++x) {
          if ((Eigen::Vector2d(x, y) - disc.centre).norm() > disc.radius) continue;
          EXPECT_EQ(fast.at(x / kCell, y / kCell), plain.at(x / kCell, y / kCell))
              << seed << ": " << x << ' ' << y;
        }
    // It adds none.
    for (std::size_t n = 0; n < fast.on.size(); ++n) EXPECT_LE(fast.on[n], plain.on[n]);
  }
}

TEST(CellImage, IsClearedWhereItWasWrittenBefore) {
  CellImage<std::uint8_t> image(7);
  CellMask first(50, 40);
  first(0, 0) = first(3, 2) = 1;
  CellMask second(50, 40);
  second(3, 2) = second(1, 1) = 1;
  image.start(50, 40, first);
  fill_cells(image.image, first, std::uint8_t{1});
  image.start(50, 40, second);
  fill_cells(image.image, second, std::uint8_t{2});
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 50; ++x)
      EXPECT_EQ(image.image(x, y), second.at(x / kCell, y / kCell) ? 2 : 7) << x << ' ' << y;
  image.clear();
  for (std::size_t i = 0; i < image.image.size(); ++i) EXPECT_EQ(image.image.data()[i], 7);
  image.start(20, 20, CellMask(20, 20));
  for (std::size_t i = 0; i < image.image.size(); ++i) EXPECT_EQ(image.image.data()[i], 7);
}

}  // namespace
}  // namespace touchline::key
