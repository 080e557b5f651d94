#include "tools/score/sets/clip_notes.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace touchline::score {
namespace {

using Json = nlohmann::json;
using geometry::CameraEstimate;

constexpr std::uint8_t kForeground = 128;
constexpr double kBorderPx = 4;      // so near the picture's border an outline runs along it
constexpr double kStepPx = 40;       // between points of an edge
constexpr double kAlongSine = 0.26;  // of 15 degrees: how far from parallel an edge may be drawn

std::optional<Eigen::Vector2d> point_of(const Json& json) {
  if (!json.is_array() || json.size() != 2 || !json[0].is_number() || !json[1].is_number())
    return std::nullopt;
  return Eigen::Vector2d(json[0].get<double>(), json[1].get<double>());
}

std::vector<Eigen::Vector2d> points_of(const Json& json) {
  std::vector<Eigen::Vector2d> points;
  if (!json.is_array()) return points;
  for (const Json& item : json)
    if (const auto point = point_of(item)) points.push_back(*point);
  return points;
}

std::optional<Eigen::Vector3d> cast(const CameraEstimate& camera, const pitch::PitchModel& pitch,
                                    const Eigen::Vector2d& pixel) {
  return pitch::intersect_turf(pitch, position_in_world(camera), ray_in_world(camera, pixel));
}

// Distance of a pixel from the image of the line through `place` along an axis of the pitch.
std::optional<double> line_distance(const CameraEstimate& camera, const pitch::PitchModel& pitch,
                                    const Eigen::Vector2d& place, int axis,
                                    const Eigen::Vector2d& pixel) {
  Eigen::Vector2d ahead = place;
  ahead[axis] += 0.5;
  Eigen::Vector2d behind = place;
  behind[axis] -= 0.5;
  const auto a = project(camera, pitch.on_turf(behind));
  const auto b = project(camera, pitch.on_turf(ahead));
  if (!a || !b) return std::nullopt;
  const Eigen::Vector2d along = (*b - *a).normalized();
  if (!along.allFinite()) return std::nullopt;
  const Eigen::Vector2d off = pixel - 0.5 * (*a + *b);
  return std::abs(off.x() * along.y() - off.y() * along.x());
}

bool inside(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p) {
  bool in = false;
  for (std::size_t i = 0, j = outline.size() - 1; i < outline.size(); j = i++) {
    const auto& a = outline[i];
    const auto& b = outline[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) &&
        p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      in = !in;
  }
  return in;
}

}  // namespace

base::Result<ClipNotes> read_clip_notes(const std::filesystem::path& path) {
  std::ifstream in(path);
  if (!in) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "is not there",
                      "set TOUCHLINE_DATA or --data to the folder of all sets");
  }
  const Json json = Json::parse(in, nullptr, false);
  const auto bad = [&](const char* what) {
    return base::fail(base::ErrorKind::kFormat, path.string(), what);
  };
  if (json.is_discarded() || !json.is_object()) return bad("is no JSON object");
  const auto number = [](const Json& object, const char* key) -> std::int64_t {
    const auto found = object.find(key);
    return found != object.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
  };
  ClipNotes notes;
  const std::int64_t width = number(json, "frame_width"), height = number(json, "frame_height");
  if (width < 16 || width > 16384 || height < 16 || height > 16384)
    return bad("has no frame_width and frame_height of 16 to 16384");
  notes.width = static_cast<int>(width);
  notes.height = static_cast<int>(height);
  const auto frames = json.find("frames");
  if (frames == json.end() || !frames->is_array()) return bad("has no list of frames");
  for (const Json& item : *frames) {
    if (!item.is_object() || number(item, "frame") < 1) return bad("has a frame without a number");
    NotedFrame frame;
    if (item.contains("field")) frame.turf = points_of(item["field"]);
    if (item.contains("players") && item["players"].is_array()) {
      for (const Json& player : item["players"]) {
        if (!player.is_object() || !player.contains("position")) continue;
        const auto corners = points_of(player["position"]);
        if (corners.size() != 2) continue;
        frame.people.push_back({corners[0].cwiseMin(corners[1]), corners[0].cwiseMax(corners[1])});
      }
    }
    if (item.contains("vanishing_point") && item["vanishing_point"].is_array()) {
      for (const Json& line : item["vanishing_point"]) {
        const auto ends = points_of(line);
        if (ends.size() == 2) frame.across.push_back({ends[0], ends[1]});
      }
    }
    notes.frames[number(item, "frame") - 1] = std::move(frame);
  }
  return notes;
}

