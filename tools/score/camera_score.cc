#include "tools/score/camera_score.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "shared/recording/camera_table.h"
#include "tools/score/score_context.h"

namespace touchline::score {

namespace {

constexpr double kDegrees = 180 / 3.14159265358979323846;

const ScoreKind kSolved{"cameras", "frames solved", "%", Better::kHigher, Statistic::kMean, 1};
const ScoreKind kRms{"cameras", "rms on a 1 m grid", "px", Better::kLower, Statistic::kMean, 3};
const std::array<ScoreKind, 3> kJaccard = {{
    {"cameras", "JaC@5 at 960x540", "%", Better::kHigher, Statistic::kMean, 1},
    {"cameras", "JaC@10 at 960x540", "%", Better::kHigher, Statistic::kMean, 1},
    {"cameras", "JaC@20 at 960x540", "%", Better::kHigher, Statistic::kMean, 1},
}};
const ScoreKind kPanNoise{"cameras", "pan noise", "deg", Better::kLower, Statistic::kRootMeanSquare,
                          5};
const ScoreKind kPan{"cameras", "pan error", "deg", Better::kLower, Statistic::kRootMeanSquare, 4};
const ScoreKind kTilt{"cameras", "tilt error", "deg", Better::kLower, Statistic::kRootMeanSquare,
                      4};
const ScoreKind kFocal{"cameras", "focal error", "%", Better::kLower, Statistic::kRootMeanSquare,
                       4};
const ScoreKind kPosition{"cameras", "position error", "m", Better::kLower, Statistic::kMean, 3};
const ScoreKind kPanHonesty{"cameras",    "pan error over stated sd", "",
                            Better::kOne, Statistic::kRootMeanSquare, 2};
const ScoreKind kTiltHonesty{"cameras",    "tilt error over stated sd", "",
                             Better::kOne, Statistic::kRootMeanSquare,  2};
const ScoreKind kFocalHonesty{"cameras",    "focal error over stated sd", "",
                              Better::kOne, Statistic::kRootMeanSquare,   2};
// Of pan, tilt and focal length, a third of the sum of the squared quotients.
const ScoreKind kCommon{
    "cameras", "normalised square error, all frames", "", Better::kOne, Statistic::kMean, 2};
const ScoreKind kFrameToFrame{
    "cameras", "normalised square error, between frames", "", Better::kLower, Statistic::kMean, 2};

using Points = std::vector<std::optional<Eigen::Vector2d>>;

Points marking_pixels(const pitch::Marking& marking, const geometry::CameraEstimate& camera,
                      const pitch::PitchModel& pitch, double scale) {
  constexpr double kStep = 0.25;  // metres
  Points points;
  if (marking.shape == pitch::MarkingShape::kSpot) {
    points.push_back(geometry::project(camera, pitch.on_turf(marking.centre)));
  } else {
    const double length = marking.length();
    const int steps = std::max(1, static_cast<int>(std::ceil(length / kStep)));
    for (int i = 0; i <= steps; ++i) {
      points.push_back(
          geometry::project(camera, pitch.on_turf(marking.at(length * i / double(steps)))));
    }
  }
  for (auto& point : points) {
    if (point) *point *= scale;
  }
  return points;
}

double squared_distance(const Eigen::Vector2d& p, const Eigen::Vector2d& a,
                        const Eigen::Vector2d& b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0;
  return (p - (a + t * along)).squaredNorm();
}

// From p to the polyline between points first and last.
double squared_distance(const Eigen::Vector2d& p, const Points& line, std::size_t first,
                        std::size_t last) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i <= last; ++i) {
    if (!line[i]) continue;
    const auto& next = i < last && line[i + 1] ? line[i + 1] : line[i];
    least = std::min(least, squared_distance(p, *line[i], *next));
  }
  return least;
}

bool is_visible(const Points& points, const geometry::CameraModel& model, double scale) {
  return std::any_of(points.begin(), points.end(),
                     [&](const auto& point) { return point && model.sees(*point / scale); });
}

// The largest distance of a visible true point to the estimated marking; stops beyond the largest
// distance that counts.
double worst_distance(const Points& truth, const Points& estimate,
                      const geometry::CameraModel& model, double scale) {
  constexpr std::size_t kNear = 8;  // points either way where the nearest usually is
  const std::size_t last = truth.size() - 1;
  double worst = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (!truth[i] || !model.sees(*truth[i] / scale)) continue;
    double least =
        squared_distance(*truth[i], estimate, i < kNear ? 0 : i - kNear, std::min(i + kNear, last));
    if (least > kJaccardPx.front() * kJaccardPx.front()) {
      least = squared_distance(*truth[i], estimate, 0, last);
    }
    worst = std::max(worst, least);
    if (worst > kJaccardPx.back() * kJaccardPx.back()) break;
  }
  return std::sqrt(worst);
}

