// The views a hub would get from perfect edges: true cameras, true mattes, and texture tiles cut
// from the recorded video.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "shared/base/result.h"
#include "shared/codec/camera_view.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/recording.h"
#include "shared/recording/video_reader.h"
#include "tools/score/truth.h"

namespace touchline::score {

struct OracleOptions {
  int tile_margin_px = 16;              // round each connected piece of foreground, pixels
  bool tiles = true;                    // false: no video is decoded, the stamp is the recording's
  double occluder_margin_px = 2.5;      // round goal frames, which cut the true matte, pixels
  std::vector<base::CameraId> cameras;  // in this order; empty = all of the recording
  // What is done to a frame of the video before tiles are cut; empty = nothing.
  std::function<image::Frame(const base::CameraId&, const image::Frame&)> treat;
};

// One camera's matte in the frame's size, goal frames and nets marked as occluders and unknown.
image::Matte oracle_matte(const image::Image<std::uint8_t>& alpha,
                          const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                          double occluder_margin_px);
// Patches that hold every foreground pixel (alpha > 0) and `margin_px` round it.
std::vector<codec::TextureTile> cut_tiles(const image::Frame& frame, const image::Matte& matte,
                                          int margin_px);

// Steps through the instants of the recording; each camera gives the frame of its video that
// belongs to the instant (FrameClocks).
class Oracle {
 public:
  static base::Result<Oracle> open(const recording::Recording& recording, const Truth& truth,
                                   const OracleOptions& options);
  Oracle(Oracle&&) noexcept;
  Oracle& operator=(Oracle&&) noexcept;
  ~Oracle();

  const pitch::PitchModel& pitch() const;
  std::int64_t next_frame() const;
  // The views of the next instant, cameras in order; nothing when all videos, or the truth, have
  // ended. A camera without a frame, true row or matte at the instant is lost or without matte.
  base::Result<std::optional<std::vector<codec::CameraView>>> next();
  // Passes over instants until `frame` is the next; videos are read when next() asks for them.
  void skip_to(std::int64_t frame);

 private:
  struct Impl;
  explicit Oracle(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace touchline::score
