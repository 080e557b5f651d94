#include "tools/score/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace touchline::score {

namespace {

std::vector<std::string> split(std::string_view line) {
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
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be opened",
                      "check the folder");
  }
  std::ostringstream text;
  text << in.rdbuf();
  return parse(text.str(), path.string());
}

base::Result<CsvTable> CsvTable::parse(std::string_view text, const std::string& file) {
  CsvTable table;
  table.path_ = file;
  int number = 1;
  for (std::size_t at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string_view line = text.substr(at, end - at);
    at = end + 1;
    if (line.empty() || line == "\r") continue;
    std::vector<std::string> cells = split(line);
    if (table.header_.empty()) {
      table.header_ = std::move(cells);
      continue;
    }
    if (cells.size() != table.header_.size()) {
      return base::fail(
          base::ErrorKind::kFormat, fmt::format("{}:{}", table.path_, number),
          fmt::format("{} cells where the header has {}", cells.size(), table.header_.size()),
          "write the table again");
    }
    table.cells_.push_back(std::move(cells));
    table.lines_.push_back(number);
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
    return base::fail(base::ErrorKind::kFormat, path_, fmt::format("has no column '{}'", name),
                      "formats.md has the columns");
  }
  return static_cast<std::size_t>(at - header_.begin());
}

base::Result<double> CsvTable::number(std::size_t row, std::size_t column) const {
  const std::string& cell = cells_[row][column];
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size() || !std::isfinite(value)) {
    return base::fail(base::ErrorKind::kFormat, fmt::format("{}:{}", path_, lines_[row]),
                      fmt::format("'{}' in column '{}' is no number", cell, header_[column]));
  }
  return value;
}

base::Result<std::int64_t> CsvTable::frame(std::size_t row, std::size_t column) const {
  const auto value = number(row, column);
  if (!value) return base::fail(value.error());
  if (*value < 0 || *value > 1e9 || *value != std::floor(*value)) {
    return base::fail(
        base::ErrorKind::kFormat, fmt::format("{}:{}", path_, lines_[row]),
        fmt::format("'{}' in column '{}' is no frame", cells_[row][column], header_[column]));
  }
  return static_cast<std::int64_t>(*value);
}

}  // namespace touchline::score
