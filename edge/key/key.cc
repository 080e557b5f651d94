#include "edge/key/key.h"

#include <fmt/format.h>

#include <algorithm>

#include "edge/key/components.h"
#include "edge/key/difference.h"
#include "edge/key/plate_warp.h"
#include "edge/key/soft_alpha.h"
#include "edge/key/volume.h"

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
  o.occluder_margin_px = std::clamp(o.occluder_margin_px, 0.0, 20.0);
  return o;
}

base::Status in_bounds(const char* field, double value, double low, double high) {
  if (value >= low && value <= high) return {};
  return base::fail(base::ErrorKind::kConfiguration, field,
                    fmt::format("{} is outside {}..{}", value, low, high), "correct the value");
}

}  // namespace

base::Status KeyOptions::validate() const {
  for (const auto& s :
       {in_bounds("weak_sigma", weak_sigma, 1, 50),
        in_bounds("strong_sigma", strong_sigma, weak_sigma, 200),
        in_bounds("noise_codes", noise_codes, 0.5, 50),
        in_bounds("calibration_px", calibration_px, 0, 5),
        in_bounds("darkest_shadow", darkest_shadow, 0.05, 1),
        in_bounds("brightest_turf", brightest_turf, 1, 3), in_bounds("margin_m", margin_m, 0, 50),
        in_bounds("tallest_m", tallest_m, 1, 5),
        in_bounds("occluder_margin_px", occluder_margin_px, 0, 20)})
    if (!s) return s;
  return {};
}

state::KeyResult key(const image::Frame& frame, const geometry::CameraEstimate& camera,
                     const image::PlateSnapshot& plate, const pitch::PitchModel& pitch,
                     const KeyOptions& options) {
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
  const WarpedPlate warped = warp_plate(plate, grid, width, height);
  const Expected turf = turf_colour(frame, grid);
  const Difference diff = difference(frame, warped, grid, turf, o);
  const auto bodies = find_bodies(diff, grid, camera, pitch, o);
  matte.alpha = soft_alpha(frame, warped, turf, diff, bodies, o);
  matte.occluders = paint_occluders(camera, pitch, o.occluder_margin_px);
  matte.unknown = matte.occluders;

  std::size_t foreground = 0;
  std::size_t unknown = 0;
  std::size_t no_plate = 0;
  int left = width, right = -1, top = height, bottom = -1;
  for (int y = 0; y < height; ++y) {
    const int j = y / kCell;
    for (int i = 0; i * kCell < width; ++i) {
      const int end = std::min(width, (i + 1) * kCell);
      if (!grid.cell_in_volume(i, j)) {
        std::fill(matte.alpha.row(y) + i * kCell, matte.alpha.row(y) + end, std::uint8_t{0});
        std::fill(matte.unknown.row(y) + i * kCell, matte.unknown.row(y) + end, std::uint8_t{0});
        continue;
      }
      left = std::min(left, i * kCell);
      right = std::max(right, end - 1);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
      for (int x = i * kCell; x < end; ++x) {
        if (diff.known(x, y) == 0) matte.unknown(x, y) = 255;
        no_plate += diff.known(x, y) != 1;
        foreground += matte.alpha(x, y) >= 128;
        unknown += matte.unknown(x, y) != 0;
      }
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
