// What the benches run on: frames, true cameras and mattes of a recording at 1080p, the same
// upscaled with added noise at 2160p, and instants of people that any number of cameras see.
// Everything is made once a program and kept.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "edge/calibrate/survey/survey.h"
#include "edge/state/detail_model.h"
#include "shared/codec/camera_view.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/geometry/mount.h"
#include "shared/image/frame.h"
#include "shared/image/matte.h"
#include "shared/image/plate_snapshot.h"
#include "shared/pitch/pitch_model.h"
#include "shared/recording/recording.h"

namespace touchline::bench {

enum class Size { k1080, k2160 };
inline constexpr Size kSizes[] = {Size::k1080, Size::k2160};
std::string name(Size size);  // "1080p", "2160p"

const recording::Recording& the_recording();
const pitch::PitchModel& the_pitch();

// The first camera of a role; ends the program where there is none.
const recording::CameraEntry& first_camera(recording::Role role);

// Frames of one camera. `raw` as recorded (ten at most), `frames` compensated.
struct CameraFrames {
  state::DetailModel detail;
  std::vector<image::FramePtr> raw;
  std::vector<image::FramePtr> frames;
  std::vector<geometry::CameraEstimate> truth;     // one a frame
  std::vector<image::Image<std::uint8_t>> mattes;  // true coverage, one a frame
};
// The first frames of the recording: ten, or TOUCHLINE_BENCH_FRAMES.
const CameraFrames& camera_frames(recording::Role role, Size size);

// Of the first camera of the role, from its stills (a head) or frames (fixed). The mount is scaled
// to the size; the estimates and stills are those of the recording's own size.
struct Survey {
  calibrate::SurveyResult result;
  std::vector<image::Frame> stills;  // compensated; empty for a fixed camera
};
const Survey& survey(recording::Role role);
geometry::Mount mount(recording::Role role, Size size);

// Learnt from camera_frames() by true cameras, and a head's survey stills (not in a smoke run).
const image::PlateSnapshot& plate(recording::Role role, Size size);

// Those that instant() and plates() are of: all; two in a smoke run.
std::span<const recording::CameraEntry> cameras();

// The first instant as perfect edges would send it, all parts there.
const std::vector<codec::CameraView>& instant(Size size);
const std::map<base::CameraId, image::PlateSnapshot>& plates();
// The recording's first virtual camera at its first frame; 135 lines in a smoke run.
geometry::CameraEstimate virtual_camera(Size size);

// The camera with its picture `factor` times as large, and the picture doubled, with noise of
// about two code values.
geometry::CameraEstimate scaled(geometry::CameraEstimate camera, double factor);
image::Frame doubled(const image::Frame& frame);
image::Image<std::uint8_t> doubled(const image::Image<std::uint8_t>& mask);

// `people` running people with limbs, 2 m apart or more around the pitch's middle, seen by
// `cameras` cameras on stands all round: true cameras and mattes, no video.
std::vector<codec::CameraView> crowd(int cameras, int people, Size size);
// Where they stand, on the turf.
std::vector<Eigen::Vector2d> crowd_places(int people);

}  // namespace touchline::bench
