#include "edge/key/key.h"

#include <algorithm>
#include <utility>

#include "edge/key/alike.h"
#include "edge/key/colour_classifier.h"
#include "edge/key/components.h"
#include "edge/key/difference.h"
#include "edge/key/packed_plate.h"
#include "edge/key/plate_warp.h"
#include "edge/key/scene_light.h"
#include "edge/key/soft_alpha.h"
#include "edge/key/volume.h"
#include "shared/base/bounds.h"

namespace touchline::key {
namespace {

KeyOptions bounded(KeyOptions o) {
  o.weak_sigma = std::clamp(o.weak_sigma, 1.0, 50.0);
  o.strong_sigma = std::clamp(o.strong_sigma, o.weak_sigma, 200.0);
  o.noise_codes = std::clamp(o.noise_codes, 0.5, 50.0);
  o.calibration_px = std::clamp(o.calibration_px, 0.0, 5.0);
  o.darkest_shadow = std::clamp(o.darkest_shadow, 0.05, 1.0);
  o.brightest_turf = std::clamp(o.brightest_turf, 1.0, 3.0);
  o.margin_m = std::clamp(o.margin_m, 0.0, 50.0);
  o.tallest_m = std::clamp(o.tallest_m, 1.0, 5.0);
  o.alike_reach_m = std::clamp(o.alike_reach_m, 0.0, 2.0);
  o.occluder_margin_px = std::clamp(o.occluder_margin_px, 0.0, 20.0);
  return o;
}

struct Counts {
  unsigned no_plate = 0;
  unsigned foreground = 0;
};

// Of at most kCell pixels; hides those with nothing to compare with. Bytes alone, so that the loop
// runs in lanes.
Counts count_row(const std::uint8_t* alpha, const std::uint8_t* known, int n,
                 std::uint8_t* hidden) {
  static_assert(kCell < 256);
  std::uint8_t no_plate = 0;
  std::uint8_t foreground = 0;
  for (int x = 0; x < n; ++x) {
    const auto nothing = static_cast<std::uint8_t>(known[x] == 0 ? 255 : 0);
    hidden[x] = static_cast<std::uint8_t>(hidden[x] | nothing);
    no_plate = static_cast<std::uint8_t>(no_plate + (known[x] != 1 ? 1 : 0));
    foreground = static_cast<std::uint8_t>(foreground + (alpha[x] >> 7));
  }
  return {no_plate, foreground};
}

}  // namespace

base::Status KeyOptions::validate() const {
  for (const auto& s :
       {base::in_bounds("weak_sigma", weak_sigma, 1, 50),
        base::in_bounds("strong_sigma", strong_sigma, weak_sigma, 200),
        base::in_bounds("noise_codes", noise_codes, 0.5, 50),
        base::in_bounds("calibration_px", calibration_px, 0, 5),
        base::in_bounds("darkest_shadow", darkest_shadow, 0.05, 1),
        base::in_bounds("brightest_turf", brightest_turf, 1, 3),
        base::in_bounds("margin_m", margin_m, 0, 50), base::in_bounds("tallest_m", tallest_m, 1, 5),
        base::in_bounds("alike_reach_m", alike_reach_m, 0, 2),
        base::in_bounds("occluder_margin_px", occluder_margin_px, 0, 20)})
    if (!s) return s;
  return colours.validate();
}

struct Keyer::State {
  ColourTable colours;
  PackedPlate plate;
  WarpedPlate warped;
  Difference difference;
  image::Image<std::uint8_t> peak, bodies, scratch, hidden;
  MixBuffers mix;
};

Keyer::Keyer() : state_(std::make_unique<State>()) {}
Keyer::~Keyer() = default;
Keyer::Keyer(Keyer&&) noexcept = default;
Keyer& Keyer::operator=(Keyer&&) noexcept = default;

state::KeyResult key(const image::Frame& frame, const geometry::CameraEstimate& camera,
                     const image::PlateSnapshot& plate, const pitch::PitchModel& pitch,
                     const KeyOptions& options) {
  // The plate outlives the call.
  const std::shared_ptr<const image::PlateSnapshot> borrowed(std::shared_ptr<const void>(), &plate);
  return Keyer().key(frame, camera, borrowed, pitch, options);
}

state::KeyResult Keyer::key(const image::Frame& frame, const geometry::CameraEstimate& camera,
                            const std::shared_ptr<const image::PlateSnapshot>& shown,
                            const pitch::PitchModel& pitch, const KeyOptions& options) {
  const image::PlateSnapshot& plate = *shown;
  const KeyOptions o = bounded(options);
  const int width = frame.width();
  const int height = frame.height();
  state::KeyResult result;
  image::Matte& matte = result.matte;
  matte.plate_version = plate.version;
  matte.region = {0, 0, width, height};
  if (camera.lost() || camera.model.width != width || camera.model.height != height || width < 1 ||
      height < 1) {
    matte.alpha = image::Image<std::uint8_t>(width, height, 0);
    matte.unknown = image::Image<std::uint8_t>(width, height, 255);
    matte.occluders = image::Image<std::uint8_t>(width, height, 0);
    result.report.unknown_share = 1;
    return result;
  }

  const FrameGrid grid = make_grid(camera, pitch, o.margin_m, o.tallest_m);
  state_->plate.show(shown);
  PlateWarper warper(plate, state_->plate, grid, width, height, o.noise_codes);
  const Expected turf = turf_colour(frame, grid);
  const SceneLight light = scene_light(frame, warper, grid, o.noise_codes);
  const CellMask active = find_active(frame, warper, grid, light, o);
  WarpedPlate& warped = state_->warped;
  Difference& diff = state_->difference;
  difference(frame, active, warper, grid, turf, light, o, warped, diff);
  if (!state_->colours.is_of(o.colours, frame.colour))
    state_->colours = ColourTable(o.colours, frame.colour);
  apply_colours(frame, state_->colours, diff);
  local_peak(diff, state_->scratch, state_->peak);
  const bool boards = find_bodies(diff, state_->peak, grid, camera, pitch, o, state_->scratch,
                                  state_->hidden, state_->bodies);
  const image::Image<std::uint8_t>& bodies = state_->bodies;
  matte.alpha = soft_alpha(frame, warped, turf, diff, state_->peak, bodies, o, state_->mix);
  matte.occluders = paint_occluders(camera, pitch, o.occluder_margin_px);
  matte.unknown = matte.occluders;
  if (boards) {
    for (std::size_t i = 0; i < matte.unknown.size(); ++i)
      matte.unknown.data()[i] |= state_->hidden.data()[i];
  }
  mark_alike(frame, diff, bodies, matte.alpha, grid, o, matte.unknown);

  std::size_t foreground = 0;
  std::size_t unknown = 0;
  std::size_t no_plate = 0;
  int left = width, right = -1, top = height, bottom = -1;
  for (int j = 0; j < grid.volume.rows; ++j)
    for (int i = 0; i < grid.volume.columns; ++i) {
      const int x0 = i * kCell;
      const int x1 = std::min(width, x0 + kCell);
      const int y0 = j * kCell;
      const int y1 = std::min(height, y0 + kCell);
      if (!grid.volume.at(i, j)) {
        for (int y = y0; y < y1; ++y) {
          std::fill(matte.alpha.row(y) + x0, matte.alpha.row(y) + x1, std::uint8_t{0});
          std::fill(matte.unknown.row(y) + x0, matte.unknown.row(y) + x1, std::uint8_t{0});
          std::fill(matte.occluders.row(y) + x0, matte.occluders.row(y) + x1, std::uint8_t{0});
        }
        continue;
      }
      left = std::min(left, x0);
      right = std::max(right, x1 - 1);
      top = std::min(top, y0);
      bottom = std::max(bottom, y1 - 1);
      const bool looked_at = diff.active.at(i, j);
      for (int y = y0; y < y1; ++y) {
        std::uint8_t* hidden = matte.unknown.row(y);
        if (looked_at) {
          const std::uint8_t* alpha = matte.alpha.row(y);
          const std::uint8_t* known = diff.known.row(y);
          const Counts counts = count_row(alpha + x0, known + x0, x1 - x0, hidden + x0);
          no_plate += counts.no_plate;
          foreground += counts.foreground;
        }
        unsigned sum = 0;
        for (int x = x0; x < x1; ++x) sum += hidden[x] != 0 ? 1U : 0U;
        unknown += sum;
      }
    }
  matte.region = right < left ? image::Rect{0, 0, 0, 0}
                              : image::Rect{left, top, right - left + 1, bottom - top + 1};
  const double all = static_cast<double>(width) * height;
  result.report.foreground_share = static_cast<double>(foreground) / all;
  result.report.unknown_share = static_cast<double>(unknown) / all;
  result.report.no_plate_share = static_cast<double>(no_plate) / all;
  return result;
}

}  // namespace touchline::key
