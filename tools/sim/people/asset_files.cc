#include "tools/sim/people/asset_files.h"

#include <fmt/format.h>

#include <fstream>

#include "tools/sim/people/text_scan_internal.h"

namespace touchline::sim::people {
namespace {

constexpr std::size_t kMostVertices = 200000;
constexpr std::size_t kMostTriangles = 400000;
constexpr int kMostFrames = 6000;

std::string at(const std::string& where, int line) { return fmt::format("{}:{}", where, line); }

constexpr std::array<std::string_view, kNodes> kNodeNames{
    "body",           "middle",      "neck",       "left_shoulder", "left_elbow",
    "right_shoulder", "right_elbow", "left_thigh", "left_knee",     "left_ankle",
    "right_thigh",    "right_knee",  "right_ankle"};

// Reads "frame,v0,...,vn-1" groups to the line's end.
template <std::size_t n, typename Sink>
bool read_keys(std::string_view rest, Sink&& sink) {
  int last = -1;
  while (const auto first = next_field(rest, ',')) {
    const auto frame = to_long(*first);
    if (!frame || *frame <= last || *frame > kMostFrames || (last < 0 && *frame != 0)) return false;
    last = static_cast<int>(*frame);
    std::array<float, n> value{};
    for (float& v : value) {
      const auto field = next_field(rest, ',');
      const auto number = field ? to_float(*field) : std::nullopt;
      if (!number || std::abs(*number) > 1000) return false;
      v = *number;
    }
    if (!sink(last, value)) return false;
  }
  return last >= 0;
}

}  // namespace

base::Result<std::string> read_text(const std::filesystem::path& path, std::size_t limit) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) {
    return base::fail(base::ErrorKind::kNotFound, path.string(),
                      "cannot be read: " + error.message(),
                      "give the folder with mh/ and anim/ (tools/sim/assets)");
  }
  if (size > limit) {
    return base::fail(base::ErrorKind::kLimit, path.string(),
                      fmt::format("{} bytes, the most is {}", size, limit));
  }
  std::ifstream stream(path, std::ios::binary);
  std::string text(size, '\0');
  if (!stream.read(text.data(), static_cast<std::streamsize>(size))) {
    return base::fail(base::ErrorKind::kIo, path.string(), "cannot be read");
  }
  return text;
}

base::Result<ObjFile> parse_obj(std::string_view text, const std::string& where) {
  ObjFile file;
  bool body = false;
  int number = 0;
  while (auto line = next_line(text)) {
    ++number;
    const auto word = next_field(*line, ' ');
    if (!word) continue;
    if (*word == "g") {
      body = trimmed(*line) == "body";
    } else if (*word == "v") {
      Eigen::Vector3f v;
      for (int i = 0; i < 3; ++i) {
        const auto field = next_field(*line, ' ');
        const auto value = field ? to_float(*field) : std::nullopt;
        if (!value || std::abs(*value) > 1000) {
          return base::fail(base::ErrorKind::kFormat, at(where, number), "bad vertex");
        }
        v[i] = *value;
      }
      if (file.vertices.size() >= kMostVertices) {
        return base::fail(base::ErrorKind::kLimit, at(where, number), "too many vertices");
      }
      file.vertices.push_back(v);
    } else if (*word == "f" && body) {
      std::vector<std::uint32_t> corner;
      while (auto field = next_field(*line, ' ')) {
        const auto index = to_long(field->substr(0, field->find('/')));
        if (!index || *index < 1 || *index > static_cast<long>(kMostVertices) ||
            corner.size() > 16) {
          return base::fail(base::ErrorKind::kFormat, at(where, number), "bad face");
        }
        corner.push_back(static_cast<std::uint32_t>(*index - 1));
      }
      if (corner.size() < 3 || file.triangles.size() + corner.size() > kMostTriangles) {
        return base::fail(base::ErrorKind::kFormat, at(where, number), "bad face or too many");
      }
      for (std::size_t i = 2; i < corner.size(); ++i) {
        file.triangles.push_back({corner[0], corner[i - 1], corner[i]});
      }
    }
  }
  for (const auto& t : file.triangles) {
    for (const std::uint32_t i : t) {
      if (i >= file.vertices.size()) {
        return base::fail(
            base::ErrorKind::kFormat, where,
            fmt::format("a face names vertex {}, there are {}", i + 1, file.vertices.size()));
      }
    }
  }
  if (file.triangles.empty()) {
    return base::fail(base::ErrorKind::kFormat, where, "no faces in the group 'body'");
  }
  return file;
}

