// Readers of the body's files (MakeHuman: .obj, .target, .mhskel, .mhw) and of the motions (.anim
// key frames). Any bytes are read or refused with where and what; sizes are bounded.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/base/result.h"

namespace touchline::sim::people {

// Polygons of the group "body" as triangles; vertices keep the file's numbers and frame
// (decimetres, X left, Y up, Z ahead).
struct ObjFile {
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};
base::Result<ObjFile> parse_obj(std::string_view text, const std::string& where);

// Moves of single vertices, same units.
using TargetFile = std::vector<std::pair<std::uint32_t, Eigen::Vector3f>>;
base::Result<TargetFile> parse_target(std::string_view text, const std::string& where);

// Bones parents first; ends are means of vertices of the base mesh.
struct SkeletonFile {
  struct Bone {
    std::string name;
    int parent = -1;
    std::vector<std::uint32_t> head;
    std::vector<std::uint32_t> tail;
  };
  std::vector<Bone> bones;
};
base::Result<SkeletonFile> parse_skeleton(std::string_view text, const std::string& where);

// By bone: (vertex, weight > 0).
using WeightsFile = std::map<std::string, std::vector<std::pair<std::uint32_t, float>>>;
base::Result<WeightsFile> parse_weights(std::string_view text, const std::string& where);

// Nodes of the animations' figure, parents first. Straight limbs down and feet flat are identity;
// X left, -Y ahead, Z up.
enum class Node : std::uint8_t {
  kBody,
  kMiddle,
  kNeck,
  kLeftShoulder,
  kLeftElbow,
  kRightShoulder,
  kRightElbow,
  kLeftThigh,
  kLeftKnee,
  kLeftAnkle,
  kRightThigh,
  kRightKnee,
  kRightAnkle,
};
inline constexpr std::size_t kNodes = 13;

struct ClipFile {
  template <typename T>
  struct Keys {
    std::vector<int> frame;  // increasing, from 0; 100 a second
    std::vector<T> value;
  };
  Keys<Eigen::Vector3f> root;  // metres; z from the height of straight legs
  std::array<Keys<Eigen::Quaternionf>, kNodes> nodes;
  std::optional<std::pair<int, Eigen::Vector3f>> ball;  // frame and place of contact
  int frames = 0;                                       // the last key's frame
};
base::Result<ClipFile> parse_clip(std::string_view text, const std::string& where);

// A whole file; at most `limit` bytes.
base::Result<std::string> read_text(const std::filesystem::path& path, std::size_t limit);

}  // namespace touchline::sim::people
