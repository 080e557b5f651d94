#include "shared/recording/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <system_error>

#include "shared/config/toml_document.h"
#include "shared/recording/csv_internal.h"

namespace touchline::recording {
namespace {

namespace fs = std::filesystem;
using config::Table;

constexpr std::int64_t kMostPixels = 16384;  // a side
constexpr std::int64_t kLongestOffsetNs = 60'000'000'000;

base::FrameRate frame_rate(Table& table, base::FrameRate fallback) {
  const auto text = table.optional_text("frame_rate");
  if (!text) return fallback;
  const auto rate = base::parse_frame_rate(*text);
  if (rate && rate->hz() <= 1000) return *rate;
  if (rate) {
    table.reject("frame_rate", "'" + *text + "' is more than 1000 frames a second");
  } else {
    table.reject("frame_rate", rate.error().what, rate.error().cure);
  }
  return fallback;
}

void check_timecode(Table& table, const std::string& text, Recording& recording) {
  const auto timecode = base::parse_timecode(text);
  if (!timecode) {
    table.reject("start_timecode", timecode.error().what, timecode.error().cure);
    return;
  }
  const base::FrameRate rate = recording.rate;
  const std::int64_t fps = (rate.num + rate.den / 2) / rate.den;
  const bool may_drop = rate.den == 1001 && (rate.num == 30000 || rate.num == 60000);
  const bool label_dropped = timecode->drop_frame && may_drop && timecode->seconds == 0 &&
                             timecode->minutes % 10 != 0 && timecode->frames < fps / 15;
  if (timecode->frames >= fps) {
    table.reject("start_timecode", "'" + text + "' has no such frame at " + to_string(rate),
                 "frames count from 00 to the rate less one");
  } else if (timecode->drop_frame && !may_drop) {
    table.reject("start_timecode", "'" + text + "' is drop-frame at " + to_string(rate),
                 "drop-frame exists at 30000/1001 and 60000/1001; write ':' before the frames");
  } else if (label_dropped) {
    table.reject("start_timecode", "'" + text + "' is a label that drop-frame leaves out");
  } else {
    recording.start_timecode = *timecode;
  }
}

// A path of the file, resolved; empty and a complaint when it cannot be one.
fs::path path_of(Table& table, std::string_view key, const std::string& text,
                 const fs::path& root) {
  if (text.empty() || text.find('\0') != std::string::npos) {
    table.reject(key, "is not a path", "write it relative to the recording's folder");
    return {};
  }
  return (root / fs::path(text)).lexically_normal();
}

CameraEntry read_camera(Table table, const Recording& recording) {
  CameraEntry camera;
  camera.id.value = table.required_text("id");
  if (table.has("id") && !base::is_valid(camera.id)) {
    table.reject("id", "'" + camera.id.value + "' is not a camera id",
                 "use 1 to 32 letters, digits, '-' and '_'");
  }
  camera.role = table.required_choice<Role>(
      "role", Role::kMatch,
      {{"match", Role::kMatch}, {"fixed", Role::kFixed}, {"closeup", Role::kCloseup}});
  camera.side = table.required_choice<Side>("side", Side::kMain,
                                            {{"main", Side::kMain},
                                             {"reverse", Side::kReverse},
                                             {"left", Side::kLeft},
                                             {"right", Side::kRight}});
  const std::string video = table.required_text("video");
  if (table.has("video")) camera.video = path_of(table, "video", video, recording.root);
  camera.width = static_cast<int>(table.required_integer("width", {16, kMostPixels}));
  camera.height = static_cast<int>(table.required_integer("height", {16, kMostPixels}));
  if (const auto survey = table.optional_text("survey")) {
    camera.survey = path_of(table, "survey", *survey, recording.root);
  }
  camera.rate = frame_rate(table, recording.rate);
  camera.scan = table.choice<image::Scan>("scan", image::Scan::kProgressive,
                                          {{"progressive", image::Scan::kProgressive},
                                           {"tff", image::Scan::kTopFirst},
                                           {"bff", image::Scan::kBottomFirst}});
  camera.offset_ns = table.integer("offset_ns", 0, {-kLongestOffsetNs, kLongestOffsetNs});
  return camera;
}

void check_ids(std::vector<Table>& tables, const std::vector<CameraEntry>& cameras) {
  std::map<std::string, std::size_t> seen;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const std::string& id = cameras[i].id.value;
    if (id.empty()) continue;
    const auto [place, fresh] = seen.emplace(id, i);
    if (!fresh) {
      tables[i].reject(
          "id", "'" + id + "' is already the id of camera[" + std::to_string(place->second) + "]",
          "give every camera its own id");
    }
  }
}

void check_pitch(Table& root, Table& table, const Recording& recording) {
  const auto model = pitch::make_pitch(recording.sport, recording.sizes);
  if (model) return;
  const std::string& where = model.error().where;
  const std::string key = where.substr(where.rfind('.') + 1);
  (table.present() ? table : root).reject(key, model.error().what, model.error().cure);
}

void find_files(Table& table, CameraEntry& camera, const fs::path& root) {
  std::error_code code;
  if (!camera.video.empty() && !fs::is_regular_file(camera.video, code)) {
    table.reject("video", "there is no file " + camera.video.string(),
                 "copy the video of camera '" + camera.id.value + "' there or correct the path");
  }
  if (!camera.survey.empty() && !fs::is_directory(camera.survey, code)) {
    table.reject("survey", "there is no folder " + camera.survey.string(),
                 "copy the stills of camera '" + camera.id.value + "' there or remove the key");
  }
  if (!base::is_valid(camera.id)) return;
  const fs::path timing = root / camera.id.value / "timing.csv";
  const fs::path head = root / camera.id.value / "head.csv";
  if (fs::is_regular_file(timing, code)) camera.timing = timing;
  if (fs::is_regular_file(head, code)) camera.head = head;
}

base::Result<Recording> read_document(const config::Document& document, const fs::path& root_path,
                                      bool look_at_disk) {
  Table root = document.root();
  Recording recording;
  recording.root = root_path;
  const std::int64_t version = root.required_integer("format_version");
  if (root.has("format_version") && version != kRecordingFormatVersion) {
    root.reject("format_version", std::to_string(version) + " is not known",
                "this version reads format " + std::to_string(kRecordingFormatVersion));
    // Other keys of another version mean nothing here.
    const auto status = document.finish();
    return base::fail(base::ErrorKind::kConfiguration,
                      status ? root_path.string() : status.error().where,
                      "format_version: " + std::to_string(version) + " is not known",
                      "this version reads format " + std::to_string(kRecordingFormatVersion));
  }
  recording.name = root.required_text("name");
  recording.sport = root.required_choice<pitch::Sport>(
      "sport", pitch::Sport::kSoccer,
      {{"soccer", pitch::Sport::kSoccer}, {"rugby", pitch::Sport::kRugbyUnion}});
  root.required_text("frame_rate");
  recording.rate = frame_rate(root, recording.rate);
  check_timecode(root, root.text("start_timecode", "00:00:00:00"), recording);
  // Half the range of the type: sums with frame times stay inside it.
  constexpr std::int64_t kFarthest = std::numeric_limits<std::int64_t>::max() / 2;
  recording.start.ns = root.integer("start_tai_ns", 0, {-kFarthest, kFarthest});

  Table sizes = root.table("pitch");
  recording.sizes.length_m = sizes.optional_number("length_m");
  recording.sizes.width_m = sizes.optional_number("width_m");
  recording.sizes.in_goal_m = sizes.optional_number("in_goal_m");
  recording.sizes.crown_m = sizes.optional_number("crown_m");
  recording.sizes.line_m = sizes.optional_number("line_m");
  check_pitch(root, sizes, recording);

  std::vector<Table> tables = root.tables("camera");
  if (tables.empty()) root.reject("camera", "there is no camera", "add a [[camera]] for each");
  for (Table& table : tables) {
    recording.cameras.push_back(read_camera(table, recording));
    if (look_at_disk) find_files(table, recording.cameras.back(), recording.root);
  }
  check_ids(tables, recording.cameras);
  if (auto status = document.finish(); !status) return base::fail(status.error());
  return recording;
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      constexpr char kHex[] = "0123456789ABCDEF";
      const auto byte = static_cast<unsigned char>(c);
      out += "\\u00";
      out += kHex[byte >> 4];
      out += kHex[byte & 15];
    } else {
      out += c;
    }
  }
  return out + '"';
}

