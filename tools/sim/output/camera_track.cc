#include "tools/sim/output/camera_track.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "shared/image/colour.h"
#include "shared/recording/timing_table.h"
#include "tools/sim/camera/detail.h"
#include "tools/sim/output/files.h"

namespace touchline::sim::output {

namespace fs = std::filesystem;

namespace {

double last_time(const camera::Schedule& schedule) {
  double last = 0;
  for (const camera::Shot& shot : schedule.shots) last = std::max(last, shot.time_s);
  return last + 1;
}

// The rows of one field.
camera::LinearImage field_of(const camera::LinearImage& frame, int parity) {
  camera::LinearImage field(frame.width(), frame.height() / 2);
  for (int y = 0; y < field.height(); ++y) {
    std::copy_n(frame.row(2 * y + parity), frame.width(), field.row(y));
  }
  return field;
}

template <typename T>
void weave(const image::Image<T>& field, int parity, image::Image<T>& frame) {
  for (int y = 0; y < field.height(); ++y) {
    std::copy_n(field.row(y), field.width(), frame.row(2 * y + parity));
  }
}

recording::Role role_of(camera::Role role) {
  switch (role) {
    case camera::Role::kFixed:
      return recording::Role::kFixed;
    case camera::Role::kCloseup:
      return recording::Role::kCloseup;
    case camera::Role::kMatch:
      break;
  }
  return recording::Role::kMatch;
}

recording::Side side_of(camera::Side side) {
  switch (side) {
    case camera::Side::kReverse:
      return recording::Side::kReverse;
    case camera::Side::kLeft:
      return recording::Side::kLeft;
    case camera::Side::kRight:
      return recording::Side::kRight;
    case camera::Side::kMain:
      break;
  }
  return recording::Side::kMain;
}

}  // namespace

CameraTrack::CameraTrack(const scene::Scene& scene, const camera::CameraSpec& spec,
                         const Match& match, const Targets& targets, const fs::path& root)
    : spec_(camera::varied(spec, scene.seed)),
      start_timecode_(scene.start_timecode),
      mattes_(scene.truth.mattes),
      match_(match),
      random_(camera::Stream(scene.seed, "camera").sub(spec.id.value)),
      schedule_(
          camera::schedule(spec_.timing, scene.rate, scene.frames, {}, random_.sub("timing"))),
      rig_(spec_, last_time(schedule_), targets.function(), random_.sub("rig")),
      sensor_(spec_.sensor, scene.exposure),
      survey_(spec_.role == camera::Role::kMatch
                  ? camera::survey_poses(spec_, rig_.lens(), match.pitch().length_m,
                                         match.pitch().width_m, random_.sub("survey"))
                  : std::vector<geometry::HeadPose>{}),
      root_(root),
      folder_(root / spec.id.value),
      truth_(root / "truth" / spec.id.value) {}

base::Result<std::unique_ptr<CameraTrack>> CameraTrack::create(const scene::Scene& scene,
                                                               const camera::CameraSpec& spec,
                                                               const Match& match,
                                                               const Targets& targets,
                                                               const fs::path& root) {
  std::unique_ptr<CameraTrack> track(new CameraTrack(scene, spec, match, targets, root));
  if (track->schedule_.shots.empty()) {
    return base::fail(base::ErrorKind::kConfiguration, "camera." + spec.id.value,
                      "no frame is left of its video", "drop fewer frames, or record more");
  }
  std::error_code error;
  fs::create_directories(track->folder_, error);
  if (!error) fs::create_directories(track->truth_, error);
  if (!error && track->mattes_) fs::create_directories(track->truth_ / "matte", error);
  if (!error && !track->survey_.empty()) fs::create_directories(track->folder_ / "survey", error);
  if (error) {
    return base::fail(base::ErrorKind::kIo, track->folder_.string(), error.message(),
                      "check that the folder may be written to");
  }
  const camera::CameraSpec& s = track->spec_;
  auto video = VideoWriter::open(track->folder_ / "video.mkv", s.width, s.height,
                                 track->schedule_.rate, s.timing.scan, s.video);
  if (!video) return base::fail(video.error());
  track->video_.emplace(std::move(*video));
  return track;
}

std::vector<render::Exposure> CameraTrack::exposures(std::size_t shot) const {
  std::vector<render::Exposure> made;
  for (const camera::Shutter& shutter :
       camera::shutters(spec_.timing, schedule_.rate, schedule_.shots[shot].time_s)) {
    const camera::Pose open = rig_.at(shutter.open_s), close = rig_.at(shutter.close_s);
    made.push_back({{open.model, open.cam_from_world},
                    {close.model, close.cam_from_world},
                    shutter.open_s,
                    shutter.close_s});
  }
  return made;
}

render::Exposure CameraTrack::survey_exposure(std::size_t still) const {
  const camera::Pose pose = rig_.posed(survey_[still]);
  return {{pose.model, pose.cam_from_world}, {pose.model, pose.cam_from_world}, 0, 0};
}

base::Status CameraTrack::take(std::size_t shot, std::vector<render::Picture> pictures) {
  const camera::Shot& which = schedule_.shots[shot];
  const camera::Stream noise = random_.sub("noise").sub(static_cast<std::uint64_t>(which.exposure));
  image::Frame frame;
  image::Image<std::uint8_t> matte;
  if (pictures.size() == 1) {
    frame = sensor_.expose(pictures[0].radiance, noise);
    matte = std::move(pictures[0].matte);
  } else {
    const int first = spec_.timing.scan == image::Scan::kTopFirst ? 0 : 1;
    matte = image::Image<std::uint8_t>(spec_.width, spec_.height);
    frame.planes = {image::Image<std::uint16_t>(spec_.width, spec_.height),
                    image::Image<std::uint16_t>((spec_.width + 1) / 2, spec_.height),
                    image::Image<std::uint16_t>((spec_.width + 1) / 2, spec_.height)};
    for (std::size_t i = 0; i < 2; ++i) {
      const int parity = i == 0 ? first : 1 - first;
      const image::Frame field =
          sensor_.expose(field_of(pictures[i].radiance, parity), noise.sub(i));
      for (std::size_t p = 0; p < 3; ++p) weave(field.planes[p], parity, frame.planes[p]);
      for (int y = parity; y < spec_.height; y += 2) {
        std::copy_n(pictures[i].matte.row(y), spec_.width, matte.row(y));
      }
    }
  }
  pictures.clear();
  // A repeated frame shows what the frame before it shows.
  for (std::size_t f = shot; mattes_ && f < schedule_.shots.size(); ++f) {
    if (f > shot && !schedule_.shots[f].repeats) break;
    const fs::path path = truth_ / "matte" / fmt::format("{:06}.png", schedule_.shots[f].frame);
    if (auto status = write_grey_png(path, matte); !status) return status;
  }
  return write_in_turn(shot, std::move(frame));
}

base::Status CameraTrack::write_in_turn(std::size_t shot, image::Frame frame) {
  const std::lock_guard lock(mutex_);
  ready_.emplace(shot, std::move(frame));
  for (;;) {
    const auto turn = ready_.find(next_);
    if (turn == ready_.end()) return {};
    do {
      if (auto status = video_->write(turn->second); !status) return status;
      ++next_;
    } while (next_ < schedule_.shots.size() && schedule_.shots[next_].repeats);
    ready_.erase(turn);
  }
}

base::Status CameraTrack::take_survey(std::size_t still, const render::Picture& picture) const {
  const image::Frame frame =
      sensor_.expose(picture.radiance, random_.sub("survey noise").sub(still));
  return write_jpeg(folder_ / "survey" / fmt::format("{:02}.jpg", still), image::to_rgb(frame), 95);
}

base::Status CameraTrack::write_head() const {
  camera::HeadEncoders encoders(spec_.head, rig_.lens(), random_.sub("head"));
  std::string text = "frame,pan_counts,tilt_counts,zoom_counts,focus_counts\n";
  camera::HeadCounts counts;
  for (const camera::Shot& shot : schedule_.shots) {
    // Play depends on the way there, not on the two ends alone.
    constexpr int kSteps = 8;
    for (int i = 1 - kSteps; !shot.repeats && i <= 0; ++i) {
      const double time_s = shot.time_s + i * schedule_.rate.period_s() / kSteps;
      const camera::Pose pose = rig_.at(time_s);
      const Eigen::Vector3d eye = geometry::origin(pose.cam_from_world);
      const auto focus = pitch::intersect_turf(
          match_.pitch(), eye, pose.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ());
      counts = encoders.read(rig_.head(time_s), focus ? (*focus - eye).norm() : 100);
    }
    text += fmt::format("{},{},{},{},{}\n", shot.frame, counts.pan, counts.tilt, counts.zoom,
                        counts.focus);
  }
  if (auto status = write_text(folder_ / "head.csv", text); !status) return status;
  return write_text(truth_ / "head.json", encoders.json());
}

base::Status CameraTrack::write_truth() const {
  std::vector<recording::CameraRow> rows;
  std::string frames = "frame,exposure,instant,media_time_ns,true_time_s\n";
  bool plain = true;
  for (const camera::Shot& shot : schedule_.shots) {
    frames += fmt::format("{},{},{},{},{:.9f}\n", shot.frame, shot.exposure,
                          shot.repeats ? -1 : shot.instant, shot.media_time.ns, shot.time_s);
    if (shot.frame != shot.instant) plain = false;
    const camera::Pose pose = rig_.at(shot.time_s);
    rows.push_back({shot.frame, pose.model, pose.cam_from_world, std::nullopt});
  }
  if (auto status = recording::write_camera_table(truth_ / "cameras.csv", rows); !status) {
    return status;
  }
  if (!plain || spec_.timing.offset_ms != 0) {
    if (auto status = write_text(truth_ / "frames.csv", frames); !status) return status;
  }
  if (!survey_.empty()) {
    rows.clear();
    for (std::size_t i = 0; i < survey_.size(); ++i) {
      const camera::Pose pose = rig_.posed(survey_[i]);
      rows.push_back({static_cast<std::int64_t>(i), pose.model, pose.cam_from_world, std::nullopt});
    }
    if (auto status = recording::write_camera_table(truth_ / "survey.csv", rows); !status) {
      return status;
    }
  }
  return write_text(truth_ / "detail.json", camera::detail_json(spec_.sensor));
}

base::Status CameraTrack::finish() {
  if (auto status = video_->finish(); !status) return status;
  video_.reset();
  if (schedule_.table) {
    const auto rows = camera::timing_rows(schedule_, start_timecode_);
    if (auto status = write_text(folder_ / "timing.csv", recording::timing_table_text(rows));
        !status) {
      return status;
    }
  }
  if (spec_.head.encoders) {
    if (auto status = write_head(); !status) return status;
  }
  return write_truth();
}

recording::CameraEntry CameraTrack::entry() const {
  recording::CameraEntry entry;
  entry.id = spec_.id;
  entry.role = role_of(spec_.role);
  entry.side = side_of(spec_.side);
  entry.video = folder_ / "video.mkv";
  if (!survey_.empty()) entry.survey = folder_ / "survey";
  entry.width = spec_.width;
  entry.height = spec_.height;
  entry.rate = schedule_.rate;
  entry.scan = spec_.timing.scan;
  if (spec_.timing.offset_stated) {
    entry.offset_ns = static_cast<std::int64_t>(std::llround(spec_.timing.offset_ms * 1e6));
  }
  return entry;
}

}  // namespace touchline::sim::output