Eigen::Vector2d pan_tilt(const geometry::CameraEstimate& camera) {
  const Eigen::Vector3d axis =
      camera.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  return {std::atan2(axis.x(), axis.y()), std::asin(std::clamp(axis.z(), -1.0, 1.0))};
}

struct PanTrack {
  std::vector<std::int64_t> frames;
  std::vector<double> times_s;
  std::vector<double> errors_deg;
};

// Errors of pan, tilt and focal length, and what was stated of them.
struct Stated {
  std::vector<std::int64_t> frames;
  std::vector<Eigen::Array3d> errors;
  std::vector<Eigen::Array3d> variances;
};

// The mean error of a camera's frames, and what is left of each, over what was stated. Returns
// whether there was anything.
bool add_normalised(const Stated& stated, const std::string& camera, SeriesBook& book) {
  if (stated.frames.empty()) return false;
  const double n = static_cast<double>(stated.frames.size());
  Eigen::Array3d error = Eigen::Array3d::Zero();
  Eigen::Array3d variance = Eigen::Array3d::Zero();
  for (std::size_t i = 0; i < stated.frames.size(); ++i) {
    error += stated.errors[i] / n;
    variance += stated.variances[i] / n;
  }
  book.add(kCommon, camera, {stated.frames.front(), (error.square() / variance).mean()});
  for (std::size_t i = 0; i < stated.frames.size(); ++i) {
    const Eigen::Array3d off = stated.errors[i] - error;
    book.add(kFrameToFrame, camera,
             {stated.frames[i], (off.square() / stated.variances[i]).mean()});
  }
  return true;
}

void add_solved(const Context& context, const recording::CameraRow& row, const std::string& camera,
                const geometry::CameraEstimate& truth, SeriesBook& book, PanTrack& pan,
                Stated& stated) {
  geometry::CameraEstimate estimate;
  estimate.model = row.model;
  estimate.model.width = truth.model.width;
  estimate.model.height = truth.model.height;
  estimate.cam_from_world = row.cam_from_world;
  if (const auto value = grid_rms_px(truth, estimate, context.pitch)) {
    book.add(kRms, camera, {row.frame, *value});
  }
  const auto counts = count_markings(truth, estimate, context.pitch);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (const auto share = counts[i].jaccard()) {
      book.add(kJaccard[i], camera, {row.frame, 100 * *share, double(counts[i].all())});
    }
  }
  const CameraError error = camera_error(truth, estimate);
  pan.frames.push_back(row.frame);
  pan.times_s.push_back(static_cast<double>(row.frame) * context.recording.rate.period_s());
  pan.errors_deg.push_back(error.pan_deg);
  book.add(kPan, camera, {row.frame, error.pan_deg});
  book.add(kTilt, camera, {row.frame, error.tilt_deg});
  book.add(kFocal, camera, {row.frame, 100 * error.focal_rel});
  book.add(kPosition, camera, {row.frame, error.position_m});
  if (!row.report) return;
  const auto honesty = [&](const ScoreKind& kind, double value, double sd) {
    if (sd > 0) book.add(kind, camera, {row.frame, value / sd});
  };
  honesty(kPanHonesty, error.pan_deg, row.report->sd_pan_deg);
  honesty(kTiltHonesty, error.tilt_deg, row.report->sd_tilt_deg);
  honesty(kFocalHonesty, error.focal_rel, row.report->sd_focal_rel);
  const Eigen::Array3d sd(row.report->sd_pan_deg, row.report->sd_tilt_deg,
                          row.report->sd_focal_rel);
  if (!(sd.minCoeff() > 0)) return;
  stated.frames.push_back(row.frame);
  stated.errors.emplace_back(error.pan_deg, error.tilt_deg, error.focal_rel);
  stated.variances.emplace_back(sd.square());
}

}  // namespace

std::optional<double> MarkingCount::jaccard() const {
  if (all() == 0) return std::nullopt;
  return static_cast<double>(right) / all();
}

