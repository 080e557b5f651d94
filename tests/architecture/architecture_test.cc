// The layout rules of the project, held against the tree: who may include whom, what may stand in a
// public header, what lies at the top level. A failure names file, line and rule.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Line {
  std::string file;  // relative to the root
  int number = 0;
  std::string text;
};

std::string where(const Line& line) {
  return line.file + ":" + std::to_string(line.number) + ": " + line.text;
}

bool starts_with(const std::string& text, const std::string& prefix) {
  return text.rfind(prefix, 0) == 0;
}

const std::vector<std::string>& code_files() {
  static const std::vector<std::string> files = [] {
    std::vector<std::string> found;
    for (const char* side : {"shared", "edge", "hub", "tools", "tests"}) {
      for (const auto& entry :
           fs::recursive_directory_iterator(fs::path(TOUCHLINE_SOURCE_DIR) / side)) {
        const std::string extension = entry.path().extension().string();
        if (entry.is_regular_file() && (extension == ".cc" || extension == ".h")) {
          found.push_back(fs::relative(entry.path(), TOUCHLINE_SOURCE_DIR).generic_string());
        }
      }
    }
    std::sort(found.begin(), found.end());
    return found;
  }();
  return files;
}

std::vector<Line> lines_of(const std::string& file) {
  std::ifstream in(fs::path(TOUCHLINE_SOURCE_DIR) / file);
  std::vector<Line> lines;
  std::string text;
  for (int number = 1; std::getline(in, text); ++number) lines.push_back({file, number, text});
  return lines;
}

// The path between the quotes of an #include of ours; empty for other lines and for <...>.
std::string own_include(const std::string& text) {
  static const std::regex pattern(R"re(^\s*#\s*include\s+"([^"]+)")re");
  std::smatch match;
  return std::regex_search(text, match, pattern) ? match[1].str() : std::string();
}

std::string side_of(const std::string& path) { return path.substr(0, path.find('/')); }

// "edge/key/key.cc" -> "key"; empty for files directly under the side.
std::string stage_of(const std::string& path) {
  const auto first = path.find('/');
  const auto second = path.find('/', first + 1);
  return second == std::string::npos ? std::string() : path.substr(first + 1, second - first - 1);
}

template <typename Predicate>
std::vector<std::string> includes_that(Predicate breaks_rule) {
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    for (const Line& line : lines_of(file)) {
      const std::string included = own_include(line.text);
      if (!included.empty() && breaks_rule(file, included)) broken.push_back(where(line));
    }
  }
  return broken;
}

TEST(Architecture, SharedIncludesNeitherEdgeNorHub) {
  EXPECT_THAT(includes_that([](const std::string& file, const std::string& included) {
                return side_of(file) == "shared" &&
                       (side_of(included) == "edge" || side_of(included) == "hub");
              }),
              testing::IsEmpty());
}

TEST(Architecture, EdgeAndHubNeverIncludeEachOther) {
  EXPECT_THAT(includes_that([](const std::string& file, const std::string& included) {
                return (side_of(file) == "edge" && side_of(included) == "hub") ||
                       (side_of(file) == "hub" && side_of(included) == "edge");
              }),
              testing::IsEmpty());
}

TEST(Architecture, StagesNeverIncludeEachOther) {
  EXPECT_THAT(includes_that([](const std::string& file, const std::string& included) {
                const std::string side = side_of(file);
                if ((side != "edge" && side != "hub") || side_of(included) != side) return false;
                const std::string from = stage_of(file), to = stage_of(included);
                if (from.empty() || to.empty() || from == to) return false;
                return to != (side == "edge" ? "state" : "scene");
              }),
              testing::IsEmpty());
}

TEST(Architecture, SharedLayersIncludeOnlyDownward) {
  const std::vector<std::string> order = {"base",  "config", "geometry",  "pitch",  "image",
                                          "codec", "wire",   "recording", "runtime"};
  const auto rank = [&](const std::string& folder) {
    return std::find(order.begin(), order.end(), folder) - order.begin();
  };
  EXPECT_THAT(includes_that([&](const std::string& file, const std::string& included) {
                return side_of(file) == "shared" && side_of(included) == "shared" &&
                       rank(stage_of(included)) > rank(stage_of(file));
              }),
              testing::IsEmpty());
}

TEST(Architecture, CalibrationIncludesOnlyDownward) {
  const std::string folder = "edge/calibrate/";
  const std::map<std::string, std::set<std::string>> below = {
      {"lines", {}},
      {"fit", {"lines"}},
      {"initialise", {"lines"}},
      {"survey", {"lines", "fit", "initialise"}},
      {"track", {"lines", "fit"}},
      {"texture", {"lines", "fit"}},
      {"peers", {"lines", "fit"}}};
  const auto part_of = [&](const std::string& path) { return stage_of(path.substr(5)); };
  EXPECT_THAT(includes_that([&](const std::string& file, const std::string& included) {
                if (!starts_with(file, folder) || !starts_with(included, folder)) return false;
                const std::string from = part_of(file), to = part_of(included);
                if (from.empty() || from == to) return false;  // the calibrator sees all of them
                return below.at(from).count(to) == 0;
              }),
              testing::IsEmpty());
}

TEST(Architecture, WireKnowsNoCodecAndCodecNoWire) {
  EXPECT_THAT(
      includes_that([](const std::string& file, const std::string& included) {
        return (starts_with(file, "shared/wire/") && starts_with(included, "shared/codec/")) ||
               (starts_with(file, "shared/codec/") && starts_with(included, "shared/wire/"));
      }),
      testing::IsEmpty());
}

TEST(Architecture, ProductIncludesNeitherTestsNorTools) {
  EXPECT_THAT(includes_that([](const std::string& file, const std::string& included) {
                const std::string side = side_of(file);
                return (side == "shared" || side == "edge" || side == "hub") &&
                       (side_of(included) == "tests" || side_of(included) == "tools");
              }),
              testing::IsEmpty());
}

TEST(Architecture, IncludesAreRelativeToTheRoot) {
  const std::set<std::string> roots = {"shared", "edge", "hub", "tools", "tests"};
  EXPECT_THAT(
      includes_that([&](const std::string& file, const std::string& included) {
        // Code generated from the schema lies in the build folder under its own name.
        if (file.find("shared/wire/") != std::string::npos && starts_with(included, "touchline"))
          return false;
        return roots.count(side_of(included)) == 0;
      }),
      testing::IsEmpty());
}

TEST(Architecture, PublicHeadersShowStdAndEigenOnly) {
  const std::regex foreign(
      R"((\bcv::|\bdraco::|\beprosima::|\bceres::|\btoml::|\bnlohmann::|\btbb::|\bspdlog::|\bCLI::|\bAV[A-Z][A-Za-z]+|\bsqlite3|\bRTC[A-Z]|#include <(opencv|draco|fastdds|fastrtps|ceres|toml|nlohmann|tbb|oneapi|spdlog|CLI|libav|sqlite|embree)))");
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    const std::string side = side_of(file);
    if (side == "tests" || side == "tools" || fs::path(file).extension() != ".h") continue;
    if (file.size() > 11 && file.compare(file.size() - 11, 11, "_internal.h") == 0) continue;
    for (const Line& line : lines_of(file)) {
      const std::string code = line.text.substr(0, line.text.find("//"));
      if (std::regex_search(code, foreign)) broken.push_back(where(line));
    }
  }
  EXPECT_THAT(broken, testing::IsEmpty());
}

