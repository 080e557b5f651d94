// Survey stills.
#pragma once

#include <filesystem>

#include "shared/base/result.h"
#include "shared/image/frame.h"

namespace touchline::recording {

// A JPEG or PNG as kYuv422p10, BT.709 limited range, chroma co-sited on even luma samples; the
// still's own matrix, range and chroma position are undone. Id and stamp stay empty. Errors name
// the file.
base::Result<image::Frame> read_still(const std::filesystem::path& path);

}  // namespace touchline::recording
