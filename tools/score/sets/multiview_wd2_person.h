// The set multiview-wd2-person: one person on a green floor as 16 calibrated cameras see them, with
// masks.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "tools/score/sets/set_report.h"

namespace touchline::score {

// calibParamsI.txt: for each camera its number, three rows of K, k1 k2, three rows of [R|t] (camera
// from world, unit unknown). The picture's size is left at 0; the skew of K, a pixel or two over
// the picture's height, has no place in our model and is dropped.
base::Result<std::map<int, geometry::CameraEstimate>> read_wd2_calibration(
    const std::filesystem::path& path);
base::Result<std::map<int, geometry::CameraEstimate>> parse_wd2_calibration(
    const std::string& text, const std::string& file);

// Each camera is left out in turn: the hull of the others against its mask, and our renderer's view
// of the others against its picture.
base::Result<SetReport> run_multiview_wd2_person(const SetOptions& options);

}  // namespace touchline::score
