#include "tools/score/report.h"

#include <algorithm>
#include <array>

#include "tools/score/score_context.h"

namespace touchline::score {

std::vector<std::int64_t> Context::instants(const base::CameraId& id) const {
  const std::vector<std::int64_t> frames = truth.camera_frames(id);
  if (frames.empty()) return {};
  std::vector<std::int64_t> out = clocks.instants(id, frames.back());
  std::erase_if(out, [&](std::int64_t instant) { return !camera(id, instant); });
  return out;
}

std::vector<std::int64_t> spread(const std::vector<std::int64_t>& frames, std::size_t most) {
  if (most == 0 || frames.size() <= most) return frames;
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(frames[i * frames.size() / most]);
  return out;
}

const Series* ScoreReport::find(const std::string& group, const std::string& score,
                                const std::string& subject) const {
  const Series* any = nullptr;
  for (const Series& s : series) {
    if (s.kind.group != group || s.kind.score != score) continue;
    if (s.subject == subject) return &s;
    any = &s;
  }
  return subject == "all" ? any : nullptr;  // a kind of one subject has no series "all"
}

base::Result<ScoreReport> score_exports(const recording::Recording& recording, const Truth& truth,
                                        const ScoreOptions& options) {
  const auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  const auto clocks = FrameClocks::open(recording);
  if (!clocks) return base::fail(clocks.error());
  const Context context{recording, truth, *pitch, *clocks, options};
  SeriesBook book;
  SeriesBook oracle;
  Remarks remarks;
  using Part = base::Status (*)(const Context&, SeriesBook&, Remarks&);
  constexpr std::array<Part, 4> kParts = {score_cameras, score_mattes, score_hulls, score_people};
  for (const Part part : kParts) {
    if (const base::Status status = part(context, book, remarks); !status) {
      return base::fail(status.error());
    }
  }
  if (const auto status = score_views(context, book, oracle, remarks); !status) {
    return base::fail(status.error());
  }
  ScoreReport report;
  report.recording = recording.name;
  report.series = book.finish();
  for (Series& beside : oracle.finish()) {
    const auto same =
        std::find_if(report.series.begin(), report.series.end(), [&](const Series& s) {
          return s.kind.group == beside.kind.group && s.kind.score == beside.kind.score &&
                 s.subject == beside.subject;
        });
    if (same != report.series.end()) same->oracle = beside.summary;
  }
  report.not_scored = std::move(remarks.not_scored);
  report.notes = std::move(remarks.notes);
  return report;
}

}  // namespace touchline::score
