// Comma-separated tables with a header line, as truth and exports have them.
#pragma once

#include <cstddef>
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

  std::size_t rows() const { return cells_.size(); }
  bool has(std::string_view column) const;
  // Fails naming the file where a column is missing.
  base::Result<std::size_t> column(std::string_view name) const;
  const std::string& text(std::size_t row, std::size_t column) const { return cells_[row][column]; }
  base::Result<double> number(std::size_t row, std::size_t column) const;

 private:
  std::string path_;
  std::vector<std::string> header_;
  std::vector<std::vector<std::string>> cells_;
};

}  // namespace touchline::score
