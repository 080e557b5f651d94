// Small text files: lines of comma-separated fields, whole-file reads with a bound, writes that
// replace a file at once.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"

namespace touchline::recording {

// At most `most_bytes`. kNotFound, kIo or kLimit.
base::Result<std::string> read_file(const std::filesystem::path& path, std::uintmax_t most_bytes);
// Beside the file first, then renamed over it.
base::Status write_file(const std::filesystem::path& path, std::string_view text);

// Fields of one line, without blanks round them. The views live as long as the text.
struct CsvLine {
  int number = 0;  // from 1
  std::vector<std::string_view> fields;
};

// Lines that are not blank; a carriage return at the end and a byte-order mark at the start go.
std::vector<CsvLine> csv_lines(std::string_view text);

// The whole field, nothing after it. Reals must be finite.
std::optional<double> parse_real(std::string_view field);
std::optional<std::int64_t> parse_whole(std::string_view field);

}  // namespace touchline::recording
