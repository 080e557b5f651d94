#include "tools/score/sets/pitch_lines.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "shared/pitch/pitch_model.h"
#include "tools/score/sets/clicked_camera.h"
#include "tools/score/sets/overlay.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using geometry::CameraEstimate;

constexpr int kWidth = 960;  // the size at which published methods are compared
constexpr int kHeight = 540;
constexpr double kPieceM = 1.0;
constexpr std::array<double, 3> kThresholds{5, 10, 20};
constexpr std::size_t kPictures = 12;  // evenly over the frames

base::Result<Json> read_json(const fs::path& path) {
  std::ifstream in(path);
  if (!in) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "is not there",
                      "set TOUCHLINE_DATA or --data to the folder of all sets");
  }
  Json json = Json::parse(in, nullptr, false);
  if (json.is_discarded()) return base::fail(base::ErrorKind::kFormat, path.string(), "is no JSON");
  return json;
}

// A number of an object; -1 where it is not there.
double number(const Json& object, const char* key) {
  if (!object.is_object()) return -1;
  const auto found = object.find(key);
  return found != object.end() && found->is_number() ? found->get<double>() : -1;
}

// So many numbers; none where there is anything else.
std::optional<std::vector<double>> numbers(const Json& json, std::size_t count) {
  if (!json.is_array() || json.size() != count) return std::nullopt;
  std::vector<double> out;
  for (const Json& item : json) {
    if (!item.is_number()) return std::nullopt;
    out.push_back(item.get<double>());
  }
  return out;
}

// The clicked lines' names, and which marking of ours each is.
const std::map<std::string, pitch::MarkingId>& marking_names() {
  using enum pitch::MarkingId;
  static const std::map<std::string, pitch::MarkingId> kNames{
      {"Side line top", kFarTouchline},
      {"Side line bottom", kNearTouchline},
      {"Side line left", kLeftGoalLine},
      {"Side line right", kRightGoalLine},
      {"Middle line", kHalfwayLine},
      {"Circle central", kCentreCircle},
      {"Circle left", kLeftPenaltyArc},
      {"Circle right", kRightPenaltyArc},
      {"Big rect. left main", kLeftPenaltyFront},
      {"Big rect. left top", kLeftPenaltyFar},
      {"Big rect. left bottom", kLeftPenaltyNear},
      {"Big rect. right main", kRightPenaltyFront},
      {"Big rect. right top", kRightPenaltyFar},
      {"Big rect. right bottom", kRightPenaltyNear},
      {"Small rect. left main", kLeftGoalAreaFront},
      {"Small rect. left top", kLeftGoalAreaFar},
      {"Small rect. left bottom", kLeftGoalAreaNear},
      {"Small rect. right main", kRightGoalAreaFront},
      {"Small rect. right top", kRightGoalAreaFar},
      {"Small rect. right bottom", kRightGoalAreaNear},
  };
  return kNames;
}

// "Goal left post right" and the like: posts are named as seen from the pitch.
std::string bar_name(const pitch::Bar& bar) {
  const bool left_end = bar.start.x() < 0;
  const std::string goal = left_end ? "Goal left " : "Goal right ";
  if (std::abs(bar.start.z() - bar.end.z()) < 0.5) return goal + "crossbar";
  const bool near = bar.start.y() < 0;
  return goal + (near == left_end ? "post left" : "post right");
}

std::vector<ClickTarget> named_targets(const pitch::PitchModel& pitch) {
  std::vector<ClickTarget> targets;
  for (const auto& [name, id] : marking_names()) {
    const pitch::Marking* marking = pitch.find(id);
    if (marking == nullptr) continue;
    targets.push_back(target_of(pitch, *marking, kPieceM));
    targets.back().name = name;
  }
  for (const pitch::Bar& bar : pitch.bars) {
    const bool of_frame =
        std::abs(std::abs(bar.start.x()) - 0.5 * (pitch.length_m - pitch.line_m)) < 0.3 &&
        std::abs(bar.end.x() - bar.start.x()) < 0.1 && bar.end.z() > 2 &&
        std::abs(bar.start.y()) < pitch.goal_width_m;
    if (!of_frame) continue;
    targets.push_back(target_of(bar));
    targets.back().name = bar_name(bar);
  }
  return targets;
}

