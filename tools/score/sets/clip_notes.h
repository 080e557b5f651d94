// What somebody drew on the frames of a clip, and how far a camera and a key agree with it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/image.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

struct NotedBox {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  // pixels
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

using Segment = std::array<Eigen::Vector2d, 2>;

struct NotedFrame {
  std::vector<Eigen::Vector2d> turf;  // outline of the turf, up to the hoardings
  std::vector<NotedBox> people;
  std::vector<Segment> across;  // parallel to the goal lines
};

struct ClipNotes {
  int width = 0;
  int height = 0;
  std::map<std::int64_t, NotedFrame> frames;  // by decoded frame from 0
};

base::Result<ClipNotes> read_clip_notes(const std::filesystem::path& path);

// Mean distance of a segment's ends from the image of the line across the pitch through its middle,
// pixels; none where it does not lie on the turf.
std::optional<double> across_distance(const geometry::CameraEstimate& camera,
                                      const pitch::PitchModel& pitch, const Segment& segment);

// Points of the outline that are edges of turf, not of the picture, cast on the turf.
struct EdgePoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d on_turf = Eigen::Vector2d::Zero();  // metres
  int axis = 0;  // 0 = an edge along the pitch's length (hoardings of the far side), 1 = across
};
std::vector<EdgePoint> turf_edges(const geometry::CameraEstimate& camera,
                                  const pitch::PitchModel& pitch, const NotedFrame& frame);

// Distance of an edge point from the image of the line parallel to the pitch's edges at `place`
// metres (y for axis 0, x for axis 1); none where it cannot be seen.
std::optional<double> edge_distance(const geometry::CameraEstimate& camera,
                                    const pitch::PitchModel& pitch, const EdgePoint& point,
                                    double place);

// A person is held by a key when foreground covers a fifth of the box or more and three quarters of
// its rows have some.
bool is_held(image::ImageView<const std::uint8_t> matte, const NotedBox& box);

// Share of the turf outside every box, these grown by half their size, that is foreground; none
// without turf.
std::optional<double> foreground_on_turf(image::ImageView<const std::uint8_t> matte,
                                         const NotedFrame& frame);

}  // namespace touchline::score
