// head.csv: what the encoders of a head said at each frame, raw (formats.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"

namespace touchline::recording {

// frame,pan_counts,tilt_counts,zoom_counts,focus_counts; offset and scale are unknown.
struct HeadRow {
  std::int64_t frame = 0;  // of the video, from 0
  std::int64_t pan = 0;
  std::int64_t tilt = 0;
  std::int64_t zoom = 0;
  std::int64_t focus = 0;
  bool operator==(const HeadRow&) const = default;
};

// Frames must rise; some may be missing. Errors name file:line.
base::Result<std::vector<HeadRow>> read_head_table(const std::filesystem::path& path);
base::Result<std::vector<HeadRow>> parse_head_table(std::string_view text, const std::string& file);

std::string head_table_text(std::span<const HeadRow> rows);

}  // namespace touchline::recording
