#include "hub/session_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <system_error>
#include <utility>
#include <variant>

#include "hub/output/mp4_writer.h"
#include "hub/output/people_csv.h"
#include "hub/output/ply.h"
#include "hub/output/png.h"
#include "hub/track/people_tracker.h"

namespace touchline::hub {
namespace {

base::Status make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    return base::fail(base::ErrorKind::kIo, folder.string(), "cannot be made: " + error.message(),
                      "choose a folder that can be written");
  }
  return {};
}

std::filesystem::path numbered(const std::filesystem::path& folder, std::int64_t frame,
                               const char* extension) {
  return folder / fmt::format("{:06}{}", frame, extension);
}

void tell(const Progress& progress, std::size_t done, std::size_t all) {
  if (progress) progress(done, all);
}

}  // namespace

base::Status export_cameras(const Shot& shot, const std::filesystem::path& folder,
                            const Progress& progress) {
  if (base::Status status = make_folder(folder); !status) return status;
  std::map<base::CameraId, std::vector<recording::CameraRow>> tables;
  const auto& session = shot.session();
  for (const session::SessionCamera& camera : session.info().cameras) tables[camera.id];
  for (std::size_t i = 0; i < session.instants().size(); ++i) {
    auto set = session.frame_set(i);
    if (!set) return base::fail(set.error());
    for (const scene::FrameSetEntry& entry : set->entries) {
      if (const auto* view = std::get_if<codec::EncodedView>(&entry.view)) {
        tables[entry.camera].push_back(
            recording::camera_row(session.frame_number(i), view->estimate));
      }
    }
    tell(progress, i + 1, session.instants().size());
  }
  for (const auto& [camera, rows] : tables) {
    if (base::Status status = recording::write_camera_table(folder / (camera.value + ".csv"), rows);
        !status) {
      return status;
    }
  }
  return {};
}

base::Status export_mattes(Shot& shot, const std::filesystem::path& folder,
                           const Progress& progress) {
  for (const session::SessionCamera& camera : shot.session().info().cameras) {
    if (base::Status status = make_folder(folder / camera.id.value); !status) return status;
  }
  const std::vector<std::int64_t> frames = shot.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto set = shot.decode(frames[i]);
    if (!set) return base::fail(set.error());
    for (const codec::CameraView& view : set->views) {
      if (!view.matte) continue;
      const auto path = numbered(folder / view.id.camera.value, frames[i], ".png");
      if (base::Status status = output::write_png(path, view.matte->alpha); !status) return status;
    }
    tell(progress, i + 1, frames.size());
  }
  return {};
}

base::Status export_hull(Shot& shot, const std::filesystem::path& folder,
                         const Progress& progress) {
  if (base::Status status = make_folder(folder); !status) return status;
  const std::vector<std::int64_t> frames = shot.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto instant = shot.instant(frames[i]);
    if (!instant) return base::fail(instant.error());
    std::vector<geometry::Mesh> meshes;
    for (const scene::HullGroup& group : (*instant)->hull.groups) {
      if (!group.phantom) meshes.push_back(group.surface);
    }
    if (base::Status status = output::write_ply(numbered(folder, frames[i], ".ply"), meshes);
        !status)
      return status;
    tell(progress, i + 1, frames.size());
  }
  return {};
}

base::Status export_people(Shot& shot, const std::filesystem::path& folder,
                           const Progress& progress) {
  if (base::Status status = make_folder(folder); !status) return status;
  track::PeopleTracker tracker(shot.pitch());
  std::vector<output::PeopleRow> rows;
  const std::vector<std::int64_t> frames = shot.frames();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto instant = shot.instant(frames[i]);
    if (!instant) return base::fail(instant.error());
    const auto people =
        tracker.update((*instant)->hull, (*instant)->set.views, (*instant)->set.instant);
    for (const scene::Person& person : people) rows.push_back({frames[i], person});
    tell(progress, i + 1, frames.size());
  }
  return output::write_people_csv(folder / "people.csv", rows);
}

geometry::CameraEstimate virtual_camera(const recording::CameraRow& row,
                                        const std::optional<std::pair<int, int>>& size) {
  geometry::CameraEstimate camera;
  camera.model = row.model;
  camera.cam_from_world = row.cam_from_world;
  camera.evidence = geometry::Evidence::kEncoder;  // stated, not measured
  if (size) {
    // The same view: pixel areas scale, so centres shift by half a pixel.
    const double sx = static_cast<double>(size->first) / row.model.width;
    const double sy = static_cast<double>(size->second) / row.model.height;
    camera.model.fx *= sx;
    camera.model.fy *= sy;
    camera.model.cx = (row.model.cx + 0.5) * sx - 0.5;
    camera.model.cy = (row.model.cy + 0.5) * sy - 0.5;
    camera.model.width = size->first;
    camera.model.height = size->second;
  }
  return camera;
}

base::Result<PathReport> render_path(Shot& shot, const std::vector<recording::CameraRow>& path,
                                     const std::filesystem::path& folder,
                                     const PathOptions& options, const Progress& progress) {
  if (base::Status status = make_folder(folder); !status) return base::fail(status.error());
  if (path.empty())
    return base::fail(base::ErrorKind::kArgument, "path", "it has no rows", "give a row a picture");
  if (!options.mp4.empty()) {
    for (const recording::CameraRow& row : path) {
      const geometry::CameraModel model = virtual_camera(row, options.size).model;
      const geometry::CameraModel first = virtual_camera(path.front(), options.size).model;
      if (model.width % 2 != 0 || model.height % 2 != 0 || model.width != first.width ||
          model.height != first.height) {
        return base::fail(
            base::ErrorKind::kArgument, options.mp4.string(),
            fmt::format("a film of {}x{} pictures cannot be made", model.width, model.height),
            "give --size with an even width and height");
      }
    }
  }
  PathReport report;
  // Files are named by frame; a path that shows a frame twice (a freeze) has its pictures counted
  // instead.
  std::set<std::int64_t> distinct;
  for (const recording::CameraRow& row : path) distinct.insert(row.frame);
  const bool by_frame = distinct.size() == path.size();
  std::set<std::string> warnings;
  std::optional<output::Mp4Writer> film;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const geometry::CameraEstimate camera = virtual_camera(path[i], options.size);
    auto rendered = shot.render(path[i].frame, camera, options.mode, options.foreground);
    if (!rendered) return base::fail(rendered.error());
    if (options.stills) {
      const auto file =
          numbered(folder, by_frame ? path[i].frame : static_cast<std::int64_t>(i), ".png");
      const base::Status status = options.foreground
                                      ? output::write_png(file, rendered->picture)
                                      : output::write_png(file, scene::opaque(rendered->picture));
      if (!status) return base::fail(status.error());
    }
    if (!options.mp4.empty()) {
      if (!film) {
        auto opened = output::Mp4Writer::open(options.mp4, camera.model.width, camera.model.height,
                                              shot.session().info().rate);
        if (!opened) return base::fail(opened.error());
        film.emplace(std::move(*opened));
      }
      if (base::Status status = film->write(rendered->picture); !status)
        return base::fail(status.error());
    }
    ++report.pictures;
    report.unseen_share += rendered->report.unseen_share;
    for (const std::string& warning : rendered->report.warnings) {
      if (warnings.insert(warning).second) report.warnings.push_back(warning);
    }
    tell(progress, i + 1, path.size());
  }
  if (report.pictures > 0) report.unseen_share /= static_cast<double>(report.pictures);
  if (film) {
    if (base::Status status = film->finish(); !status) return base::fail(status.error());
  }
  return report;
}

}  // namespace touchline::hub
