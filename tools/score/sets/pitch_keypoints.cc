#include "tools/score/sets/pitch_keypoints.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/survey/survey_solve.h"
#include "shared/geometry/mount.h"
#include "shared/pitch/pitch_model.h"
#include "tools/score/sets/clicked_camera.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;
using geometry::CameraEstimate;

constexpr int kWidth = 960;  // pictures are 16:9 before they were stretched to a square
constexpr int kHeight = 540;
constexpr int kPoints = 32;
constexpr std::size_t kLeastPoints = 5;  // of a half of a view
constexpr double kPointPx = 1;           // standard deviation of a label
constexpr double kLensSd = 0.02;

// The labelled points, in their order: from the far left corner along the far side.
std::vector<Eigen::Vector3d> keypoints(const pitch::PitchModel& pitch) {
  const double l = 0.5 * pitch.length_m, w = 0.5 * pitch.width_m;
  const double half_line = 0.5 * pitch.line_m;
  // Marks stand on the middle of the painted lines.
  const double goal = l - half_line, side = w - half_line;
  const double area = 20.16 - half_line, small = 9.16 - half_line;
  const double front = l - 16.5 + half_line, small_front = l - 5.5 + half_line;
  const double spot = l - 11, radius = 9.15 - half_line;
  // Where the arc meets the front of the area.
  const double chord = std::sqrt(radius * radius - (spot - front) * (spot - front));
  std::vector<Eigen::Vector2d> left{{-goal, side},         {-goal, area},          {-goal, small},
                                    {-goal, -small},       {-goal, -area},         {-goal, -side},
                                    {-small_front, small}, {-small_front, -small}, {-spot, 0},
                                    {-front, area},        {-front, chord},        {-front, -chord},
                                    {-front, -area}};
  std::vector<Eigen::Vector2d> points = left;
  for (const double y : {side, radius, -radius, -side}) points.emplace_back(0, y);
  // The right end is the left one's mirror image, from the front of its area outwards.
  for (const std::size_t i : {9U, 10U, 11U, 12U, 8U, 6U, 7U, 0U, 1U, 2U, 3U, 4U, 5U})
    points.emplace_back(-left[i].x(), left[i].y());
  points.emplace_back(-radius, 0);
  points.emplace_back(radius, 0);
  std::vector<Eigen::Vector3d> out;
  for (const Eigen::Vector2d& p : points) out.push_back(pitch.on_turf(p));
  return out;
}

struct View {
  std::string name;
  std::vector<Click> clicks;  // target = keypoint
};

// A label file: class, box, then x, y (0..1) and visibility of each point.
std::optional<View> read_view(const fs::path& path) {
  std::ifstream in(path);
  std::string line;
  if (!std::getline(in, line)) return std::nullopt;
  std::istringstream fields(line);
  double skipped = 0;
  for (int i = 0; i < 5; ++i) fields >> skipped;
  View view;
  view.name = path.stem().string();
  for (int i = 0; i < kPoints; ++i) {
    double x = 0, y = 0, visible = 0;
    if (!(fields >> x >> y >> visible)) return std::nullopt;
    if (visible > 0 && x > 0 && x < 1 && y > 0 && y < 1)
      view.clicks.push_back({static_cast<std::size_t>(i), {x * kWidth - 0.5, y * kHeight - 0.5}});
  }
  return view;
}

// "train_42ba34_2_13" -> "42ba34".
std::string match_of(const std::string& name) {
  const auto first = name.find('_');
  const auto second = name.find('_', first + 1);
  return first == std::string::npos ? name : name.substr(first + 1, second - first - 1);
}

class Half {
 public:
  Half(const View& view, std::size_t half) {
    for (std::size_t i = 0; i < view.clicks.size(); ++i)
      (i % 2 == half ? fitted : held).push_back(view.clicks[i]);
  }
  std::vector<Click> fitted, held;
};

struct Common {
  calibrate::SurveyProblem problem;
  Eigen::Vector3d size_change = Eigen::Vector3d::Zero();
  Eigen::Vector3d size_sigma = Eigen::Vector3d::Zero();
  bool converged = false;
};

