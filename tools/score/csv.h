// Comma-separated tables with a header line, as truth and exports have them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/result.h"

namespace touchline::score {

class CsvTable {
 public:
  // Every row has as many cells as the header; an error names file and line.
  static base::Result<CsvTable> read(const std::filesystem::path& path);
  // The same from text; `file` names it in errors.
  static base::Result<CsvTable> parse(std::string_view text, const std::string& file);

  std::size_t rows() const { return cells_.size(); }
  bool has(std::string_view column) const;
  // Fails naming the file where a column is missing.
  base::Result<std::size_t> column(std::string_view name) const;
  const std::string& text(std::size_t row, std::size_t column) const { return cells_[row][column]; }
  // A finite number.
  base::Result<double> number(std::size_t row, std::size_t column) const;
  // A frame: a whole number from 0.
  base::Result<std::int64_t> frame(std::size_t row, std::size_t column) const;

 private:
  std::string path_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> cells_;
  std::vector<int> lines_;  // in the file
};

}  // namespace touchline::score
