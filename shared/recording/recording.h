// A recording: recorded frames of one event in a folder, described by recording.toml (formats.md).
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "shared/base/ids.h"
#include "shared/base/result.h"
#include "shared/base/time.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::recording {

enum class Role : std::uint8_t { kMatch, kFixed, kCloseup };
// Where a camera stands: y < 0, y > 0, x < 0, x > 0.
enum class Side : std::uint8_t { kMain, kReverse, kLeft, kRight };

std::string_view name(Role role);  // "match", "fixed", "closeup"
std::string_view name(Side side);  // "main", "reverse", "left", "right"

// One [[camera]]. Paths are absolute; survey, timing and head are empty where the recording has
// none.
struct CameraEntry {
  base::CameraId id;
  Role role = Role::kMatch;
  Side side = Side::kMain;
  std::filesystem::path video;
  std::filesystem::path survey;  // folder of stills
  std::filesystem::path timing;  // <recording>/<id>/timing.csv
  std::filesystem::path head;    // <recording>/<id>/head.csv
  int width = 0;                 // pixels
  int height = 0;
  base::FrameRate rate;  // the recording's unless the camera states its own
  image::Scan scan = image::Scan::kProgressive;
  std::int64_t offset_ns = 0;  // its frames are exposed this much after the nominal instant
};

struct Recording {
  std::filesystem::path root;  // absolute
  std::string name;
  pitch::Sport sport = pitch::Sport::kSoccer;
  pitch::PitchSizes sizes;
  base::FrameRate rate;
  base::Timecode start_timecode;
  base::MediaTime start;  // start_tai_ns
  std::vector<CameraEntry> cameras;

  const CameraEntry* find(const base::CameraId& id) const;
};

inline constexpr int kRecordingFormatVersion = 1;

// Reads <root>/recording.toml and checks that every file it names is there. `root` may name the
// TOML file itself. All errors are of kind kConfiguration and name file:line and key.
base::Result<Recording> load_recording(const std::filesystem::path& root);

// The same from text, without looking at the disk: timing and head stay empty. `file` names the
// text in errors.
base::Result<Recording> parse_recording(std::string_view text, const std::filesystem::path& root,
                                        const std::string& file);

// The text of recording.toml; paths inside `recording.root` are written relative to it.
std::string recording_text(const Recording& recording);

// Writes <root>/recording.toml, replacing one that is there only when all of it is on disk.
base::Status save_recording(const Recording& recording);

// The stills of a survey folder (.jpg, .jpeg, .png) by rising file name.
base::Result<std::vector<std::filesystem::path>> survey_stills(const CameraEntry& camera);

}  // namespace touchline::recording
