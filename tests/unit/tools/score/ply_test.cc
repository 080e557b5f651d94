#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tests/support/folders.h"
#include "tools/score/truth.h"

namespace touchline::score {
namespace {

constexpr const char* kAscii =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
    "z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";

TEST(ReadPly, ReadsAsciiAndBinaryAlike) {
  const support::TempFolder folder;
  support::write_text(folder / "a.ply", std::string(kAscii) + "0 0 0\n1 0 0\n0 1 0.5\n3 0 1 2\n");
  std::string binary = kAscii;
  binary.replace(binary.find("ascii"), 5, "binary_little_endian");
  const float vertices[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0.5F};
  const std::int32_t corners[3] = {0, 1, 2};
  binary.append(reinterpret_cast<const char*>(vertices), sizeof(vertices));
  binary.push_back(3);
  binary.append(reinterpret_cast<const char*>(corners), sizeof(corners));
  support::write_text(folder / "b.ply", binary);
  const auto a = read_ply(folder / "a.ply");
  const auto b = read_ply(folder / "b.ply");
  ASSERT_TRUE(a) << to_string(a.error());
  ASSERT_TRUE(b) << to_string(b.error());
  EXPECT_EQ(a->vertices, b->vertices);
  EXPECT_EQ(a->triangles, b->triangles);
  EXPECT_EQ(a->vertices[2].z(), 0.5F);
}

TEST(ReadPly, RefusesWhatIsCutOrPointsOutside) {
  const support::TempFolder folder;
  support::write_text(folder / "cut.ply", std::string(kAscii) + "0 0 0\n1 0 0\n");
  support::write_text(folder / "out.ply", std::string(kAscii) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  support::write_text(folder / "no.ply", "solid\n");
  EXPECT_EQ(read_ply(folder / "cut.ply").error().kind, base::ErrorKind::kTruncated);
  EXPECT_EQ(read_ply(folder / "out.ply").error().kind, base::ErrorKind::kFormat);
  EXPECT_EQ(read_ply(folder / "no.ply").error().kind, base::ErrorKind::kFormat);
  EXPECT_EQ(read_ply(folder / "none.ply").error().kind, base::ErrorKind::kNotFound);
}

}  // namespace
}  // namespace touchline::score
