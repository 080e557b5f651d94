#include "tools/score/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "shared/recording/camera_table.h"

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
                           ScoreReport& report) {
  for (const recording::CameraEntry& entry : recording.cameras) {
    const fs::path path = options.exports / "cameras" / (entry.id.value + ".csv");
    if (!is_there(path)) {
      report.not_scored.push_back(fmt::format("camera {}: no {}", entry.id.value, path.string()));
      continue;
    }
    auto rows = recording::read_camera_table(path);
    if (!rows) return base::fail(rows.error());
    report.cameras.push_back(score_camera(entry.id, truth, *rows, pitch));
  }
  return {};
}

base::Status score_mattes(const recording::Recording& recording, const Truth& truth,
                          const ScoreOptions& options, ScoreReport& report) {
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
    MatteScore score;
    score.camera = entry.id.value;
    for (const std::int64_t frame : spread(frames, options.most_mattes)) {
      const auto should = truth.matte(entry.id, frame);
      if (!should) continue;  // the truth has no matte of this frame
      const fs::path path = numbered(folder, frame, ".png");
      if (!is_there(path)) {
        ++score.missing;
        continue;
      }
      const auto is = read_grey_png(path);
      if (!is) return base::fail(is.error());
      if (is->width() != should->width() || is->height() != should->height()) {
        return base::fail(base::ErrorKind::kFormat, path.string(),
                          fmt::format("is {} x {}, the truth {} x {}", is->width(), is->height(),
                                      should->width(), should->height()));
      }
      add_matte(score, *should, *is);
    }
    report.mattes.push_back(std::move(score));
  }
  return {};
}

base::Status score_hulls(const recording::Recording& recording, const Truth& truth,
                         const ScoreOptions& options, ScoreReport& report) {
  const fs::path folder = options.exports / "hull";
  if (!is_there(folder)) {
    report.not_scored.push_back(fmt::format("hull: no {}", folder.string()));
    return {};
  }
  for (const std::int64_t frame : spread(truth.mesh_frames(), options.most_hulls)) {
    const fs::path path = numbered(folder, frame, ".ply");
    if (!is_there(path)) {
      report.not_scored.push_back(fmt::format("hull: no {}", path.string()));
      continue;
    }
    const auto hull = read_ply(path);
    if (!hull) return base::fail(hull.error());
    const auto mesh = truth.mesh(frame);
    if (!mesh) return base::fail(mesh.error());
    std::vector<geometry::CameraEstimate> cameras;
    for (const recording::CameraEntry& entry : recording.cameras) {
      if (const auto camera = truth.camera(entry.id, frame)) cameras.push_back(*camera);
    }
    report.hulls.push_back(score_hull(*hull, *mesh, truth.people(frame), cameras, options.voxel_m));
    report.hulls.back().frame = frame;
  }
  return {};
}

base::Status score_views(const Truth& truth, const ScoreOptions& options, ScoreReport& report) {
  for (const base::CameraId& camera : truth.virtual_cameras()) {
    const fs::path folder = options.exports / "renders" / camera.value;
    if (!is_there(folder)) {
      report.not_scored.push_back(fmt::format("view {}: no {}", camera.value, folder.string()));
      continue;
    }
    std::vector<std::int64_t> frames = truth.clean_frames(camera);
    std::erase_if(frames, [&](std::int64_t f) { return !is_there(numbered(folder, f, ".png")); });
    CameraViews views;
    views.camera = camera.value;
    for (const std::int64_t frame : spread(frames, options.most_views)) {
      const fs::path path = numbered(folder, frame, ".png");
      const auto clean = truth.clean(camera, frame);
      if (!clean) return base::fail(clean.error());
      const auto rendered = read_rgb_png(path);
      if (!rendered) return base::fail(rendered.error());
      if (rendered->width() != clean->width() || rendered->height() != clean->height()) {
        return base::fail(base::ErrorKind::kFormat, path.string(),
                          fmt::format("is {} x {}, the clean picture {} x {}", rendered->width(),
                                      rendered->height(), clean->width(), clean->height()),
                          "render without --size");
      }
      std::optional<image::Image<std::uint8_t>> matte;
      if (auto read = truth.matte(camera, frame)) matte = std::move(*read);
      views.frames.push_back(score_view(*clean, *rendered, matte));
      views.frames.back().frame = frame;
    }
    report.views.push_back(std::move(views));
  }
  return {};
}

