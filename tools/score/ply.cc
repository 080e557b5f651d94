#include <fmt/format.h>

#include <array>
#include <cstring>
#include <fstream>
#include <sstream>

#include "tools/score/truth.h"

namespace touchline::score {

namespace {

struct Header {
  bool binary = false;
  std::size_t vertices = 0;
  std::size_t faces = 0;
  std::size_t vertex_floats = 0;  // properties of a vertex; x, y, z first
};

constexpr std::size_t kMostElements = 50'000'000;

base::Result<Header> read_header(std::istream& in, const std::string& where) {
  Header header;
  std::string line;
  std::string element;
  if (!std::getline(in, line) || line.substr(0, 3) != "ply") {
    return base::fail(base::ErrorKind::kFormat, where, "is no PLY file");
  }
  while (std::getline(in, line)) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "end_header") return header;
    if (word == "format") {
      words >> word;
      if (word != "binary_little_endian" && word != "ascii") {
        return base::fail(base::ErrorKind::kUnsupported, where,
                          fmt::format("PLY format '{}'", word));
      }
      header.binary = word != "ascii";
    } else if (word == "element") {
      std::size_t count = 0;
      words >> element >> count;
      if (count > kMostElements) {
        return base::fail(base::ErrorKind::kLimit, where,
                          fmt::format("{} elements, at most {}", count, kMostElements));
      }
      if (element == "vertex") {
        header.vertices = count;
      } else if (element == "face") {
        header.faces = count;
      } else if (count > 0) {
        return base::fail(base::ErrorKind::kUnsupported, where,
                          fmt::format("PLY element '{}'", element), "vertices and faces only");
      }
    } else if (word == "property") {
      std::string type;
      words >> type;
      if (element == "vertex") {
        if (type != "float" && type != "float32") {
          return base::fail(base::ErrorKind::kUnsupported, where,
                            fmt::format("vertex property of type '{}'", type));
        }
        ++header.vertex_floats;
      } else if (element == "face") {
        std::string counts;
        std::string indices;
        words >> counts >> indices;
        if (type != "list" || counts != "uchar" || (indices != "int" && indices != "uint")) {
          return base::fail(base::ErrorKind::kUnsupported, where,
                            fmt::format("face property '{}'", line));
        }
      }
    }
  }
  return base::fail(base::ErrorKind::kTruncated, where, "PLY header without end");
}

}  // namespace

base::Result<geometry::Mesh> parse_ply(std::string_view bytes, const std::string& where) {
  std::istringstream in{std::string(bytes)};
  const auto header = read_header(in, where);
  if (!header) return base::fail(header.error());
  if (header->vertices > 0 && header->vertex_floats < 3) {
    return base::fail(base::ErrorKind::kFormat, where, "vertices without x, y, z");
  }
  geometry::Mesh mesh;
  std::vector<float> row(header->vertex_floats);
  for (std::size_t i = 0; i < header->vertices && in; ++i) {
    if (header->binary) {
      in.read(reinterpret_cast<char*>(row.data()),
              static_cast<std::streamsize>(row.size() * sizeof(float)));
    } else {
      for (float& value : row) in >> value;
    }
    if (in) mesh.vertices.emplace_back(row[0], row[1], row[2]);
  }
  for (std::size_t i = 0; i < header->faces && in; ++i) {
    std::array<std::uint32_t, 3> triangle{};
    unsigned corners = 0;
    if (header->binary) {
      corners = static_cast<unsigned char>(in.get());
      in.read(reinterpret_cast<char*>(triangle.data()), sizeof(triangle));
    } else {
      in >> corners >> triangle[0] >> triangle[1] >> triangle[2];
    }
    if (!in) break;
    if (corners != 3) {
      return base::fail(base::ErrorKind::kUnsupported, where,
                        fmt::format("face {} has {} corners", i, corners), "triangles only");
    }
    for (const std::uint32_t corner : triangle) {
      if (corner >= mesh.vertices.size()) {
        return base::fail(
            base::ErrorKind::kFormat, where,
            fmt::format("face {} names vertex {} of {}", i, corner, mesh.vertices.size()));
      }
    }
    mesh.triangles.push_back(triangle);
  }
  if (mesh.vertices.size() != header->vertices || mesh.triangles.size() != header->faces) {
    return base::fail(base::ErrorKind::kTruncated, where, "ends before its last element",
                      "write it again");
  }
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    if (!(vertex.cwiseAbs().maxCoeff() < 1e6F)) {
      return base::fail(base::ErrorKind::kFormat, where, "has a vertex beyond 1e6 m, or none");
    }
  }
  return mesh;
}

base::Result<geometry::Mesh> read_ply(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be opened",
                      "check the folder");
  }
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return parse_ply(bytes.str(), path.string());
}

}  // namespace touchline::score