// All views from one place, started from their own cameras.
Common solve_common(const std::vector<CameraEstimate>& alone,
                    const std::vector<std::vector<Click>>& clicks,
                    const std::vector<Eigen::Vector3d>& points,
                    const std::array<std::vector<Eigen::Vector3d>, 3>& larger, bool sizes) {
  Common common;
  geometry::Mount& mount = common.problem.mount;
  mount.width = kWidth;
  mount.height = kHeight;
  mount.cx = 0.5 * (kWidth - 1);
  mount.cy = 0.5 * (kHeight - 1);
  double least = 1e12, most = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const CameraEstimate& camera : alone) values.push_back(position_in_world(camera)[axis]);
    std::nth_element(values.begin(),
                     values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
    mount.position_in_world[axis] = values[values.size() / 2];
  }
  for (std::size_t i = 0; i < alone.size(); ++i) {
    common.problem.heads.push_back(calibrate::head_pose(mount, alone[i]));
    common.problem.heads.back().roll = 0;
    least = std::min(least, alone[i].model.fx);
    most = std::max(most, alone[i].model.fx);
    for (const Click& click : clicks[i]) {
      for (int axis = 0; axis < 2; ++axis) {
        calibrate::SurveyPoint point;
        point.still = static_cast<int>(i);
        point.pixel = click.pixel;
        point.point_in_world = points[click.target];
        point.tangent_in_world = axis == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
        for (int size = 0; size < 3; ++size)
          point.by_size.col(size) =
              larger[static_cast<std::size_t>(size)][click.target] - points[click.target];
        common.problem.points.push_back(point);
      }
    }
  }
  if (most > 1.3 * least) {
    for (const double focal : {least, std::sqrt(least * most), most})
      mount.lens.push_back({focal, 0, 0});
  } else {
    mount.lens.push_back({std::sqrt(least * most), 0, 0});
  }
  calibrate::SurveySolveOptions options;
  options.principal_prior_px = 10;
  options.roll_sigma = 0.002;
  options.shift_sigma = kLensSd;
  options.point_sigma_px = kPointPx;
  options.correlated_points = 1;
  options.covariance = sizes;
  if (sizes) options.size_sigma = {1.5, 1.5, 0.1};
  for (const double loss : {20.0, 6.0, 3.0}) {
    options.loss_px = loss;
    const calibrate::SurveySolution solution = solve_survey(options, common.problem);
    common.converged = solution.converged;
    common.size_change = solution.size_change;
    common.size_sigma = solution.size_sigma;
  }
  return common;
}

CameraEstimate camera_of(const geometry::Mount& mount, const geometry::HeadPose& head) {
  CameraEstimate camera;
  camera.model = geometry::camera_model(mount, head.focal_px);
  camera.cam_from_world = geometry::cam_from_world(mount, head);
  camera.evidence = geometry::Evidence::kLines;
  return camera;
}

double quantile_of(std::vector<double> values, double share) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1,
                         static_cast<std::size_t>(share * static_cast<double>(values.size())))];
}

void add_distances(std::vector<SetCell>& cells, const std::vector<double>& distances) {
  const std::size_t n = distances.size();
  for (const double threshold : {5.0, 10.0, 20.0}) {
    const auto within =
        std::count_if(distances.begin(), distances.end(), [&](double d) { return d <= threshold; });
    cells.push_back(
        {fmt::format("within {:.0f}", threshold),
         100.0 * static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(n, 1)),
         "%", n});
  }
  cells.push_back({"median", quantile_of(distances, 0.5), "px", n});
  cells.push_back({"95th", quantile_of(distances, 0.95), "px", n});
}

// Root mean square distance from the mean.
double scatter(const std::vector<Eigen::Vector3d>& positions) {
  if (positions.size() < 2) return std::nan("");
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : positions) mean += p;
  mean /= static_cast<double>(positions.size());
  double sum = 0;
  for (const auto& p : positions) sum += (p - mean).squaredNorm();
  return std::sqrt(sum / static_cast<double>(positions.size() - 1));
}