struct Frame {
  std::string name;
  std::array<std::vector<Click>, 2> halves;
};

std::vector<Frame> frames_of(const Json& json, const std::vector<ClickTarget>& targets,
                             std::size_t& unknown) {
  std::vector<Frame> frames;
  if (!json.is_object()) return frames;
  for (const auto& [name, lines] : json.items()) {
    if (!lines.is_object()) continue;
    Frame frame;
    frame.name = name;
    std::size_t turn = 0;  // a line of one point goes to either half in turn
    for (const auto& [line, points] : lines.items()) {
      std::string trimmed = line;
      while (!trimmed.empty() && trimmed.back() == ' ') trimmed.pop_back();
      const auto target =
          std::find_if(targets.begin(), targets.end(),
                       [&](const ClickTarget& candidate) { return candidate.name == trimmed; });
      if (target == targets.end() || !points.is_array()) {
        ++unknown;
        continue;
      }
      const auto index = static_cast<std::size_t>(target - targets.begin());
      std::size_t k = turn++;
      for (const Json& point : points) {
        const double x = number(point, "x"), y = number(point, "y");
        if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1)) continue;
        frame.halves[k++ % 2].push_back({index, {x * (kWidth - 1), y * (kHeight - 1)}});
      }
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

// The published frame has y towards the camera side and z down: a half turn about x.
std::optional<CameraEstimate> published_camera(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  const auto member = [&](const char* key) {
    const auto found = json.find(key);
    return found == json.end() ? Json() : *found;
  };
  const auto place = numbers(member("position_meters"), 3);
  const auto middle = numbers(member("principal_point"), 2);
  const Json rotation = member("rotation_matrix");
  const double focal_x = number(json, "x_focal_length"), focal_y = number(json, "y_focal_length");
  if (!place || !middle || !rotation.is_array() || rotation.size() != 3 ||
      !(std::min(focal_x, focal_y) > 0))
    return std::nullopt;
  Eigen::Matrix3d cam_from_theirs;
  for (int r = 0; r < 3; ++r) {
    const auto row = numbers(rotation[static_cast<std::size_t>(r)], 3);
    if (!row) return std::nullopt;
    cam_from_theirs.row(r) = Eigen::Map<const Eigen::RowVector3d>(row->data());
  }
  const Eigen::DiagonalMatrix<double, 3> theirs_from_ours(1, -1, -1);
  const Eigen::Vector3d position = theirs_from_ours * Eigen::Vector3d(place->data());
  CameraEstimate camera;
  camera.model = {kWidth, kHeight, focal_x, focal_y, (*middle)[0], (*middle)[1], 0, 0};
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond(Eigen::Matrix3d(cam_from_theirs * theirs_from_ours)).normalized();
  camera.cam_from_world = {turn, -(turn * position)};
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

struct Tally {
  std::size_t frames = 0, solved = 0;
  std::array<double, 3> jaccard{};
  std::vector<double> distances;

  void add(const std::optional<CameraEstimate>& camera, const std::vector<ClickTarget>& targets,
           const std::vector<Click>& held, const std::vector<Click>& others) {
    ++frames;
    for (std::size_t i = 0; i < kThresholds.size(); ++i)
      jaccard[i] += score::jaccard(camera, targets, held, others, kThresholds[i]);
    if (!camera) return;
    ++solved;
    for (const Click& click : held) {
      const auto distance = click_distance(*camera, targets[click.target], click.pixel);
      distances.push_back(distance.value_or(kWidth));
    }
  }

  SetRow row(const std::string& label) {
    SetRow row{label, {}};
    const auto count = static_cast<double>(std::max<std::size_t>(frames, 1));
    row.cells.push_back({"solved", 100 * static_cast<double>(solved) / count, "%", frames});
    for (std::size_t i = 0; i < kThresholds.size(); ++i)
      row.cells.push_back(
          {fmt::format("JaC@{:.0f}", kThresholds[i]), 100 * jaccard[i] / count, "%", frames});
    std::sort(distances.begin(), distances.end());
    const std::size_t n = distances.size();
    const auto at = [&](double share) {
      return n == 0 ? std::nan("")
                    : distances[std::min(n - 1,
                                         static_cast<std::size_t>(share * static_cast<double>(n)))];
    };
    row.cells.push_back({"median", at(0.5), "px", n});
    row.cells.push_back({"80th", at(0.8), "px", n});
    row.cells.push_back({"95th", at(0.95), "px", n});
    return row;
  }
};

// Fitted points white, held ones yellow; our lines cyan, the published ones red.
base::Status draw(const fs::path& folder, const Frame& frame,
                  const std::optional<CameraEstimate>& ours,
                  const std::optional<CameraEstimate>& theirs, const pitch::PitchModel& pitch) {
  Overlay overlay(kWidth, kHeight);
  if (theirs) overlay.draw_pitch(*theirs, pitch, {255, 60, 60});
  if (ours) overlay.draw_pitch(*ours, pitch, {0, 255, 255});
  for (const Click& click : frame.halves[0]) overlay.draw_dot(click.pixel, {255, 255, 255}, 2);
  for (const Click& click : frame.halves[1]) overlay.draw_dot(click.pixel, {255, 255, 0}, 2);
  return overlay.write(folder / ("pitch-lines-" + frame.name + ".png"));
}

}  // namespace

base::Result<SetReport> run_pitch_lines(const SetOptions& options) {
  const fs::path folder = options.data / "pitch-lines";
  const auto lines = read_json(folder / "broadcast_lines_gt.json");
  if (!lines) return base::fail(lines.error());
  const auto published = read_json(folder / "broadcast_cameras_pnlcalib.json");
  if (!published) return base::fail(published.error());
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  if (!pitch) return base::fail(pitch.error());
  const std::vector<ClickTarget> targets = named_targets(*pitch);
  std::size_t unknown = 0;
  const std::vector<Frame> frames = frames_of(*lines, targets, unknown);

  Tally plain, bent, theirs;
  ClickFitOptions without_lens, with_lens;
  with_lens.lens_sd = 0.01;
  std::size_t drawn = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Frame& frame = frames[i];
    std::optional<CameraEstimate> camera_there;
    if (const auto found = published->find(frame.name); found != published->end())
      camera_there = published_camera(*found);
    for (std::size_t half = 0; half < 2; ++half) {
      const auto& fitted = frame.halves[half];
      const auto& held = frame.halves[1 - half];
      const auto camera = fit_clicks(targets, fitted, *pitch, with_lens);
      plain.add(fit_clicks(targets, fitted, *pitch, without_lens), targets, held, fitted);
      bent.add(camera, targets, held, fitted);
      theirs.add(camera_there, targets, held, fitted);
      if (options.pictures.empty() || half == 1 || i * kPictures < drawn * frames.size()) continue;
      ++drawn;
      if (auto status = draw(options.pictures, frame, camera, camera_there, *pitch); !status)
        return base::fail(status.error());
    }
  }
  SetReport report;
  report.name = "pitch-lines";
  report.what = fmt::format(
      "{} broadcast frames with hand-clicked points on named lines, each fitted on either half of "
      "its points and measured on the other; pixels at {} x {}, pitch taken as 105 x 68 m.",
      frames.size(), kWidth, kHeight);
  report.rows = {plain.row("ours, no lens"), bent.row("ours, lens"), theirs.row("published")};
  report.notes.push_back(
      "ours: pan, tilt, roll, focal length and position by edge/calibrate's pose fit from no "
      "start; lens: k1 and k2 as well, sigma 1 % of the radius at the corner");
  report.notes.push_back(
      "published: a method's estimates from the pictures, without the clicks; a frame without a "
      "camera counts 0 in JaC");
  if (unknown > 0)
    report.notes.push_back(fmt::format("{} lines of names we do not know were left out", unknown));
  return report;
}

}  // namespace touchline::score
