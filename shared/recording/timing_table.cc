#include "shared/recording/timing_table.h"

#include <fmt/format.h>

#include "shared/recording/csv_internal.h"

namespace touchline::recording {
namespace {

constexpr std::uintmax_t kMostBytes = 256 << 20;

std::string line_name(const std::string& file, int number) {
  return file + ":" + std::to_string(number);
}

}  // namespace

base::Result<std::vector<TimingRow>> parse_timing_table(std::string_view text,
                                                        const std::string& file) {
  const auto bad = [&](int number, std::string what) {
    return base::fail(base::ErrorKind::kConfiguration, line_name(file, number), std::move(what),
                      "write frame,media_time_ns,timecode");
  };
  const std::vector<CsvLine> lines = csv_lines(text);
  if (lines.empty()) return bad(1, "the table is empty");
  const auto& header = lines.front().fields;
  const bool has_timecode = header.size() == 3 && header[2] == "timecode";
  if (header.size() < 2 || header[0] != "frame" || header[1] != "media_time_ns" ||
      (header.size() != 2 && !has_timecode)) {
    return bad(lines.front().number, "the header line is not that of a timing table");
  }
  std::vector<TimingRow> rows;
  rows.reserve(lines.size() - 1);
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const CsvLine& line = lines[i];
    if (line.fields.size() != header.size()) {
      return bad(line.number,
                 fmt::format("has {} fields, not {}", line.fields.size(), header.size()));
    }
    const auto frame = parse_whole(line.fields[0]);
    const auto time = parse_whole(line.fields[1]);
    if (!frame || *frame < 0) {
      return bad(line.number, fmt::format("frame '{}' is not a frame number", line.fields[0]));
    }
    if (!time) {
      return bad(line.number,
                 fmt::format("media_time_ns '{}' is not a whole number", line.fields[1]));
    }
    TimingRow row{*frame, base::MediaTime{*time}, std::nullopt};
    if (has_timecode && !line.fields[2].empty()) {
      const auto timecode = base::parse_timecode(std::string(line.fields[2]));
      if (!timecode) return bad(line.number, timecode.error().what);
      row.timecode = *timecode;
    }
    if (!rows.empty() && row.frame <= rows.back().frame) {
      return bad(line.number,
                 fmt::format("frame {} does not come after {}", row.frame, rows.back().frame));
    }
    if (!rows.empty() && row.media_time < rows.back().media_time) {
      return bad(line.number, fmt::format("media_time_ns {} lies before {}", row.media_time.ns,
                                          rows.back().media_time.ns));
    }
    rows.push_back(row);
  }
  return rows;
}

base::Result<std::vector<TimingRow>> read_timing_table(const std::filesystem::path& path) {
  const auto text = read_file(path, kMostBytes);
  if (!text) return base::fail(text.error());
  return parse_timing_table(*text, path.string());
}

std::string timing_table_text(std::span<const TimingRow> rows) {
  std::string out = "frame,media_time_ns,timecode\n";
  for (const TimingRow& row : rows) {
    out += fmt::format("{},{},{}\n", row.frame, row.media_time.ns,
                       row.timecode ? to_string(*row.timecode) : "");
  }
  return out;
}

}  // namespace touchline::recording