std::optional<double> across_distance(const CameraEstimate& camera, const pitch::PitchModel& pitch,
                                      const Segment& segment) {
  const auto middle = cast(camera, pitch, 0.5 * (segment[0] + segment[1]));
  if (!middle) return std::nullopt;
  double sum = 0;
  for (const Eigen::Vector2d& end : segment) {
    // The line's place beside this end, so that a lens bends both alike.
    const auto place = cast(camera, pitch, end);
    if (!place) return std::nullopt;
    const auto distance = line_distance(camera, pitch, {middle->x(), place->y()}, 1, end);
    if (!distance) return std::nullopt;
    sum += *distance;
  }
  return 0.5 * sum;
}

std::vector<EdgePoint> turf_edges(const CameraEstimate& camera, const pitch::PitchModel& pitch,
                                  const NotedFrame& frame) {
  std::vector<EdgePoint> points;
  const double right = camera.model.width - 1, bottom = camera.model.height - 1;
  const auto along_border = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a.x() < kBorderPx && b.x() < kBorderPx) || (a.y() < kBorderPx && b.y() < kBorderPx) ||
           (a.x() > right - kBorderPx && b.x() > right - kBorderPx) ||
           (a.y() > bottom - kBorderPx && b.y() > bottom - kBorderPx);
  };
  for (std::size_t i = 0; i < frame.turf.size(); ++i) {
    const Eigen::Vector2d& a = frame.turf[i];
    const Eigen::Vector2d& b = frame.turf[(i + 1) % frame.turf.size()];
    if (along_border(a, b) || (b - a).norm() < kStepPx) continue;
    const auto from = cast(camera, pitch, a);
    const auto to = cast(camera, pitch, b);
    if (!from || !to) continue;
    const Eigen::Vector2d way = (*to - *from).head<2>().normalized();
    const int axis = std::abs(way.y()) < kAlongSine ? 0 : std::abs(way.x()) < kAlongSine ? 1 : -1;
    if (axis < 0) continue;
    const int count = static_cast<int>((b - a).norm() / kStepPx);
    for (int k = 0; k <= count; ++k) {
      const Eigen::Vector2d pixel = a + (b - a) * k / std::max(count, 1);
      if (const auto place = cast(camera, pitch, pixel))
        points.push_back({pixel, place->head<2>(), axis});
    }
  }
  return points;
}

std::optional<double> edge_distance(const CameraEstimate& camera, const pitch::PitchModel& pitch,
                                    const EdgePoint& point, double place) {
  Eigen::Vector2d on = point.on_turf;
  on[1 - point.axis] = place;
  return line_distance(camera, pitch, on, point.axis, point.pixel);
}

bool is_held(image::ImageView<const std::uint8_t> matte, const NotedBox& box) {
  const int left = std::max(0, static_cast<int>(std::lround(box.low.x())));
  const int top = std::max(0, static_cast<int>(std::lround(box.low.y())));
  const int right = std::min(matte.width - 1, static_cast<int>(std::lround(box.high.x())));
  const int bottom = std::min(matte.height - 1, static_cast<int>(std::lround(box.high.y())));
  if (right < left || bottom < top) return false;
  std::int64_t covered = 0, rows = 0;
  for (int y = top; y <= bottom; ++y) {
    const std::uint8_t* row = matte.row(y);
    const auto here =
        std::count_if(row + left, row + right + 1, [](auto v) { return v >= kForeground; });
    covered += here;
    rows += here > 0 ? 1 : 0;
  }
  const std::int64_t height = bottom - top + 1;
  return 5 * covered >= height * (right - left + 1) && 4 * rows >= 3 * height;
}

std::optional<double> foreground_on_turf(image::ImageView<const std::uint8_t> matte,
                                         const NotedFrame& frame) {
  if (frame.turf.size() < 3) return std::nullopt;
  std::int64_t all = 0, foreground = 0;
  for (int y = 0; y < matte.height; y += 2) {
    for (int x = 0; x < matte.width; x += 2) {
      const Eigen::Vector2d p(x, y);
      if (!inside(frame.turf, p)) continue;
      const bool person =
          std::any_of(frame.people.begin(), frame.people.end(), [&](const NotedBox& box) {
            const Eigen::Vector2d grown = 0.5 * (box.high - box.low);
            return (p - (box.low - grown)).minCoeff() >= 0 &&
                   (box.high + grown - p).minCoeff() >= 0;
          });
      if (person) continue;
      ++all;
      if (matte(x, y) >= kForeground) ++foreground;
    }
  }
  if (all == 0) return std::nullopt;
  return static_cast<double>(foreground) / static_cast<double>(all);
}

}  // namespace touchline::score
