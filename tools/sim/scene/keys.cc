#include <fmt/format.h>

#include "tools/sim/scene/keys_internal.h"

namespace touchline::sim::scene {

namespace {

std::optional<std::vector<double>> exactly(config::Table& table, std::string_view key,
                                           std::size_t count) {
  if (!table.has(key)) {
    table.numbers(key, {});  // known, and absent
    return std::nullopt;
  }
  std::vector<double> values = table.numbers(key, {}, {-1e6, 1e6});
  if (values.size() == count) return values;
  if (!values.empty()) {
    table.reject(key, fmt::format("has {} numbers", values.size()), fmt::format("give {}", count));
  }
  return std::nullopt;
}

}  // namespace

Eigen::Vector2d pair(config::Table& table, std::string_view key, const Eigen::Vector2d& fallback) {
  const auto v = exactly(table, key, 2);
  return v ? Eigen::Vector2d((*v)[0], (*v)[1]) : fallback;
}

Eigen::Vector3d triple(config::Table& table, std::string_view key,
                       const Eigen::Vector3d& fallback) {
  const auto v = exactly(table, key, 3);
  return v ? Eigen::Vector3d((*v)[0], (*v)[1], (*v)[2]) : fallback;
}

Eigen::Vector3f colour(config::Table& table, std::string_view key,
                       const Eigen::Vector3f& fallback) {
  return triple(table, key, fallback.cast<double>()).cast<float>();
}

std::array<double, 3> colour(config::Table& table, std::string_view key,
                             const std::array<double, 3>& fallback) {
  const auto v = exactly(table, key, 3);
  return v ? std::array<double, 3>{(*v)[0], (*v)[1], (*v)[2]} : fallback;
}

std::vector<std::vector<double>> rows(config::Table& table, std::string_view key,
                                      std::size_t columns, std::string_view what) {
  const std::vector<double> flat = table.numbers(key, {}, {-1e6, 1e6});
  std::vector<std::vector<double>> made;
  if (flat.size() % columns != 0) {
    table.reject(key, fmt::format("has {} numbers", flat.size()),
                 fmt::format("give {} for each: {}", columns, what));
    return made;
  }
  for (std::size_t i = 0; i < flat.size(); i += columns) {
    made.emplace_back(flat.begin() + static_cast<std::ptrdiff_t>(i),
                      flat.begin() + static_cast<std::ptrdiff_t>(i + columns));
  }
  return made;
}

void note(config::Table& table, const base::Status& status, std::string_view prefix) {
  if (status) return;
  std::string key = status.error().where;
  if (key.starts_with(prefix)) key.erase(0, prefix.size());
  if (key.find('.') == std::string::npos) {
    table.reject(key, status.error().what, status.error().cure);
  }
}

}  // namespace touchline::sim::scene
