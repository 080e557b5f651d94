#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "hub/hull/surface_internal.h"

namespace touchline::hull {

namespace {

constexpr int kPadded = kBrick + 1;
constexpr std::uint8_t kOutside = 255;
constexpr std::int16_t kNoVertex = -1;

// The cells whose lower corner is a sample of one brick, which may itself be empty.
struct CellBrick {
  BrickKey key;
  std::array<std::ptrdiff_t, 8> bricks;   // at key + (b & 1, b >> 1 & 1, b >> 2), or -1
  std::array<std::ptrdiff_t, 8> cells;    // the same of cell bricks
  std::vector<std::int16_t> edge_vertex;  // of edge (sample, axis): sample * 3 + axis; may be empty
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::uint32_t> component;                 // of each vertex
  std::vector<std::array<std::uint32_t, 3>> triangles;  // by numbers over all cell bricks
  std::uint32_t first_vertex = 0;
};

struct Padded {
  std::array<float, kPadded * kPadded * kPadded> field;
  std::array<std::uint32_t, kPadded * kPadded * kPadded> component;
  bool crossed = false;  // the surface passes through

  static std::size_t index(int i, int j, int k) {
    return static_cast<std::size_t>((k * kPadded + j) * kPadded + i);
  }
};

void load(const Volume& volume, const Components& components, const CellBrick& cell,
          Padded& padded) {
  const auto empty = static_cast<float>(-volume.voxel_m);
  bool any_in = false;
  bool any_out = false;
  for (int k = 0; k < kPadded; ++k) {
    for (int j = 0; j < kPadded; ++j) {
      for (int i = 0; i < kPadded; ++i) {
        const auto part =
            static_cast<std::size_t>(i / kBrick + 2 * (j / kBrick) + 4 * (k / kBrick));
        const std::size_t to = Padded::index(i, j, k);
        const std::ptrdiff_t from = cell.bricks[part];
        padded.field[to] = empty;
        padded.component[to] = 0;
        if (from >= 0) {
          const Brick& brick = volume.bricks[static_cast<std::size_t>(from)];
          const int s = (k % kBrick * kBrick + j % kBrick) * kBrick + i % kBrick;
          padded.field[to] = brick.field[static_cast<std::size_t>(s)];
          if (brick.label[static_cast<std::size_t>(s)] != kOutside) {
            padded.component[to] = components.at(brick, s);
          }
        }
        (padded.field[to] > 0 ? any_in : any_out) = true;
      }
    }
  }
  padded.crossed = any_in && any_out;
}

void place_vertices(const Volume& volume, const Padded& padded,
                    const std::vector<std::uint8_t>& keep, CellBrick& cell) {
  constexpr std::array<std::size_t, 3> kStep = {1, kPadded, kPadded * kPadded};
  cell.edge_vertex.assign(kBrickSamples * 3, kNoVertex);
  for (int k = 0; k < kBrick; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      for (int i = 0; i < kBrick; ++i) {
        const std::size_t here = Padded::index(i, j, k);
        const float f0 = padded.field[here];
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t there = here + kStep[axis];
          const float f1 = padded.field[there];
          if ((f0 > 0) == (f1 > 0)) continue;
          const std::uint32_t component = padded.component[f0 > 0 ? here : there];
          if (!keep[component]) continue;
          // Kept off the samples, so that no triangle shrinks to a point.
          const float t = std::clamp(f0 / (f0 - f1), 0.02F, 0.98F);
          Eigen::Vector3d point = volume.sample_in_world(cell.key, i, j, k);
          point[static_cast<Eigen::Index>(axis)] += static_cast<double>(t) * volume.voxel_m;
          const auto sample = static_cast<std::size_t>((k * kBrick + j) * kBrick + i);
          cell.edge_vertex[sample * 3 + axis] = static_cast<std::int16_t>(cell.vertices.size());
          cell.vertices.push_back(point.cast<float>());
          cell.component.push_back(component);
        }
      }
    }
  }
}

void place_triangles(const Padded& padded, const CellTable& table,
                     const std::vector<std::uint8_t>& keep, const std::vector<CellBrick>& cells,
                     CellBrick& cell) {
  for (int k = 0; k < kBrick; ++k) {
    for (int j = 0; j < kBrick; ++j) {
      for (int i = 0; i < kBrick; ++i) {
        unsigned mask = 0;
        for (unsigned c = 0; c < 8; ++c) {
          const std::size_t s =
              Padded::index(i + static_cast<int>(c & 1), j + static_cast<int>(c >> 1 & 1),
                            k + static_cast<int>(c >> 2));
          // Dropped components are outside for the kept ones; no kept one touches them.
          if (padded.field[s] > 0 && keep[padded.component[s]]) mask |= 1U << c;
        }
        const CellCase& shape = table[mask];
        for (std::size_t t = 0; t < shape.count; ++t) {
          std::array<std::uint32_t, 3> triangle{};
          for (std::size_t corner = 0; corner < 3; ++corner) {
            const std::size_t edge = shape.triangles[t][corner];
            const int x = i + (kEdgeCorner[edge] & 1);
            const int y = j + (kEdgeCorner[edge] >> 1 & 1);
            const int z = k + (kEdgeCorner[edge] >> 2);
            const auto part =
                static_cast<std::size_t>(x / kBrick + 2 * (y / kBrick) + 4 * (z / kBrick));
            const CellBrick& owner = cells[static_cast<std::size_t>(cell.cells[part])];
            const auto sample =
                static_cast<std::size_t>((z % kBrick * kBrick + y % kBrick) * kBrick + x % kBrick);
            triangle[corner] =
                owner.first_vertex +
                static_cast<std::uint32_t>(owner.edge_vertex[sample * 3 + kEdgeAxis[edge]]);
          }
          cell.triangles.push_back(triangle);
        }
      }
    }
  }
}

