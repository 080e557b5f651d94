#include "hub/output/ply.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "hub/output/file_internal.h"

namespace touchline::output {
namespace {

static_assert(std::endian::native == std::endian::little);

template <typename T>
void append(std::vector<char>& bytes, const T& value) {
  const auto* p = reinterpret_cast<const char*>(&value);
  bytes.insert(bytes.end(), p, p + sizeof(T));
}

struct PlyHeader {
  std::size_t vertices = 0;
  std::size_t vertex_bytes = 0;  // of one vertex
  std::size_t faces = 0;
  std::size_t data = 0;  // where it starts
};

std::size_t size_of(const std::string& type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "float" || type == "int32" || type == "uint32" ||
      type == "float32") {
    return 4;
  }
  return type == "double" || type == "float64" ? 8 : 0;
}

base::Result<PlyHeader> parse_header(const std::string& bytes, const std::string& where) {
  const auto refuse = [&](const std::string& what) {
    return base::fail(base::ErrorKind::kFormat, where, what);
  };
  const std::string end = "end_header\n";
  const std::size_t at = bytes.substr(0, 65536).find(end);
  if (bytes.compare(0, 4, "ply\n") != 0 || at == std::string::npos) {
    return refuse("is no PLY file");
  }
  PlyHeader header;
  header.data = at + end.size();
  std::istringstream lines(bytes.substr(0, at));
  std::string line;
  std::string element;
  bool binary = false;
  int position = 0;  // of the vertex's properties
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "format") {
      words >> word;
      binary = word == "binary_little_endian";
    } else if (word == "element") {
      std::size_t count = 0;
      words >> element >> count;
      if (!words || count > std::numeric_limits<std::uint32_t>::max()) return refuse(line);
      if (element == "vertex") {
        header.vertices = count;
      } else if (element == "face") {
        header.faces = count;
      } else if (count > 0) {
        return refuse("has elements other than vertex and face");
      }
    } else if (word == "property" && element == "vertex") {
      std::string type, name;
      words >> type >> name;
      const std::size_t size = size_of(type);
      const bool coordinate = position < 3;
      const std::string axis = coordinate ? std::string(1, "xyz"[position]) : std::string();
      if (size == 0 || (coordinate && (name != axis || (type != "float" && type != "float32")))) {
        return refuse("vertices must start with float x, y, z");
      }
      header.vertex_bytes += size;
      ++position;
    } else if (word == "property" && element == "face") {
      std::string list, count, index, name;
      words >> list >> count >> index >> name;
      if (list != "list" || size_of(count) != 1 || size_of(index) != 4) {
        return refuse("faces must be lists with a uchar count and 32-bit indices");
      }
    }
  }
  if (!binary) return refuse("is not binary little-endian");
  if (header.vertices > 0 && position < 3) return refuse("vertices have no x, y, z");
  return header;
}

}  // namespace

base::Status write_ply(const std::filesystem::path& path, std::span<const geometry::Mesh> meshes) {
  std::size_t vertices = 0;
  std::size_t triangles = 0;
  for (const geometry::Mesh& mesh : meshes) {
    vertices += mesh.vertices.size();
    triangles += mesh.triangles.size();
  }
  if (vertices > std::numeric_limits<std::uint32_t>::max()) {
    return base::fail(base::ErrorKind::kLimit, path.string(), "more than 2^32 vertices");
  }
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment world metres\nelement vertex " +
      std::to_string(vertices) +
      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
      std::to_string(triangles) + "\nproperty list uchar uint vertex_indices\nend_header\n";
  std::vector<char> bytes(header.begin(), header.end());
  bytes.reserve(bytes.size() + 12 * vertices + 13 * triangles);
  for (const geometry::Mesh& mesh : meshes) {
    for (const Eigen::Vector3f& v : mesh.vertices) {
      for (int k = 0; k < 3; ++k) append(bytes, v[k]);
    }
  }
  std::uint32_t offset = 0;
  for (const geometry::Mesh& mesh : meshes) {
    for (const auto& triangle : mesh.triangles) {
      append(bytes, std::uint8_t{3});
      for (const std::uint32_t index : triangle) append(bytes, index + offset);
    }
    offset += static_cast<std::uint32_t>(mesh.vertices.size());
  }
  return write_whole(path, bytes.data(), bytes.size());
}

base::Status write_ply(const std::filesystem::path& path, const geometry::Mesh& mesh) {
  return write_ply(path, std::span<const geometry::Mesh>(&mesh, 1));
}

base::Result<geometry::Mesh> read_ply(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be opened");
  }
  const std::string bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto header = parse_header(bytes, path.string());
  if (!header) return base::fail(header.error());
  const std::size_t size = bytes.size() - header->data;
  constexpr std::size_t kFace = 13;
  if (header->vertices > 0 && header->vertex_bytes > size / header->vertices) {
    return base::fail(base::ErrorKind::kTruncated, path.string(), "ends within its vertices");
  }
  const std::size_t faces_at = header->vertices * header->vertex_bytes;
  if (header->faces > (size - faces_at) / kFace) {
    return base::fail(base::ErrorKind::kTruncated, path.string(), "ends within its faces");
  }
  geometry::Mesh mesh;
  mesh.vertices.resize(header->vertices);
  const char* p = bytes.data() + header->data;
  for (Eigen::Vector3f& v : mesh.vertices) {
    std::memcpy(v.data(), p, 12);
    p += header->vertex_bytes;
  }
  mesh.triangles.resize(header->faces);
  for (auto& triangle : mesh.triangles) {
    if (*p != 3) {
      return base::fail(base::ErrorKind::kFormat, path.string(), "has faces that are no triangles");
    }
    std::memcpy(triangle.data(), p + 1, 12);
    p += kFace;
    for (const std::uint32_t index : triangle) {
      if (index >= header->vertices) {
        return base::fail(base::ErrorKind::kFormat, path.string(),
                          "a face names vertex " + std::to_string(index) + " of " +
                              std::to_string(header->vertices));
      }
    }
  }
  return mesh;
}

}  // namespace touchline::output