std::array<std::vector<Eigen::Vector3d>, 3> larger_pitches(const pitch::PitchModel& pitch) {
  std::array<std::vector<Eigen::Vector3d>, 3> out;
  for (std::size_t i = 0; i < 3; ++i) {
    pitch::PitchSizes sizes{pitch.length_m, pitch.width_m, {}, pitch.crown_m, pitch.line_m};
    std::array<std::optional<double>*, 3>{&sizes.length_m, &sizes.width_m, &sizes.crown_m}[i]
        ->value() += 1.0;
    if (const auto model = pitch::make_pitch(pitch.sport, sizes)) {
      out[i] = keypoints(*model);
    } else {
      out[i] = keypoints(pitch);
    }
  }
  return out;
}

class Match {
 public:
  Match(std::string name, std::vector<View> views, const pitch::PitchModel& pitch)
      : name_(std::move(name)),
        views_(std::move(views)),
        pitch_(pitch),
        points_(keypoints(pitch)),
        larger_(larger_pitches(pitch)) {
    for (std::size_t i = 0; i < points_.size(); ++i)
      targets_.push_back({fmt::format("{}", i), {points_[i]}});
  }

  void run(SetReport& report) {
    std::vector<double> alone_px, common_px;
    std::vector<Eigen::Vector3d> alone_places;
    std::size_t left_out = 0, views = 0;
    for (std::size_t half = 0; half < 2; ++half) {
      std::vector<CameraEstimate> alone;
      std::vector<std::vector<Click>> fitted, held;
      for (const View& view : views_) {
        const Half split(view, half);
        const auto camera = solve(split.fitted);
        if (!camera || split.held.empty()) {
          ++left_out;
          continue;
        }
        ++views;
        alone.push_back(*camera);
        fitted.push_back(split.fitted);
        held.push_back(split.held);
        alone_places.push_back(position_in_world(*camera));
        measure(*camera, split.held, alone_px);
      }
      if (alone.size() < 2) continue;
      const Common common = solve_common(alone, fitted, points_, larger_, false);
      for (std::size_t i = 0; i < alone.size(); ++i)
        measure(camera_of(common.problem.mount, common.problem.heads[i]), held[i], common_px);
    }
    SetRow alone_row{name_ + " each alone", {{"views", static_cast<double>(views) / 2, "", views}}};
    add_distances(alone_row.cells, alone_px);
    alone_row.cells.push_back({"scatter", scatter(alone_places), "m", alone_places.size()});
    SetRow common_row{name_ + " one position",
                      {{"views", static_cast<double>(views) / 2, "", views}}};
    add_distances(common_row.cells, common_px);
    places(common_row, report);
    report.rows.push_back(std::move(alone_row));
    report.rows.push_back(std::move(common_row));
    if (left_out > 0)
      report.notes.push_back(fmt::format(
          "{}: {} of {} halves of views have too few points or no camera and were left out", name_,
          left_out, 2 * views_.size()));
  }

 private:
  std::optional<CameraEstimate> solve(const std::vector<Click>& clicks) const {
    if (clicks.size() < kLeastPoints) return std::nullopt;
    ClickFitOptions options;
    options.width = kWidth;
    options.height = kHeight;
    options.click_px = kPointPx;
    options.least_focal = 0.5;
    options.lens_sd = 0.01;
    return fit_clicks(targets_, clicks, pitch_, options);
  }

  void measure(const CameraEstimate& camera, const std::vector<Click>& held,
               std::vector<double>& distances) const {
    for (const Click& click : held)
      distances.push_back(
          click_distance(camera, targets_[click.target], click.pixel).value_or(kWidth));
  }

