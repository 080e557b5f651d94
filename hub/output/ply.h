// Triangle meshes as binary little-endian PLY (float x, y, z; uchar count, uint indices).
#pragma once

#include <filesystem>
#include <span>

#include "shared/base/result.h"
#include "shared/geometry/mesh.h"

namespace touchline::output {

// All meshes in one file, one after another, world metres; indices are shifted, vertices not
// merged.
base::Status write_ply(const std::filesystem::path& path, std::span<const geometry::Mesh> meshes);
base::Status write_ply(const std::filesystem::path& path, const geometry::Mesh& mesh);

// Reads what write_ply writes, and any binary little-endian PLY whose vertices start with float x,
// y, z and whose faces are triangles with a uchar count and 32-bit indices.
base::Result<geometry::Mesh> read_ply(const std::filesystem::path& path);

}  // namespace touchline::output
