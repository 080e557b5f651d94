#include "tools/score/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "shared/recording/camera_table.h"
#include "tools/score/camera_score.h"
#include "tools/score/hull_score.h"
#include "tools/score/matte_score.h"
#include "tools/score/people_score.h"
#include "tools/score/view_score.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

fs::path numbered(const fs::path& folder, std::int64_t frame, const char* extension) {
  return folder / fmt::format("{:06}{}", frame, extension);
}

// At most `most` of the frames, spread evenly; all for 0.
std::vector<std::int64_t> spread(const std::vector<std::int64_t>& frames, std::size_t most) {
  if (most == 0 || frames.size() <= most) return frames;
  std::vector<std::int64_t> out;
  for (std::size_t i = 0; i < most; ++i) out.push_back(frames[i * frames.size() / most]);
  return out;
}

base::Status score_cameras(const recording::Recording& recording, const Truth& truth,
                           const pitch::PitchModel& pitch, const ScoreOptions& options,
                           SeriesBook& book, ScoreReport& report) {
  const ScoreKind rms{"cameras", "rms on a 1 m grid", "px"};
  for (const recording::CameraEntry& entry : recording.cameras) {
    const fs::path path = options.exports / "cameras" / (entry.id.value + ".csv");
    if (!is_there(path)) {
      report.not_scored.push_back(fmt::format("camera {}: no {}", entry.id.value, path.string()));
      continue;
    }
    auto rows = recording::read_camera_table(path);
    if (!rows) return base::fail(rows.error());
    for (const recording::CameraRow& row : *rows) {
      const auto should = truth.camera(entry.id, row.frame);
      if (!should || (row.report && row.report->state == geometry::Evidence::kLost)) continue;
      geometry::CameraEstimate estimate;
      estimate.model = row.model;
      estimate.cam_from_world = row.cam_from_world;
      if (const auto value = grid_rms_px(*should, estimate, pitch)) {
        book.add(rms, entry.id.value, {row.frame, *value});
      }
    }
  }
  return {};
}

base::Status score_mattes(const recording::Recording& recording, const Truth& truth,
                          const ScoreOptions& options, SeriesBook& book, ScoreReport& report) {
  const ScoreKind overlap{"mattes", "IoU at 0.5", "%", Better::kHigher};
  const ScoreKind boundary{"mattes", "boundary distance", "px"};
  for (const recording::CameraEntry& entry : recording.cameras) {
    const fs::path folder = options.exports / "mattes" / entry.id.value;
    if (!is_there(folder)) {
      report.not_scored.push_back(fmt::format("matte {}: no {}", entry.id.value, folder.string()));
      continue;
    }
    std::vector<std::int64_t> frames;
    for (std::size_t f = 0; f < truth.camera_rows(entry.id); ++f) {
      frames.push_back(static_cast<std::int64_t>(f));
    }
    for (const std::int64_t frame : spread(frames, options.most_mattes)) {
      const auto should = truth.matte(entry.id, frame);
      const fs::path path = numbered(folder, frame, ".png");
      if (!should || !is_there(path)) continue;
      const auto is = read_grey_png(path);
      if (!is) return base::fail(is.error());
      if (is->width() != should->width() || is->height() != should->height()) {
        return base::fail(base::ErrorKind::kFormat, path.string(),
                          fmt::format("is {} x {}, the truth {} x {}", is->width(), is->height(),
                                      should->width(), should->height()));
      }
      MatteScore score;
      add_matte(score, *should, *is);
      book.add(overlap, entry.id.value,
               {frame, 100 * score.iou(), score.true_px + score.found_px - score.both_px});
      book.add(boundary, entry.id.value, {frame, score.mean_boundary_px(), score.boundary_count});
    }
  }
  return {};
}

}  // namespace

const Series* ScoreReport::find(const std::string& group, const std::string& score,
                                const std::string& subject) const {
  const auto at = std::find_if(series.begin(), series.end(), [&](const Series& s) {
    return s.kind.group == group && s.kind.score == score && s.subject == subject;
  });
  return at == series.end() ? nullptr : &*at;
}

base::Result<ScoreReport> score_exports(const recording::Recording& recording, const Truth& truth,
                                        const ScoreOptions& options) {
  const auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  ScoreReport report;
  report.recording = recording.name;
  SeriesBook book;
  for (const base::Status& status : {score_cameras(recording, truth, *pitch, options, book, report),
                                     score_mattes(recording, truth, options, book, report)}) {
    if (!status) return base::fail(status.error());
  }
  report.series = book.finish();
  return report;
}

}  // namespace touchline::score