std::optional<double> grid_rms_px(const geometry::CameraEstimate& truth,
                                  const geometry::CameraEstimate& estimate,
                                  const pitch::PitchModel& pitch) {
  constexpr double kRound = 4;  // metres
  const int half_x = static_cast<int>(pitch.length_m / 2 + pitch.in_goal_m + kRound);
  const int half_y = static_cast<int>(pitch.width_m / 2 + kRound);
  double sum = 0;
  std::size_t count = 0;
  for (int x = -half_x; x <= half_x; ++x) {
    for (int y = -half_y; y <= half_y; ++y) {
      const Eigen::Vector3d point = pitch.on_turf({x, y});
      const auto should = geometry::project(truth, point);
      if (!should || !truth.model.sees(*should)) continue;
      const auto is = geometry::project(estimate, point);
      const double limit = truth.model.width;
      const double distance = is ? std::min((*is - *should).norm(), limit) : limit;
      sum += distance * distance;
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(sum / static_cast<double>(count));
}

std::array<MarkingCount, 3> count_markings(const geometry::CameraEstimate& truth,
                                           const geometry::CameraEstimate& estimate,
                                           const pitch::PitchModel& pitch) {
  const double scale = 960.0 / truth.model.width;
  std::array<MarkingCount, 3> counts;
  for (const pitch::Marking& marking : pitch.markings) {
    const Points should = marking_pixels(marking, truth, pitch, scale);
    const Points is = marking_pixels(marking, estimate, pitch, scale);
    const bool in_truth = is_visible(should, truth.model, scale);
    const bool in_estimate = is_visible(is, truth.model, scale);
    if (!in_truth && !in_estimate) continue;
    const double worst =
        in_truth && in_estimate ? worst_distance(should, is, truth.model, scale) : 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (!in_estimate) {
        ++counts[i].missed;
      } else if (!in_truth || worst > kJaccardPx[i]) {
        ++counts[i].wrong;
      } else {
        ++counts[i].right;
      }
    }
  }
  return counts;
}

CameraError camera_error(const geometry::CameraEstimate& truth,
                         const geometry::CameraEstimate& estimate) {
  const Eigen::Vector2d should = pan_tilt(truth);
  const Eigen::Vector2d is = pan_tilt(estimate);
  CameraError error;
  error.pan_deg = std::remainder((is.x() - should.x()) * kDegrees, 360.0);
  error.tilt_deg = (is.y() - should.y()) * kDegrees;
  error.focal_rel = estimate.model.fx / truth.model.fx - 1;
  error.position_m =
      (geometry::position_in_world(estimate) - geometry::position_in_world(truth)).norm();
  return error;
}

std::vector<std::optional<double>> without_slow_part(std::span<const double> times_s,
                                                     std::span<const double> values) {
  constexpr double kHalf = 0.5 + 1e-6;  // seconds
  constexpr std::size_t kLeast = 5;
  std::vector<std::optional<double>> out(values.size());
  std::size_t first = 0;
  std::size_t end = 0;
  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    while (end < values.size() && times_s[end] <= times_s[i] + kHalf) sum += values[end++];
    while (times_s[first] < times_s[i] - kHalf) sum -= values[first++];
    if (end - first >= kLeast) out[i] = values[i] - sum / static_cast<double>(end - first);
  }
  return out;
}

std::array<double, 2> mean_square_band(int count) {
  constexpr double kSigmas = 1.6449;  // of a normal variable, 5 % beyond
  const double v = 2.0 / (9.0 * std::max(count, 1));
  return {std::pow(std::max(0.0, 1 - v - kSigmas * std::sqrt(v)), 3),
          std::pow(1 - v + kSigmas * std::sqrt(v), 3)};
}

base::Status score_cameras(const Context& context, SeriesBook& book, Remarks& remarks) {
  int honest_cameras = 0;
  for (const recording::CameraEntry& entry : context.recording.cameras) {
    const std::string& id = entry.id.value;
    const std::vector<std::int64_t> instants = context.instants(entry.id);
    if (instants.empty()) {
      remarks.not_scored.push_back(
          fmt::format("camera {}: the truth has no {}/cameras.csv", id, id));
      continue;
    }
    const std::filesystem::path path = context.options.exports / "cameras" / (id + ".csv");
    if (!is_there(path)) {
      remarks.not_scored.push_back(fmt::format("camera {}: no {}", id, path.string()));
      continue;
    }
    const auto rows = recording::read_camera_table(path);
    if (!rows) return base::fail(rows.error());
    std::map<std::int64_t, const recording::CameraRow*> by_frame;
    for (const recording::CameraRow& row : *rows) by_frame[row.frame] = &row;
    PanTrack pan;
    Stated stated;
    for (const std::int64_t instant : instants) {
      const auto row = by_frame.find(instant);
      // Rows without a report count as solved.
      const bool solved =
          row != by_frame.end() &&
          !(row->second->report && row->second->report->state == geometry::Evidence::kLost);
      book.add(kSolved, id, {instant, solved ? 100.0 : 0.0});
      const auto truth = context.camera(entry.id, instant);
      if (solved && truth) add_solved(context, *row->second, id, *truth, book, pan, stated);
    }
    if (add_normalised(stated, id, book)) ++honest_cameras;
    const auto noise = without_slow_part(pan.times_s, pan.errors_deg);
    for (std::size_t i = 0; i < noise.size(); ++i) {
      if (noise[i]) book.add(kPanNoise, id, {pan.frames[i], *noise[i]});
    }
    if (pan.frames.empty()) {
      remarks.not_scored.push_back(
          fmt::format("camera {}: lost in every frame, so it has no errors", id));
    }
  }
  if (honest_cameras > 0) {
    const auto band = mean_square_band(3 * honest_cameras);
    remarks.notes.push_back(fmt::format(
        "normalised square error, all frames: of {} camera(s) whose stated deviations of pan, tilt "
        "and focal length are true and independent, 90 % lie within {:.2f} .. {:.2f}",
        honest_cameras, band[0], band[1]));
  }
  return {};
}

}  // namespace touchline::score
