// Readers of single parts of a scene file. Each notes what is wrong at its table.
#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/config/toml_document.h"
#include "tools/sim/scene/scene.h"

namespace touchline::sim::scene {

base::Result<Scene> read_scene(const config::Document& document, const std::string& file,
                               const std::filesystem::path& folder);

// A list of exactly that many numbers, each within +-1e6.
Eigen::Vector2d pair(config::Table& table, std::string_view key, const Eigen::Vector2d& fallback);
Eigen::Vector3d triple(config::Table& table, std::string_view key, const Eigen::Vector3d& fallback);
Eigen::Vector3f colour(config::Table& table, std::string_view key, const Eigen::Vector3f& fallback);
std::array<double, 3> colour(config::Table& table, std::string_view key,
                             const std::array<double, 3>& fallback);
// A flat list in rows of `columns` numbers; empty where the key is absent.
std::vector<std::vector<double>> rows(config::Table& table, std::string_view key,
                                      std::size_t columns, std::string_view what);
// What validate() of a part found, at the key it names: `where` is `prefix` and a key. What lies
// deeper has been noted at its own table.
void note(config::Table& table, const base::Status& status, std::string_view prefix = {});

// The light, the ground and all that stands round it.
void read_world(config::Table& root, world::WorldSpec& world);
// [[kit]], [[team]], [[person]], [[group]] and [ball].
void read_people(config::Table& root, const std::filesystem::path& folder, const Scene& scene,
                 double length_m, double width_m, people::CastSpec& cast);
// Notes what is wrong with all of them together, at whom it is about.
void check_people(config::Table& root, const people::CastSpec& cast);
// [[camera]], [[rig]] and [[virtual]].
void read_cameras(config::Table& root, Scene& scene, double length_m, double width_m);

}  // namespace touchline::sim::scene