std::vector<CellBrick> list_cells(const Volume& volume) {
  std::vector<BrickKey> keys;
  keys.reserve(volume.bricks.size() * 8);
  for (const Brick& brick : volume.bricks) {
    for (int b = 0; b < 8; ++b) {
      keys.push_back({brick.key.x - (b & 1), brick.key.y - (b >> 1 & 1), brick.key.z - (b >> 2)});
    }
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  std::vector<CellBrick> cells(keys.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 64), [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      cells[n].key = keys[n];
      for (int b = 0; b < 8; ++b) {
        const BrickKey key{keys[n].x + (b & 1), keys[n].y + (b >> 1 & 1), keys[n].z + (b >> 2)};
        cells[n].bricks[static_cast<std::size_t>(b)] = volume.find(key);
        const auto at = std::lower_bound(keys.begin(), keys.end(), key);
        cells[n].cells[static_cast<std::size_t>(b)] =
            at != keys.end() && *at == key ? at - keys.begin() : -1;
      }
    }
  });
  return cells;
}

}  // namespace

std::vector<geometry::Mesh> extract_surfaces(const Volume& volume, const Components& components,
                                             const std::vector<std::uint8_t>& keep) {
  std::vector<geometry::Mesh> meshes(components.list.size());
  if (meshes.empty()) return meshes;
  const CellTable table = make_cell_table();
  std::vector<CellBrick> cells = list_cells(volume);
  const tbb::blocked_range<std::size_t> all(0, cells.size(), 16);
  tbb::parallel_for(all, [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      Padded padded;
      load(volume, components, cells[n], padded);
      if (padded.crossed) place_vertices(volume, padded, keep, cells[n]);
    }
  });
  std::uint32_t total = 0;
  for (CellBrick& cell : cells) {
    cell.first_vertex = total;
    total += static_cast<std::uint32_t>(cell.vertices.size());
  }
  tbb::parallel_for(all, [&](const auto& range) {
    for (std::size_t n = range.begin(); n < range.end(); ++n) {
      Padded padded;
      load(volume, components, cells[n], padded);
      if (padded.crossed) place_triangles(padded, table, keep, cells, cells[n]);
    }
  });
  std::vector<std::uint32_t> number(total);  // of each vertex within its component
  std::vector<std::uint32_t> owner(total);
  for (const CellBrick& cell : cells) {
    for (std::size_t v = 0; v < cell.vertices.size(); ++v) {
      geometry::Mesh& mesh = meshes[cell.component[v]];
      owner[cell.first_vertex + v] = cell.component[v];
      number[cell.first_vertex + v] = static_cast<std::uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(cell.vertices[v]);
    }
  }
  for (const CellBrick& cell : cells) {
    for (const auto& triangle : cell.triangles) {
      meshes[owner[triangle[0]]].triangles.push_back(
          {number[triangle[0]], number[triangle[1]], number[triangle[2]]});
    }
  }
  tbb::parallel_for(std::size_t{0}, meshes.size(),
                    [&](std::size_t m) { fill_cavities(meshes[m]); });
  return meshes;
}

void fill_cavities(geometry::Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0U);
  const auto root_of = [&](std::uint32_t node) {
    while (parent[node] != node) {
      parent[node] = parent[parent[node]];
      node = parent[node];
    }
    return node;
  };
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t i = 1; i < 3; ++i) {
      const std::uint32_t a = root_of(triangle[0]);
      const std::uint32_t b = root_of(triangle[i]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<double> volume(mesh.vertices.size());  // by root, times six
  bool any = false;
  for (const auto& triangle : mesh.triangles) {
    const std::uint32_t root = root_of(triangle[0]);
    const Eigen::Vector3d base = mesh.vertices[root].cast<double>();
    const Eigen::Vector3d a = mesh.vertices[triangle[0]].cast<double>() - base;
    const Eigen::Vector3d b = mesh.vertices[triangle[1]].cast<double>() - base;
    const Eigen::Vector3d c = mesh.vertices[triangle[2]].cast<double>() - base;
    volume[root] += a.dot(b.cross(c));
    any |= root != root_of(mesh.triangles.front()[0]);
  }
  if (!any) return;
  constexpr std::uint32_t kGone = 0xFFFFFFFF;
  std::vector<std::uint32_t> number(mesh.vertices.size(), kGone);
  geometry::Mesh kept;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (volume[root_of(v)] <= 0) continue;
    number[v] = static_cast<std::uint32_t>(kept.vertices.size());
    kept.vertices.push_back(mesh.vertices[v]);
  }
  for (const auto& t : mesh.triangles) {
    if (number[t[0]] == kGone) continue;
    kept.triangles.push_back({number[t[0]], number[t[1]], number[t[2]]});
  }
  mesh = std::move(kept);
}

double enclosed_volume(const geometry::Mesh& mesh) {
  if (mesh.vertices.empty()) return 0;
  const Eigen::Vector3d base = mesh.vertices.front().cast<double>();
  double six_volumes = 0;
  for (const auto& triangle : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[triangle[0]].cast<double>() - base;
    const Eigen::Vector3d b = mesh.vertices[triangle[1]].cast<double>() - base;
    const Eigen::Vector3d c = mesh.vertices[triangle[2]].cast<double>() - base;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

}  // namespace touchline::hull
