#include "tools/score/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>

namespace touchline::score {

namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> cells(1);
  for (const char c : line) {
    if (c == ',') {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back().push_back(c);
    }
  }
  return cells;
}

}  // namespace

base::Result<CsvTable> CsvTable::read(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be opened",
                      "check the folder");
  }
  CsvTable table;
  table.path_ = path.string();
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (line.empty() || line == "\r") continue;
    std::vector<std::string> cells = split(line);
    if (table.header_.empty()) {
      table.header_ = std::move(cells);
      continue;
    }
    if (cells.size() != table.header_.size()) {
      return base::fail(
          base::ErrorKind::kFormat, fmt::format("{}:{}", table.path_, number),
          fmt::format("{} cells where the header has {}", cells.size(), table.header_.size()));
    }
    table.cells_.push_back(std::move(cells));
  }
  if (table.header_.empty()) {
    return base::fail(base::ErrorKind::kFormat, table.path_, "has no header line");
  }
  return table;
}

bool CsvTable::has(std::string_view column) const {
  return std::find(header_.begin(), header_.end(), column) != header_.end();
}

base::Result<std::size_t> CsvTable::column(std::string_view name) const {
  const auto at = std::find(header_.begin(), header_.end(), name);
  if (at == header_.end()) {
    return base::fail(base::ErrorKind::kFormat, path_, fmt::format("has no column '{}'", name));
  }
  return static_cast<std::size_t>(at - header_.begin());
}

base::Result<double> CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string& cell = cells_[row][column];
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) {
    return base::fail(base::ErrorKind::kFormat, fmt::format("{}: row {}", path_, row + 1),
                      fmt::format("'{}' in column '{}' is no number", cell, header_[column]));
  }
  return value;
}

}  // namespace touchline::score
