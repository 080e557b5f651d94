#include "tools/sim/output/recording_run.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <optional>
#include <thread>
#include <tuple>
#include <vector>

#include "shared/base/bounded_queue.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "tools/sim/camera/virtual_path.h"
#include "tools/sim/output/camera_track.h"
#include "tools/sim/output/files.h"
#include "tools/sim/output/targets.h"

namespace touchline::sim::output {

namespace fs = std::filesystem;

namespace {

enum class Kind { kSurvey, kShot, kVirtual };

// Pictures that belong together, and whose they are.
struct Task {
  Kind kind = Kind::kShot;
  std::size_t camera = 0;  // track, or virtual camera
  std::size_t index = 0;   // still, shot, or frame
  double time_s = 0;
};

struct Job {
  Task task;
  std::vector<render::Picture> pictures;
};

// The folder while it grows; gone again unless kept.
class Growing {
 public:
  explicit Growing(fs::path path) : path_(std::move(path)) {}
  Growing(const Growing&) = delete;
  Growing& operator=(const Growing&) = delete;
  ~Growing() {
    std::error_code ignored;
    if (!kept_) fs::remove_all(path_, ignored);
  }
  const fs::path& path() const { return path_; }
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  bool kept_ = false;
};

base::Status may_write(const fs::path& out, bool force) {
  std::error_code error;
  if (!fs::exists(out, error)) return {};
  if (fs::is_directory(out, error) && fs::is_empty(out, error)) return {};
  if (!force) {
    return base::fail(base::ErrorKind::kArgument, out.string(), "is there already",
                      "give another folder, or --force to replace a recording");
  }
  if (!fs::exists(out / "recording.toml", error)) {
    return base::fail(base::ErrorKind::kArgument, out.string(),
                      "is no recording, and is left alone", "give another folder");
  }
  return {};
}

base::Status make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (!error) return {};
  return base::fail(base::ErrorKind::kIo, path.string(), error.message(),
                    "check that the folder may be written to");
}

std::uint64_t bytes_in(const fs::path& folder) {
  std::uint64_t sum = 0;
  std::error_code error;
  for (fs::recursive_directory_iterator it(folder, error), end; !error && it != end;
       it.increment(error)) {
    if (it->is_regular_file(error)) sum += it->file_size(error);
  }
  return sum;
}

class Run {
 public:
  Run(const scene::Scene& scene, const Match& match, const fs::path& root,
      const RunOptions& options)
      : scene_(scene),
        match_(match),
        root_(root),
        options_(options),
        workers_(tbb::global_control::max_allowed_parallelism,
                 static_cast<std::size_t>(options.threads)),
        arena_(options.threads),
        targets_(arena_.execute([&] { return Targets(scene, match); })) {}

  base::Status run(RunReport& report) {
    if (auto status = make_folder(root_ / "truth"); !status) return status;
    for (const camera::CameraSpec& spec : scene_.cameras) {
      auto track = CameraTrack::create(scene_, spec, match_, targets_, root_);
      if (!track) return base::fail(track.error());
      tracks_.push_back(std::move(*track));
    }
    plan();
    if (auto status = make_pictures(report); !status) return status;
    recording::Recording made;
    made.root = root_;
    made.name = scene_.name;
    made.sport = scene_.sport;
    made.sizes = scene_.stated;
    made.rate = scene_.rate;
    made.start_timecode = scene_.start_timecode;
    for (const auto& track : tracks_) {
      if (auto status = track->finish(); !status) return status;
      report.video_frames += track->video_frames();
      made.cameras.push_back(track->entry());
    }
    for (std::size_t i = 0; i < scene_.virtuals.size(); ++i) {
      if (auto status = write_virtual_table(i); !status) return status;
    }
    if (auto status = arena_.execute([&] { return write_people(); }); !status) return status;
    return recording::save_recording(made);
  }

 private:
  void plan() {
    for (std::size_t c = 0; c < tracks_.size(); ++c) {
      for (std::size_t i = 0; i < tracks_[c]->survey_stills(); ++i) {
        tasks_.push_back({Kind::kSurvey, c, i, -1});
      }
      const auto& shots = tracks_[c]->schedule().shots;
      for (std::size_t i = 0; i < shots.size(); ++i) {
        if (!shots[i].repeats) tasks_.push_back({Kind::kShot, c, i, shots[i].time_s});
      }
    }
    for (std::size_t v = 0; v < scene_.virtuals.size(); ++v) {
      const camera::VirtualSpec& spec = scene_.virtuals[v];
      for (std::int64_t f = 0; f < scene_.frames; ++f) {
        if (due(spec.clean_every, f) || due(spec.matte_every, f)) {
          tasks_.push_back({Kind::kVirtual, v, static_cast<std::size_t>(f),
                            static_cast<double>(f) * scene_.rate.period_s()});
        }
      }
    }
    // All cameras of an instant one after the other: they share the people's geometry.
    std::stable_sort(tasks_.begin(), tasks_.end(), [](const Task& a, const Task& b) {
      return std::tuple(a.time_s, a.kind, a.camera) < std::tuple(b.time_s, b.kind, b.camera);
    });
  }

