#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/score/sets/set_report.h"

namespace touchline::score {

namespace {

std::string figure(double value) {
  if (std::isnan(value)) return "-";
  const double size = std::abs(value);
  if (value == std::round(value) && size < 1e6) return fmt::format("{:.0f}", value);
  return fmt::format("{:.{}f}", value, size >= 100 ? 1 : size >= 10 ? 2 : 3);
}

}  // namespace

std::string table_text(const SetReport& report) {
  struct Column {
    std::string name, unit;
    std::size_t width = 0;
  };
  std::vector<Column> columns;
  std::size_t label_width = 0;
  const auto column_of = [&](const SetCell& cell) {
    return std::find_if(columns.begin(), columns.end(),
                        [&](const Column& c) { return c.name == cell.name; });
  };
  for (const SetRow& row : report.rows) {
    label_width = std::max(label_width, row.label.size());
    for (const SetCell& cell : row.cells) {
      if (column_of(cell) == columns.end()) {
        columns.push_back({cell.name, cell.unit, std::max(cell.name.size(), cell.unit.size())});
      }
      Column& column = *column_of(cell);
      column.width = std::max(column.width, figure(cell.value).size());
    }
  }
  std::string out = fmt::format("set {}\n{}\n\n{:<{}}", report.name, report.what, "", label_width);
  for (const Column& c : columns) out += fmt::format("  {:>{}}", c.name, c.width);
  out += fmt::format("  {:>7}\n{:<{}}", "n", "", label_width);
  for (const Column& c : columns) out += fmt::format("  {:>{}}", c.unit, c.width);
  out += '\n';
  for (const SetRow& row : report.rows) {
    out += fmt::format("{:<{}}", row.label, label_width);
    std::size_t least = 0, most = 0;
    for (const Column& c : columns) {
      const auto cell = std::find_if(row.cells.begin(), row.cells.end(),
                                     [&](const SetCell& s) { return s.name == c.name; });
      const bool there = cell != row.cells.end();
      out += fmt::format("  {:>{}}", there ? figure(cell->value) : "", c.width);
      if (!there) continue;
      least = least == 0 ? cell->n : std::min(least, cell->n);
      most = std::max(most, cell->n);
    }
    out += fmt::format("  {:>7}\n",
                       least == most ? fmt::format("{}", most) : fmt::format("{}-{}", least, most));
  }
  if (!report.notes.empty()) out += '\n';
  for (const std::string& note : report.notes) out += note + '\n';
  return out;
}

std::string json_text(const SetReport& report) {
  using Json = nlohmann::ordered_json;
  Json out = {{"format_version", 1}, {"set", report.name}, {"what", report.what}};
  out["rows"] = Json::array();
  for (const SetRow& row : report.rows) {
    Json cells = Json::array();
    for (const SetCell& cell : row.cells) {
      const Json value = std::isfinite(cell.value) ? Json(cell.value) : Json(nullptr);
      cells.push_back({{"name", cell.name}, {"value", value}, {"unit", cell.unit}, {"n", cell.n}});
    }
    out["rows"].push_back({{"label", row.label}, {"cells", cells}});
  }
  out["notes"] = report.notes;
  return out.dump(2);
}

}  // namespace touchline::score
