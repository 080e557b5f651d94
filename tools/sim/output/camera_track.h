// One camera of a recording while it is made: which pictures it needs, and what becomes of them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include "shared/base/result.h"
#include "shared/recording/camera_table.h"
#include "shared/recording/recording.h"
#include "tools/sim/camera/head.h"
#include "tools/sim/camera/rig.h"
#include "tools/sim/camera/sensor.h"
#include "tools/sim/camera/timing.h"
#include "tools/sim/output/match.h"
#include "tools/sim/output/targets.h"
#include "tools/sim/output/video_writer.h"

namespace touchline::sim::output {

class CameraTrack {
 public:
  // Makes the camera's folders under `root` and opens its video.
  static base::Result<std::unique_ptr<CameraTrack>> create(const scene::Scene& scene,
                                                           const camera::CameraSpec& spec,
                                                           const Match& match,
                                                           const Targets& targets,
                                                           const std::filesystem::path& root);

  const camera::Schedule& schedule() const { return schedule_; }
  std::size_t survey_stills() const { return survey_.size(); }
  // One a frame, two a frame of fields: the earlier field first.
  std::vector<render::Exposure> exposures(std::size_t shot) const;
  render::Exposure survey_exposure(std::size_t still) const;

  // Develops the pictures of a shot and writes them when their turn comes. From any thread; every
  // shot that repeats nothing once.
  base::Status take(std::size_t shot, std::vector<render::Picture> pictures);
  base::Status take_survey(std::size_t still, const render::Picture& picture) const;

  // When all shots are taken: closes the video, writes timing, head and truth tables.
  base::Status finish();
  recording::CameraEntry entry() const;
  std::int64_t video_frames() const { return static_cast<std::int64_t>(schedule_.shots.size()); }

 private:
  CameraTrack(const scene::Scene& scene, const camera::CameraSpec& spec, const Match& match,
              const Targets& targets, const std::filesystem::path& root);
  base::Status write_in_turn(std::size_t shot, image::Frame frame);
  base::Status write_truth() const;
  base::Status write_head() const;

  const camera::CameraSpec spec_;
  const base::Timecode start_timecode_;
  const bool mattes_;
  const Match& match_;
  const camera::Stream random_;
  const camera::Schedule schedule_;
  const camera::Rig rig_;
  const camera::Sensor sensor_;
  const std::vector<geometry::HeadPose> survey_;
  const std::filesystem::path root_, folder_, truth_;
  std::optional<VideoWriter> video_;
  std::mutex mutex_;
  std::map<std::size_t, image::Frame> ready_;  // developed before their turn
  std::size_t next_ = 0;                       // shot to write
};

}  // namespace touchline::sim::output