  static bool due(int every, std::int64_t frame) { return every > 0 && frame % every == 0; }

  camera::Pose virtual_pose(std::size_t v, double time_s) const {
    return camera::virtual_pose(scene_.virtuals[v], match_.pitch(), targets_.function(), time_s);
  }

  std::vector<render::Picture> render(const Task& task) const {
    std::vector<render::Exposure> exposures;
    switch (task.kind) {
      case Kind::kSurvey:
        exposures = {tracks_[task.camera]->survey_exposure(task.index)};
        break;
      case Kind::kShot:
        exposures = tracks_[task.camera]->exposures(task.index);
        break;
      case Kind::kVirtual: {
        const camera::Pose pose = virtual_pose(task.camera, task.time_s);
        exposures = {{{pose.model, pose.cam_from_world},
                      {pose.model, pose.cam_from_world},
                      task.time_s,
                      task.time_s}};
        break;
      }
    }
    std::vector<render::Picture> pictures;
    for (const render::Exposure& exposure : exposures) {
      pictures.push_back(match_.picture(exposure, options_.render, task.kind != Kind::kSurvey));
    }
    return pictures;
  }

  base::Status develop(Job job) const {
    const Task& task = job.task;
    switch (task.kind) {
      case Kind::kSurvey:
        return tracks_[task.camera]->take_survey(task.index, job.pictures[0]);
      case Kind::kShot:
        return tracks_[task.camera]->take(task.index, std::move(job.pictures));
      case Kind::kVirtual:
        break;
    }
    const camera::VirtualSpec& spec = scene_.virtuals[task.camera];
    const fs::path folder = root_ / "truth" / spec.id;
    const std::string name = fmt::format("{:06}.png", task.index);
    const auto frame = static_cast<std::int64_t>(task.index);
    if (due(spec.clean_every, frame)) {
      const auto picture = camera::clean_picture(job.pictures[0].radiance, scene_.exposure);
      if (auto status = write_rgb_png(folder / "clean" / name, picture); !status) return status;
    }
    if (due(spec.matte_every, frame)) {
      return write_grey_png(folder / "matte" / name, job.pictures[0].matte);
    }
    return {};
  }

  // Renders in order; other threads develop and write what is rendered.
  base::Status make_pictures(RunReport& report) {
    for (const camera::VirtualSpec& spec : scene_.virtuals) {
      for (const char* part : {"clean", "matte"}) {
        if (auto status = make_folder(root_ / "truth" / spec.id / part); !status) return status;
      }
    }
    base::BoundedQueue<Job> queue(2, base::FullPolicy::kBlock);
    std::mutex mutex;
    std::optional<base::Error> failure;
    std::vector<std::jthread> developers;
    for (int i = 0; i < std::max(1, options_.threads / 2); ++i) {
      developers.emplace_back([&] {
        while (auto job = queue.pop()) {
          if (auto status = develop(std::move(*job)); !status) {
            const std::lock_guard lock(mutex);
            if (!failure) failure = status.error();
          }
        }
      });
    }
    const auto failed = [&] {
      const std::lock_guard lock(mutex);
      return failure.has_value();
    };
    const auto total = static_cast<std::int64_t>(tasks_.size());
    std::int64_t done = 0;
    for (const Task& task : tasks_) {
      if (options_.stop.stop_requested() || failed()) break;
      Job job{task, arena_.execute([&] { return render(task); })};
      report.pictures += static_cast<std::int64_t>(job.pictures.size());
      queue.push(std::move(job));
      if (options_.progress) options_.progress(++done, total);
    }
    queue.close();
    developers.clear();
    if (failure) return base::fail(*failure);
    if (options_.stop.stop_requested()) {
      return base::fail(base::ErrorKind::kCancelled, root_.string(), "stopped before it was whole");
    }
    return {};
  }

