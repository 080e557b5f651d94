#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tools/sim/people/asset_files.h"

namespace touchline::sim::people {
namespace {

using nlohmann::json;
constexpr std::size_t kMostBones = 1000;
constexpr std::uint32_t kMostVertex = 200000;

// Nesting is bounded before the parser sees it: its recursion is not.
base::Result<json> parse_json(std::string_view text, const std::string& where) {
  int depth = 0;
  for (const char c : text) {
    depth += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (depth > 64) return base::fail(base::ErrorKind::kLimit, where, "nested too deeply");
  }
  json document = json::parse(text.begin(), text.end(), nullptr, false);
  if (document.is_discarded() || !document.is_object()) {
    return base::fail(base::ErrorKind::kFormat, where, "not a JSON object");
  }
  return document;
}

const json* member(const json& object, const std::string& key) {
  if (!object.is_object()) return nullptr;
  const auto found = object.find(key);
  return found == object.end() ? nullptr : &*found;
}

bool read_vertices(const json* list, std::vector<std::uint32_t>& out) {
  if (list == nullptr || !list->is_array() || list->empty() || list->size() > 1000) return false;
  for (const json& v : *list) {
    if (!v.is_number_unsigned() || v.get<std::uint64_t>() >= kMostVertex) return false;
    out.push_back(v.get<std::uint32_t>());
  }
  return true;
}

}  // namespace

base::Result<SkeletonFile> parse_skeleton(std::string_view text, const std::string& where) {
  const auto document = parse_json(text, where);
  if (!document) return base::fail(document.error());
  const json* bones = member(*document, "bones");
  const json* joints = member(*document, "joints");
  if (bones == nullptr || joints == nullptr || !bones->is_object() || bones->size() > kMostBones) {
    return base::fail(base::ErrorKind::kFormat, where, "no 'bones' and 'joints', or too many");
  }
  SkeletonFile file;
  std::map<std::string, int> index;
  // Parents first: as often round as the tree is deep.
  for (bool grown = true; grown;) {
    grown = false;
    for (const auto& [name, bone] : bones->items()) {
      if (index.count(name) > 0) continue;
      const json* parent = member(bone, "parent");
      int parent_index = -1;
      if (parent != nullptr && parent->is_string()) {
        const auto found = index.find(parent->get<std::string>());
        if (found == index.end()) continue;
        parent_index = found->second;
      }
      SkeletonFile::Bone out{name, parent_index, {}, {}};
      const json* head = member(bone, "head");
      const json* tail = member(bone, "tail");
      if (head == nullptr || tail == nullptr || !head->is_string() || !tail->is_string() ||
          !read_vertices(member(*joints, head->get<std::string>()), out.head) ||
          !read_vertices(member(*joints, tail->get<std::string>()), out.tail)) {
        return base::fail(base::ErrorKind::kFormat, where,
                          fmt::format("bone '{}' has no ends", name));
      }
      index[name] = static_cast<int>(file.bones.size());
      file.bones.push_back(std::move(out));
      grown = true;
    }
  }
  if (file.bones.size() != bones->size() || file.bones.empty()) {
    return base::fail(base::ErrorKind::kFormat, where,
                      "a bone's parent is missing or its own child");
  }
  return file;
}

base::Result<WeightsFile> parse_weights(std::string_view text, const std::string& where) {
  const auto document = parse_json(text, where);
  if (!document) return base::fail(document.error());
  const json* weights = member(*document, "weights");
  if (weights == nullptr || !weights->is_object() || weights->size() > kMostBones) {
    return base::fail(base::ErrorKind::kFormat, where, "no 'weights', or too many bones");
  }
  WeightsFile file;
  for (const auto& [bone, list] : weights->items()) {
    auto& out = file[bone];
    bool good = list.is_array() && list.size() <= kMostVertex;
    for (std::size_t i = 0; good && i < list.size(); ++i) {
      const json& pair = list[i];
      good = pair.is_array() && pair.size() == 2 && pair[0].is_number_unsigned() &&
             pair[0].get<std::uint64_t>() < kMostVertex && pair[1].is_number();
      if (!good) break;
      const double weight = pair[1].get<double>();
      good = weight >= 0 && weight <= 1.001;
      if (weight > 0) out.emplace_back(pair[0].get<std::uint32_t>(), static_cast<float>(weight));
    }
    if (!good) {
      return base::fail(base::ErrorKind::kFormat, where,
                        fmt::format("weights of '{}' are not [vertex, 0..1] pairs", bone));
    }
  }
  return file;
}

}  // namespace touchline::sim::people