template <typename Items, typename Value>
double mean_of(const Items& items, Value value) {
  double sum = 0;
  for (const auto& item : items) sum += value(item);
  return items.empty() ? 0 : sum / static_cast<double>(items.size());
}

}  // namespace

base::Result<ScoreReport> score_exports(const recording::Recording& recording, const Truth& truth,
                                        const ScoreOptions& options) {
  const auto pitch = pitch::make_pitch(recording.sport, recording.sizes);
  if (!pitch) return base::fail(pitch.error());
  ScoreReport report;
  report.recording = recording.name;
  for (const base::Status& status :
       {score_cameras(recording, truth, *pitch, options, report),
        score_mattes(recording, truth, options, report),
        score_hulls(recording, truth, options, report), score_views(truth, options, report)}) {
    if (!status) return base::fail(status.error());
  }
  const fs::path people = options.exports / "people" / "people.csv";
  if (is_there(people)) {
    const auto told = read_people(people);
    if (!told) return base::fail(told.error());
    std::vector<base::CameraId> cameras;
    for (const recording::CameraEntry& entry : recording.cameras) cameras.push_back(entry.id);
    report.people = score_people(*told, truth, cameras);
  } else {
    report.not_scored.push_back(fmt::format("people: no {}", people.string()));
  }
  return report;
}

std::string table_text(const ScoreReport& report) {
  std::string out = fmt::format("recording {}\n", report.recording);
  const auto to = std::back_inserter(out);
  if (!report.cameras.empty()) {
    fmt::format_to(to, "\ncamera     solved   rms median   p95      worst px\n");
    for (const CameraScore& c : report.cameras) {
      fmt::format_to(to, "{:<9} {:>3}/{:<3}   {:>8.3f} {:>8.3f} {:>9.3f}\n", c.camera, c.solved,
                     c.frames, c.median_px, c.p95_px, c.worst_px);
    }
  }
  if (!report.mattes.empty()) {
    fmt::format_to(to, "\nmatte     frames   IoU    boundary px   missing   extra   alpha error\n");
    for (const MatteScore& m : report.mattes) {
      fmt::format_to(to, "{:<9} {:>3}/{:<3} {:>6.3f} {:>10.2f} {:>10.1f}% {:>6.1f}% {:>10.3f}\n",
                     m.camera, m.frames, m.frames + m.missing, m.iou(), m.mean_boundary_px(),
                     100 * m.missing_share(), 100 * m.extra_share(), m.mean_alpha_error());
    }
  }
  if (!report.hulls.empty()) {
    fmt::format_to(to,
                   "\nhull    people   inside least   mean    all      components  phantoms  m3\n");
    for (const HullScore& h : report.hulls) {
      fmt::format_to(to, "{:06} {:>6} {:>13.2f}% {:>6.2f}% {:>6.2f}% {:>10} {:>9} {:>7.2f}\n",
                     h.frame, h.people.size(), 100 * h.least_share(), 100 * h.mean_share(),
                     100 * h.all_share, h.components, h.phantoms, h.volume_m3);
    }
  }
  if (report.people) {
    const PeopleScore& p = *report.people;
    fmt::format_to(
        to,
        "\npeople    found {}/{} seen, {} extra, {} changes of id, error median {:.3f} m, "
        "p95 {:.3f} m\n",
        p.found, p.expected, p.extra, p.id_changes, p.median_m, p.p95_m);
    fmt::format_to(to, "ball      found {}/{}, error median {:.3f} m\n", p.ball_found,
                   p.ball_frames, p.ball_median_m);
  }
  if (!report.views.empty()) {
    fmt::format_to(to,
                   "\nview         frames   people PSNR   SSIM    aligned by   PSNR    full PSNR   "
                   "SSIM\n");
    for (const CameraViews& v : report.views) {
      fmt::format_to(to,
                     "{:<12} {:>6} {:>10.2f} dB {:>6.3f} {:>6.1f},{:<5.1f} {:>6.2f} {:>9.2f} "
                     "dB {:>6.3f}\n",
                     v.camera, v.frames.size(),
                     mean_of(v.frames, [](const ViewScore& s) { return s.psnr_db; }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.ssim; }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.shift_px.x(); }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.shift_px.y(); }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.shifted_psnr_db; }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.full_psnr_db; }),
                     mean_of(v.frames, [](const ViewScore& s) { return s.full_ssim; }));
    }
  }
  for (const std::string& line : report.not_scored) {
    fmt::format_to(to, "not scored: {}\n", line);
  }
  return out;
}

}  // namespace touchline::score