  base::Status write_virtual_table(std::size_t v) const {
    std::vector<recording::CameraRow> rows;
    for (std::int64_t f = 0; f < scene_.frames; ++f) {
      const camera::Pose pose = virtual_pose(v, static_cast<double>(f) * scene_.rate.period_s());
      rows.push_back({f, pose.model, pose.cam_from_world, std::nullopt});
    }
    return recording::write_camera_table(root_ / "truth" / scene_.virtuals[v].id / "cameras.csv",
                                         rows);
  }

  base::Status write_people() const {
    const auto frames = static_cast<std::size_t>(scene_.frames);
    std::vector<std::string> people(frames), joints(frames);
    tbb::parallel_for(std::size_t{0}, frames, [&](std::size_t f) {
      for (const PersonTruth& p : match_.people(static_cast<double>(f) * scene_.rate.period_s())) {
        const Eigen::Vector3d& at = p.position_in_world;
        people[f] += fmt::format("{},{},{},{},{:.4f},{:.4f},{:.4f}\n", f, p.id, p.team, p.role,
                                 at.x(), at.y(), at.z());
        for (const auto& [name, joint] : p.joints) {
          joints[f] += fmt::format("{},{},{},{:.4f},{:.4f},{:.4f}\n", f, p.id, name, joint.x(),
                                   joint.y(), joint.z());
        }
      }
    });
    const auto joined = [](std::string text, const std::vector<std::string>& parts) {
      for (const std::string& part : parts) text += part;
      return text;
    };
    const fs::path truth = root_ / "truth";
    if (auto s = write_text(truth / "people.csv", joined("frame,id,team,role,x,y,z\n", people));
        !s) {
      return s;
    }
    if (scene_.truth.joints) {
      if (auto s = write_text(truth / "joints.csv", joined("frame,id,joint,x,y,z\n", joints)); !s) {
        return s;
      }
    }
    if (scene_.truth.mesh_every <= 0) return {};
    if (auto s = make_folder(truth / "mesh"); !s) return s;
    for (std::int64_t f = 0; f < scene_.frames; f += scene_.truth.mesh_every) {
      const geometry::Mesh mesh = match_.mesh(static_cast<double>(f) * scene_.rate.period_s());
      if (mesh.vertices.empty()) continue;
      if (auto s = write_ply(truth / "mesh" / fmt::format("{:06}.ply", f), mesh); !s) return s;
    }
    return {};
  }

  const scene::Scene& scene_;
  const Match& match_;
  const fs::path root_;
  const RunOptions& options_;
  const tbb::global_control workers_;  // as many threads as are asked for, whatever the machine has
  mutable tbb::task_arena arena_;
  const Targets targets_;
  std::vector<std::unique_ptr<CameraTrack>> tracks_;
  std::vector<Task> tasks_;
};

}  // namespace

base::Status RunOptions::validate() const {
  if (threads >= 1 && threads <= 256) return {};
  return base::fail(base::ErrorKind::kArgument, "threads",
                    fmt::format("{} is out of bounds", threads), "give a value from 1 to 256");
}

base::Result<RunReport> record(const scene::Scene& scene, const Match& match, const fs::path& out,
                               const RunOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (auto status = scene::validate(scene); !status) return base::fail(status.error());
  const fs::path target = fs::absolute(out).lexically_normal();
  const fs::path place = target.has_filename() ? target : target.parent_path();
  if (auto status = may_write(place, options.force); !status) return base::fail(status.error());
  const auto began = std::chrono::steady_clock::now();
  if (auto status = make_folder(place.parent_path()); !status) return base::fail(status.error());
  const std::string mark = fmt::format(".{}", ::getpid());
  Growing growing(place.parent_path() / (place.filename().string() + ".unfinished" + mark));
  RunReport report;
  report.frames = scene.frames;
  {
    Run run(scene, match, growing.path(), options);
    if (auto status = run.run(report); !status) return base::fail(status.error());
  }
  report.bytes = bytes_in(growing.path());
  // What was there goes only when all of the new is on the disk.
  std::error_code error;
  const fs::path old = place.parent_path() / (place.filename().string() + ".replaced" + mark);
  const bool replaces = fs::exists(place, error);
  if (replaces) fs::rename(place, old, error);
  if (!error) fs::rename(growing.path(), place, error);
  if (error) {
    return base::fail(base::ErrorKind::kIo, place.string(), error.message(),
                      "check that the folder may be written to");
  }
  growing.keep();
  if (replaces) fs::remove_all(old, error);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return report;
}

}  // namespace touchline::sim::output