TEST(Architecture, EveryHeaderIsGuardedAndExplained) {
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    if (fs::path(file).extension() != ".h") continue;
    const auto lines = lines_of(file);
    if (lines.empty() || !starts_with(lines.front().text, "//"))
      broken.push_back(file + ": no purpose in its first line");
    if (std::none_of(lines.begin(), lines.end(),
                     [](const Line& l) { return l.text == "#pragma once"; })) {
      broken.push_back(file + ": no #pragma once");
    }
  }
  EXPECT_THAT(broken, testing::IsEmpty());
}

TEST(Architecture, LibrariesNeitherPrintNorAbortNorDetach) {
  const std::regex forbidden(
      R"((\bstd::cout\b|\bstd::cerr\b|\b[fs]?printf\s*\(|\bputs\s*\(|\bstd::abort\b|\babort\s*\(\)|\.detach\s*\(\)|\busing namespace\b|\bget_instance\b))");
  // The wire adapter has to ask the DDS library's factory for its instance.
  const std::regex allowed(R"(DomainParticipantFactory::get_instance)");
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    const std::string side = side_of(file);
    if (side == "tests" || side == "tools" || stage_of(file).empty()) continue;
    for (const Line& line : lines_of(file)) {
      const std::string code = line.text.substr(0, line.text.find("//"));
      if (std::regex_search(code, forbidden) && !std::regex_search(code, allowed))
        broken.push_back(where(line));
    }
  }
  EXPECT_THAT(broken, testing::IsEmpty());
}

TEST(Architecture, TestsDoNotSleep) {
  const std::regex forbidden(R"(\b(sleep_for|sleep_until|usleep|nanosleep)\b)");
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    if (side_of(file) != "tests" || starts_with(file, "tests/architecture/")) continue;
    for (const Line& line : lines_of(file)) {
      if (std::regex_search(line.text, forbidden)) broken.push_back(where(line));
    }
  }
  EXPECT_THAT(broken, testing::IsEmpty());
}

TEST(Architecture, StagesDoNotKnowTheTruth) {
  const std::regex forbidden(R"re("[^"]*\b(truth|simulator)\b[^"]*"|\b(truth|simulator)/)re");
  std::vector<std::string> broken;
  for (const std::string& file : code_files()) {
    const std::string side = side_of(file);
    if (side != "edge" && side != "hub" && side != "shared") continue;
    for (const Line& line : lines_of(file)) {
      if (std::regex_search(line.text, forbidden)) broken.push_back(where(line));
    }
  }
  EXPECT_THAT(broken, testing::IsEmpty());
}

TEST(Architecture, TopLevelIsAsAgreed) {
  const std::set<std::string> agreed = {"CMakeLists.txt",
                                        "CMakePresets.json",
                                        "CONTRIBUTING.md",
                                        "LICENSE",
                                        "README.md",
                                        "edge",
                                        "firmware-config",
                                        "hub",
                                        "shared",
                                        "tests",
                                        "tools",
                                        "build",
                                        "out"};
  std::vector<std::string> strays;
  for (const auto& entry : fs::directory_iterator(TOUCHLINE_SOURCE_DIR)) {
    const std::string name = entry.path().filename().string();
    if (name.front() != '.' && agreed.count(name) == 0) strays.push_back(name);
  }
  EXPECT_THAT(strays, testing::IsEmpty());
}

}  // namespace
