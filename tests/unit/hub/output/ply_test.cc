#include "hub/output/ply.h"

#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <string>

#include "tests/support/folders.h"

namespace touchline::output {
namespace {

geometry::Mesh tetrahedron(float at) {
  geometry::Mesh mesh;
  mesh.vertices = {{at, 0, 0}, {at + 1, 0, 0}, {at, 1, 0}, {at, 0, 1.25f}};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return mesh;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Ply, MeshComesBackAsItWas) {
  const support::TempFolder folder;
  const geometry::Mesh mesh = tetrahedron(-3);
  ASSERT_TRUE(write_ply(folder / "a.ply", mesh));
  const auto back = read_ply(folder / "a.ply");
  ASSERT_TRUE(back);
  EXPECT_EQ(back->vertices, mesh.vertices);
  EXPECT_EQ(back->triangles, mesh.triangles);
}

TEST(Ply, SeveralMeshesStandOneAfterAnother) {
  const support::TempFolder folder;
  const std::array<geometry::Mesh, 2> meshes = {tetrahedron(0), tetrahedron(5)};
  ASSERT_TRUE(write_ply(folder / "a.ply", meshes));
  const auto back = read_ply(folder / "a.ply");
  ASSERT_TRUE(back);
  ASSERT_EQ(back->vertices.size(), 8U);
  ASSERT_EQ(back->triangles.size(), 8U);
  EXPECT_EQ(back->vertices[4], meshes[1].vertices[0]);
  EXPECT_EQ(back->triangles[5], (std::array<std::uint32_t, 3>{4, 5, 7}));
}

TEST(Ply, EveryCutFileIsRefused) {
  const support::TempFolder folder;
  ASSERT_TRUE(write_ply(folder / "a.ply", tetrahedron(0)));
  const std::string whole = bytes_of(folder / "a.ply");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::ofstream(folder / "cut.ply", std::ios::binary) << whole.substr(0, size);
    EXPECT_FALSE(read_ply(folder / "cut.ply")) << size << " of " << whole.size() << " bytes";
  }
}

TEST(Ply, IndicesBeyondTheVerticesAreRefused) {
  const support::TempFolder folder;
  geometry::Mesh mesh = tetrahedron(0);
  mesh.triangles[2][1] = 4;
  ASSERT_TRUE(write_ply(folder / "a.ply", mesh));
  const auto back = read_ply(folder / "a.ply");
  ASSERT_FALSE(back);
  EXPECT_EQ(back.error().kind, base::ErrorKind::kFormat);
}

}  // namespace
}  // namespace touchline::output