  // The position by all points, its scatter over thirds of the views, and the pitch's sizes.
  void places(SetRow& row, SetReport& report) const {
    std::vector<CameraEstimate> alone;
    std::vector<std::vector<Click>> clicks;
    for (const View& view : views_) {
      const auto camera = solve(view.clicks);
      if (!camera) continue;
      alone.push_back(*camera);
      clicks.push_back(view.clicks);
    }
    if (alone.size() < 6) return;
    const Common whole = solve_common(alone, clicks, points_, larger_, false);
    const Common sized = solve_common(alone, clicks, points_, larger_, true);
    const std::array<double, 3> found{sized.size_change.x(), sized.size_change.y(),
                                      sized.size_change.z()};
    // A match has one pitch: its size by all its views serves each third of them.
    std::vector<Eigen::Vector3d> own = points_;
    for (std::size_t i = 0; i < own.size(); ++i)
      for (std::size_t size = 0; size < 3; ++size)
        own[i] += found[size] * (larger_[size][i] - points_[i]);
    std::vector<Eigen::Vector3d> parts, sized_parts, own_parts;
    for (std::size_t part = 0; part < 3; ++part) {
      std::vector<CameraEstimate> some;
      std::vector<std::vector<Click>> theirs;
      for (std::size_t i = part; i < alone.size(); i += 3) {
        some.push_back(alone[i]);
        theirs.push_back(clicks[i]);
      }
      parts.push_back(
          solve_common(some, theirs, points_, larger_, false).problem.mount.position_in_world);
      own_parts.push_back(
          solve_common(some, theirs, own, larger_, false).problem.mount.position_in_world);
      sized_parts.push_back(
          solve_common(some, theirs, points_, larger_, true).problem.mount.position_in_world);
    }
    row.cells.push_back({"scatter", scatter(parts), "m", parts.size()});
    row.cells.push_back({"own size", scatter(own_parts), "m", own_parts.size()});
    row.cells.push_back({"sizes free", scatter(sized_parts), "m", sized_parts.size()});
    const Eigen::Vector3d& p = whole.problem.mount.position_in_world;
    row.cells.push_back({"x", p.x(), "m", alone.size()});
    row.cells.push_back({"y", p.y(), "m", alone.size()});
    row.cells.push_back({"z", p.z(), "m", alone.size()});
    report.notes.push_back(fmt::format(
        "{}: with free sizes the labels say {:.2f} ± {:.2f} x {:.2f} ± {:.2f} m, from {:.2f} "
        "{:.2f} "
        "{:.2f} m",
        name_, pitch_.length_m + found[0], sized.size_sigma.x(), pitch_.width_m + found[1],
        sized.size_sigma.y(), sized.problem.mount.position_in_world.x(),
        sized.problem.mount.position_in_world.y(), sized.problem.mount.position_in_world.z()));
  }

  std::string name_;
  std::vector<View> views_;
  const pitch::PitchModel& pitch_;
  std::vector<Eigen::Vector3d> points_;
  std::array<std::vector<Eigen::Vector3d>, 3> larger_;
  std::vector<ClickTarget> targets_;
};

}  // namespace

base::Result<SetReport> run_pitch_keypoints(const SetOptions& options) {
  const fs::path folder = options.data / "pitch-keypoints" / "labels";
  std::error_code code;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, code), end; !code && entry != end;
       entry.increment(code))
    if (entry->path().extension() == ".txt") files.push_back(entry->path());
  if (files.empty()) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(), "is not there",
                      "set TOUCHLINE_DATA or --data to the folder of all sets");
  }
  std::sort(files.begin(), files.end());
  const auto pitch = pitch::make_pitch(pitch::Sport::kSoccer, {});
  if (!pitch) return base::fail(pitch.error());
  std::map<std::string, std::vector<View>> matches;
  std::size_t unread = 0, count = 0;
  for (const fs::path& file : files) {
    auto view = read_view(file);
    if (!view) {
      ++unread;
      continue;
    }
    ++count;
    matches[match_of(view->name)].push_back(std::move(*view));
  }
  SetReport report;
  report.name = "pitch-keypoints";
  report.what = fmt::format(
      "{} views of {} matches with labelled points of the pitch, fitted on half of the points and "
      "measured on the other half; pixels at {} x {}, pitch taken as 105 x 68 m.",
      count, matches.size(), kWidth, kHeight);
  for (auto& [name, views] : matches) Match(name, std::move(views), *pitch).run(report);
  report.notes.push_back(
      "scatter: root mean square distance from their mean of the positions, of views solved alone "
      "on half of their points, or of three groups of views solved with one position each; own "
      "size: "
      "on the pitch of the size that all views of the match say, the same for each group; sizes "
      "free: each group finds its own");
  if (unread > 0) report.notes.push_back(fmt::format("{} label files cannot be read", unread));
  return report;
}

}  // namespace touchline::score
