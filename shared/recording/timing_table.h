// timing.csv: when the frames of a video were exposed, where that is not regular (formats.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"
#include "shared/base/time.h"

namespace touchline::recording {

// frame,media_time_ns,timecode; the timecode may be empty.
struct TimingRow {
  std::int64_t frame = 0;  // of the video, from 0
  base::MediaTime media_time;
  std::optional<base::Timecode> timecode;
  bool operator==(const TimingRow&) const = default;
};

// Frames must rise and media times must not fall. Errors name file:line.
base::Result<std::vector<TimingRow>> read_timing_table(const std::filesystem::path& path);
base::Result<std::vector<TimingRow>> parse_timing_table(std::string_view text,
                                                        const std::string& file);

std::string timing_table_text(std::span<const TimingRow> rows);

}  // namespace touchline::recording
