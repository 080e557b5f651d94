// What every part of the scorer works on.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "shared/pitch/pitch_model.h"
#include "shared/recording/recording.h"
#include "tools/score/frame_clocks.h"
#include "tools/score/report.h"
#include "tools/score/series.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct Context {
  const recording::Recording& recording;
  const Truth& truth;
  const pitch::PitchModel& pitch;
  const FrameClocks& clocks;
  const ScoreOptions& options;

  // The true camera at an instant of the recording.
  std::optional<geometry::CameraEstimate> camera(const base::CameraId& id,
                                                 std::int64_t instant) const {
    const auto frame = clocks.video_frame(id, instant);
    return frame ? truth.camera(id, *frame) : std::nullopt;
  }
  // The true cameras of an instant, those that there are.
  std::vector<geometry::CameraEstimate> cameras(std::int64_t instant) const {
    std::vector<geometry::CameraEstimate> found;
    for (const recording::CameraEntry& entry : recording.cameras) {
      if (const auto one = camera(entry.id, instant)) found.push_back(*one);
    }
    return found;
  }
  // Instants at which the camera has a true row, rising.
  std::vector<std::int64_t> instants(const base::CameraId& id) const;
};

// What a part of the scorer adds besides series.
struct Remarks {
  std::vector<std::string> not_scored;
  std::vector<std::string> notes;
};

inline bool is_there(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}
inline std::filesystem::path numbered(const std::filesystem::path& folder, std::int64_t frame,
                                      const char* extension) {
  return folder / fmt::format("{:06}{}", frame, extension);
}
// At most `most` of the frames, spread evenly; all for 0.
std::vector<std::int64_t> spread(const std::vector<std::int64_t>& frames, std::size_t most);

base::Status score_cameras(const Context& context, SeriesBook& book, Remarks& remarks);
base::Status score_mattes(const Context& context, SeriesBook& book, Remarks& remarks);
base::Status score_hulls(const Context& context, SeriesBook& book, Remarks& remarks);
base::Status score_people(const Context& context, SeriesBook& book, Remarks& remarks);
// Fills `oracle` with the same scores of our renderer on true cameras and mattes.
base::Status score_views(const Context& context, SeriesBook& book, SeriesBook& oracle,
                         Remarks& remarks);

}  // namespace touchline::score
