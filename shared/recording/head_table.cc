#include "shared/recording/head_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "shared/recording/csv_internal.h"

namespace touchline::recording {
namespace {

constexpr std::uintmax_t kMostBytes = 256 << 20;
constexpr std::array<std::string_view, 5> kColumns{"frame", "pan_counts", "tilt_counts",
                                                   "zoom_counts", "focus_counts"};
constexpr std::int64_t kMostCounts = std::int64_t{1} << 48;  // counters are no wider

}  // namespace

base::Result<std::vector<HeadRow>> parse_head_table(std::string_view text,
                                                    const std::string& file) {
  const auto bad = [&](int number, std::string what) {
    return base::fail(base::ErrorKind::kConfiguration, fmt::format("{}:{}", file, number),
                      std::move(what),
                      "write frame,pan_counts,tilt_counts,zoom_counts,focus_counts");
  };
  const std::vector<CsvLine> lines = csv_lines(text);
  if (lines.empty()) return bad(1, "the table is empty");
  const auto& header = lines.front().fields;
  if (!std::equal(header.begin(), header.end(), kColumns.begin(), kColumns.end()))
    return bad(lines.front().number, "the header line is not that of a head table");
  std::vector<HeadRow> rows;
  rows.reserve(lines.size() - 1);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const CsvLine& line = lines[i];
    if (line.fields.size() != kColumns.size()) {
      return bad(line.number,
                 fmt::format("has {} fields, not {}", line.fields.size(), kColumns.size()));
    }
    std::array<std::int64_t, 5> values{};
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto value = parse_whole(line.fields[k]);
      if (!value || *value > kMostCounts || *value < (k == 0 ? 0 : -kMostCounts)) {
        return bad(line.number, fmt::format("{} '{}' is not a whole number of a counter",
                                            kColumns[k], line.fields[k]));
      }
      values[k] = *value;
    }
    if (!rows.empty() && values[0] <= rows.back().frame) {
      return bad(line.number,
                 fmt::format("frame {} does not come after {}", values[0], rows.back().frame));
    }
    rows.push_back({values[0], values[1], values[2], values[3], values[4]});
  }
  return rows;
}

base::Result<std::vector<HeadRow>> read_head_table(const std::filesystem::path& path) {
  const auto text = read_file(path, kMostBytes);
  if (!text) return base::fail(text.error());
  return parse_head_table(*text, path.string());
}

std::string head_table_text(std::span<const HeadRow> rows) {
  std::string out = "frame,pan_counts,tilt_counts,zoom_counts,focus_counts\n";
  for (const HeadRow& row : rows)
    out += fmt::format("{},{},{},{},{}\n", row.frame, row.pan, row.tilt, row.zoom, row.focus);
  return out;
}

}  // namespace touchline::recording