// Always with a decimal point, as a TOML float; the shortest text that reads back the same.
std::string real(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string relative_to(const fs::path& path, const fs::path& root) {
  const fs::path relative = path.lexically_relative(root);
  return (relative.empty() || *relative.begin() == "..") ? path.generic_string()
                                                         : relative.generic_string();
}

std::string_view name(image::Scan scan) {
  switch (scan) {
    case image::Scan::kTopFirst:
      return "tff";
    case image::Scan::kBottomFirst:
      return "bff";
    case image::Scan::kProgressive:
      break;
  }
  return "progressive";
}

}  // namespace

std::string_view name(Role role) {
  switch (role) {
    case Role::kMatch:
      return "match";
    case Role::kFixed:
      return "fixed";
    case Role::kCloseup:
      return "closeup";
  }
  return "unknown";
}

std::string_view name(Side side) {
  switch (side) {
    case Side::kMain:
      return "main";
    case Side::kReverse:
      return "reverse";
    case Side::kLeft:
      return "left";
    case Side::kRight:
      return "right";
  }
  return "unknown";
}

const CameraEntry* Recording::find(const base::CameraId& id) const {
  const auto place = std::find_if(cameras.begin(), cameras.end(),
                                  [&](const CameraEntry& camera) { return camera.id == id; });
  return place == cameras.end() ? nullptr : &*place;
}

