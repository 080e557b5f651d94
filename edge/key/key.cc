#include "edge/key/key.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "edge/key/active_cells.h"
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
  std::size_t no_plate = 0;
  std::size_t foreground = 0;
  std::size_t unknown = 0;
};

// Bytes alone, so that the loops run in lanes.
constexpr int kStretch = 240;

// Hides the pixels with nothing to compare with.
void count_row(const std::uint8_t* alpha, const std::uint8_t* known, int width,
               std::uint8_t* hidden, Counts& counts) {
  static_assert(kStretch < 256);
  for (int begin = 0; begin < width; begin += kStretch) {
    const int end = std::min(width, begin + kStretch);
    std::uint8_t no_plate = 0;
    std::uint8_t foreground = 0;
    for (int x = begin; x < end; ++x) {
      const auto nothing = static_cast<std::uint8_t>(known[x] == 0 ? 255 : 0);
      hidden[x] = static_cast<std::uint8_t>(hidden[x] | nothing);
      no_plate = static_cast<std::uint8_t>(no_plate + (known[x] != 1 ? 1 : 0));
      foreground = static_cast<std::uint8_t>(foreground + (alpha[x] >> 7));
    }
    counts.no_plate += no_plate;
    counts.foreground += foreground;
  }
}

std::size_t count_set(const std::uint8_t* row, int width) {
  std::size_t sum = 0;
  for (int begin = 0; begin < width; begin += kStretch) {
    const int end = std::min(width, begin + kStretch);
    std::uint8_t set = 0;
    for (int x = begin; x < end; ++x) set = static_cast<std::uint8_t>(set + (row[x] != 0 ? 1 : 0));
    sum += set;
  }
  return sum;
}

// Blanks a matte outside the volume, hides what could not be compared, counts.
Counts finish(const Difference& difference, const FrameGrid& grid, image::Matte& matte) {
  const int width = matte.alpha.width();
  const int height = matte.alpha.height();
  Counts counts;
  CellMask outside = grid.volume;
  for (std::uint8_t& on : outside.on) on = on == 0 ? 1 : 0;
  for (auto* image : {&matte.alpha, &matte.unknown, &matte.occluders})
    fill_cells(*image, outside, std::uint8_t{0});
  for (int j = 0; j < grid.volume.rows; ++j) {
    const std::vector<Span> active = spans(difference.active, j, width);
    const std::vector<Span> volume = spans(grid.volume, j, width);
    for (int y = j * kCell; y < std::min(height, (j + 1) * kCell); ++y) {
      std::uint8_t* hidden = matte.unknown.row(y);
      const std::uint8_t* alpha = matte.alpha.row(y);
      const std::uint8_t* known = difference.known.row(y);
      for (const Span& s : active)
        count_row(alpha + s.begin, known + s.begin, s.end - s.begin, hidden + s.begin, counts);
      for (const Span& s : volume) counts.unknown += count_set(hidden + s.begin, s.end - s.begin);
    }
  }
  return counts;
}

// The rectangle round the marked cells.
image::Rect region_of(const CellMask& cells, int width, int height) {
  int left = width, right = -1, top = height, bottom = -1;
  for (int j = 0; j < cells.rows; ++j)
    for (int i = 0; i < cells.columns; ++i) {
      if (!cells.at(i, j)) continue;
      left = std::min(left, i * kCell);
      right = std::max(right, std::min(width, (i + 1) * kCell) - 1);
      top = std::min(top, j * kCell);
      bottom = std::max(bottom, std::min(height, (j + 1) * kCell) - 1);
    }
  if (right < left) return {0, 0, 0, 0};
  return {left, top, right - left + 1, bottom - top + 1};
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
  PlatePatches patches;
  WarpedPlate warped;
  Difference difference;
  CellImage<std::uint8_t> peak, bodies, scratch;
  image::Image<std::uint8_t> hidden;
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
  state_->patches.show(shown);
  PlateWarper warper(plate, state_->plate, grid, width, height, o.noise_codes);
  const Expected turf = turf_colour(frame, grid);
  const SceneLight light = scene_light(frame, warper, grid, o.noise_codes);
  const CellMask active = find_active(frame, warper, state_->patches, grid, light, o);
  WarpedPlate& warped = state_->warped;
  Difference& diff = state_->difference;
  difference(frame, active, warper, grid, turf, light, o, warped, diff);
  if (!state_->colours.is_of(o.colours, frame.colour))
    state_->colours = ColourTable(o.colours, frame.colour);
  apply_colours(frame, state_->colours, diff);
  local_peak(diff, state_->scratch, state_->peak);
  const bool boards = find_bodies(diff, state_->peak.image, grid, camera, pitch, o, state_->scratch,
                                  state_->hidden, state_->bodies);
  const image::Image<std::uint8_t>& bodies = state_->bodies.image;
  matte.alpha = soft_alpha(frame, warped, turf, diff, state_->peak.image, bodies, o, state_->mix);
  matte.occluders = paint_occluders(camera, pitch, o.occluder_margin_px);
  matte.unknown = matte.occluders;
  if (boards) {
    for (std::size_t i = 0; i < matte.unknown.size(); ++i)
      matte.unknown.data()[i] |= state_->hidden.data()[i];
  }
  mark_alike(frame, diff, bodies, matte.alpha, grid, o, matte.unknown);

  const Counts counts = finish(diff, grid, matte);
  matte.region = region_of(grid.volume, width, height);
  const double all = static_cast<double>(width) * height;
  result.report.foreground_share = static_cast<double>(counts.foreground) / all;
  result.report.unknown_share = static_cast<double>(counts.unknown) / all;
  result.report.no_plate_share = static_cast<double>(counts.no_plate) / all;
  return result;
}

}  // namespace touchline::key