base::Result<TargetFile> parse_target(std::string_view text, const std::string& where) {
  TargetFile file;
  int number = 0;
  while (auto line = next_line(text)) {
    ++number;
    const auto word = next_field(*line, ' ');
    if (!word || word->front() == '#') continue;
    const auto index = to_long(*word);
    Eigen::Vector3f v;
    bool good = index && *index >= 0 && *index < static_cast<long>(kMostVertices);
    for (int i = 0; good && i < 3; ++i) {
      const auto field = next_field(*line, ' ');
      const auto value = field ? to_float(*field) : std::nullopt;
      good = value && std::abs(*value) < 100;
      if (good) v[i] = *value;
    }
    if (!good || file.size() >= kMostVertices) {
      return base::fail(base::ErrorKind::kFormat, at(where, number), "not 'vertex dx dy dz'");
    }
    file.emplace_back(static_cast<std::uint32_t>(*index), v);
  }
  return file;
}

base::Result<ClipFile> parse_clip(std::string_view text, const std::string& where) {
  ClipFile file;
  int number = 0;
  while (auto line = next_line(text)) {
    ++number;
    const auto word = next_field(*line, ',');
    if (!word || word->empty() || word->front() == '<') break;  // what follows is about the game
    if (*word == "player") {
      file.root = {};
      const bool good = read_keys<3>(*line, [&](int frame, const std::array<float, 3>& v) {
        file.root.frame.push_back(frame);
        file.root.value.emplace_back(v[0], v[1], v[2]);
        return true;
      });
      if (!good)
        return base::fail(base::ErrorKind::kFormat, at(where, number), "bad 'player' keys");
      continue;
    }
    if (*word == "extension") {
      const auto what = next_field(*line, ',');
      if (!what || *what != "football") continue;
      const bool good = read_keys<3>(fmt::format("0,0,0,0,{}", *line),
                                     [&](int frame, const std::array<float, 3>& v) {
                                       if (frame > 0 && !file.ball) {
                                         file.ball = {frame, Eigen::Vector3f(v[0], v[1], v[2])};
                                       }
                                       return true;
                                     });
      if (!good) return base::fail(base::ErrorKind::kFormat, at(where, number), "bad ball key");
      continue;
    }
    std::size_t node = 0;
    while (node < kNodes && kNodeNames[node] != *word) ++node;
    if (node == kNodes) continue;
    auto& keys = file.nodes[node];
    keys = {};
    const bool good = read_keys<4>(*line, [&](int frame, const std::array<float, 4>& v) {
      Eigen::Quaternionf q(v[3], v[0], v[1], v[2]);
      if (!(q.norm() > 0.5F && q.norm() < 2.0F)) return false;
      q.normalize();
      if (!keys.value.empty() && keys.value.back().dot(q) < 0) q.coeffs() = -q.coeffs();
      keys.frame.push_back(frame);
      keys.value.push_back(q);
      return true;
    });
    if (!good) {
      return base::fail(base::ErrorKind::kFormat, at(where, number),
                        fmt::format("bad '{}' keys", *word));
    }
  }
  if (file.root.frame.empty()) {
    return base::fail(base::ErrorKind::kFormat, where, "no 'player' line");
  }
  file.frames = file.root.frame.back();
  for (std::size_t node = 0; node < kNodes; ++node) {
    if (file.nodes[node].frame.empty()) {
      return base::fail(base::ErrorKind::kFormat, where,
                        fmt::format("no '{}' line", kNodeNames[node]));
    }
    file.frames = std::max(file.frames, file.nodes[node].frame.back());
  }
  if (file.frames < 1) return base::fail(base::ErrorKind::kFormat, where, "no second key");
  if (file.ball && file.ball->first > file.frames) file.ball.reset();
  return file;
}

}  // namespace touchline::sim::people
