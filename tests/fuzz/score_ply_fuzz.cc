// Meshes that a scorer reads: any bytes are read or refused, and what was read holds together.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "tools/score/hull_score.h"
#include "tools/score/truth.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace touchline;
  const auto mesh = score::parse_ply({reinterpret_cast<const char*>(data), size}, "mesh.ply");
  if (!mesh) return 0;
  std::size_t triangles = 0;
  for (const geometry::Mesh& part : score::split_components(*mesh)) {
    triangles += part.triangles.size();
  }
  if (triangles != mesh->triangles.size()) std::abort();
  return 0;
}