base::Result<Recording> load_recording(const fs::path& root) {
  std::error_code code;
  const fs::path file = fs::is_regular_file(root, code) ? root : root / "recording.toml";
  if (!fs::is_regular_file(file, code)) {
    return base::fail(base::ErrorKind::kConfiguration, root.string(),
                      "is not a recording: there is no recording.toml in it",
                      "give the folder that holds recording.toml");
  }
  const fs::path absolute = fs::absolute(file, code).lexically_normal();
  const auto document = config::Document::load(file);
  if (!document) return base::fail(document.error());
  return read_document(*document, absolute.parent_path(), true);
}

base::Result<Recording> parse_recording(std::string_view text, const fs::path& root,
                                        const std::string& file) {
  const auto document = config::Document::parse(text, file);
  if (!document) return base::fail(document.error());
  return read_document(*document, root, false);
}

std::string recording_text(const Recording& recording) {
  std::string out = fmt::format("format_version = {}\nname = {}\nsport = \"{}\"\n",
                                kRecordingFormatVersion, quoted(recording.name),
                                recording.sport == pitch::Sport::kSoccer ? "soccer" : "rugby");
  out += fmt::format("frame_rate = \"{}\"\nstart_timecode = \"{}\"\n", to_string(recording.rate),
                     to_string(recording.start_timecode));
  if (recording.start.ns != 0) out += fmt::format("start_tai_ns = {}\n", recording.start.ns);
  out += "\n[pitch]\n";
  const auto size = [&](std::string_view key, const std::optional<double>& value) {
    if (value) out += fmt::format("{} = {}\n", key, real(*value));
  };
  size("length_m", recording.sizes.length_m);
  size("width_m", recording.sizes.width_m);
  size("in_goal_m", recording.sizes.in_goal_m);
  size("crown_m", recording.sizes.crown_m);
  size("line_m", recording.sizes.line_m);
  for (const CameraEntry& camera : recording.cameras) {
    out += fmt::format("\n[[camera]]\nid = {}\nrole = \"{}\"\nside = \"{}\"\nvideo = {}\n",
                       quoted(camera.id.value), name(camera.role), name(camera.side),
                       quoted(relative_to(camera.video, recording.root)));
    out += fmt::format("width = {}\nheight = {}\n", camera.width, camera.height);
    if (!camera.survey.empty()) {
      out += fmt::format("survey = {}\n", quoted(relative_to(camera.survey, recording.root)));
    }
    if (camera.rate != recording.rate) {
      out += fmt::format("frame_rate = \"{}\"\n", to_string(camera.rate));
    }
    if (camera.scan != image::Scan::kProgressive) {
      out += fmt::format("scan = \"{}\"\n", name(camera.scan));
    }
    if (camera.offset_ns != 0) out += fmt::format("offset_ns = {}\n", camera.offset_ns);
  }
  return out;
}

base::Status save_recording(const Recording& recording) {
  return write_file(recording.root / "recording.toml", recording_text(recording));
}

base::Result<std::vector<fs::path>> survey_stills(const CameraEntry& camera) {
  std::vector<fs::path> stills;
  if (camera.survey.empty()) return stills;
  std::error_code code;
  for (fs::directory_iterator entry(camera.survey, code), end; !code && entry != end;
       entry.increment(code)) {
    std::string extension = entry->path().extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; });
    if (extension == ".jpg" || extension == ".jpeg" || extension == ".png") {
      stills.push_back(entry->path());
    }
  }
  if (code) {
    return base::fail(base::ErrorKind::kConfiguration, camera.survey.string(),
                      "cannot be listed: " + code.message());
  }
  std::sort(stills.begin(), stills.end());
  return stills;
}

}  // namespace touchline::recording
