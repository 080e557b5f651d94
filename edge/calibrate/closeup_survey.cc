#include "edge/calibrate/closeup_survey.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kAnySize = 100;    // metres: a size that is not held against the lines
constexpr double kNewViews = 0.12;  // of a picture's width: pictures that look elsewhere

// A picture by itself.
struct Solved {
  std::size_t frame = 0;
  geometry::Mount mount;
  geometry::CameraEstimate camera;
};

base::Error no_place(std::string what) {
  return {base::ErrorKind::kNumerical, "close-up", std::move(what),
          "survey this head by stills, or start it where it shows an arc and a line"};
}

// The order in which pictures are tried: the last, the first, the middle, and those between.
std::vector<std::size_t> order(std::size_t count, int pictures) {
  std::vector<std::size_t> out;
  for (std::size_t parts = 1; out.size() < static_cast<std::size_t>(pictures) && parts < 2 * count;
       parts *= 2) {
    for (std::size_t i = parts + 1; i-- > 0;) {
      const std::size_t frame = i * (count - 1) / parts;
      if (std::find(out.begin(), out.end(), frame) == out.end()) out.push_back(frame);
    }
  }
  out.resize(std::min(out.size(), static_cast<std::size_t>(pictures)));
  return out;
}

SurveyOptions of_picture(const CloseupSurveyOptions& options) {
  SurveyOptions survey = options.survey;
  if (!survey.length_stated || !survey.width_stated || !survey.crown_stated)
    survey.size_tolerance_m = kAnySize;
  survey.length_stated = survey.width_stated = survey.crown_stated = true;
  survey.cold_start.arcs = true;
  survey.cold_start.refine_lens = false;
  survey.cold_start.most_focal = options.most_focal;
  survey.fixed_roll_prior_deg = options.roll_deg;
  survey.principal_prior_px = options.principal_px;
  survey.shift_prior = options.shift;
  survey.least_confirmed = options.least_confirmed;
  survey.least_explained = options.least_explained;
  return survey;
}

bool agree(const Solved& a, const Solved& b, const CloseupSurveyOptions& options) {
  const Eigen::Vector3d apart = a.mount.position_in_world - b.mount.position_in_world;
  const Eigen::Matrix3d spread =
      a.mount.covariance.topLeftCorner<3, 3>() + b.mount.covariance.topLeftCorner<3, 3>() +
      std::pow(options.agree_m / options.agree_sigmas, 2) * Eigen::Matrix3d::Identity();
  return apart.dot(spread.ldlt().solve(apart)) < options.agree_sigmas * options.agree_sigmas;
}

bool looks_elsewhere(const Solved& a, const Solved& b) {
  const auto axis = [](const Solved& s) -> Eigen::Vector3d {
    return s.camera.cam_from_world.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  };
  const double turn = std::acos(std::clamp(axis(a).dot(axis(b)), -1.0, 1.0));
  return turn * std::min(a.camera.model.fx, b.camera.model.fx) >= kNewViews * a.mount.width;
}

// Estimates of the frames, followed from one of them to either end.
class Follower {
 public:
  Follower(std::span<const image::FramePtr> frames, const pitch::PitchModel& pitch,
           const CalibrateOptions& options)
      : estimates(frames.size()), frames_(frames), pitch_(pitch), options_(options) {}

  void follow(const geometry::Mount& mount, std::size_t from,
              const geometry::CameraEstimate& camera) {
    Calibrator onwards(pitch_, mount, options_);
    onwards.start_from(camera);
    for (std::size_t i = from; i < frames_.size(); ++i)
      estimates[i] = onwards.process(*frames_[i]).estimate;
    // Backwards time runs the other way.
    Calibrator back(pitch_, mount, options_);
    back.start_from(camera);
    const std::int64_t middle = frames_[from]->stamp.media_time.ns;
    for (std::size_t i = from; i-- > 0;) {
      image::Frame mirrored = *frames_[i];
      mirrored.stamp.media_time.ns = 2 * middle - mirrored.stamp.media_time.ns;
      estimates[i] = back.process(mirrored).estimate;
    }
  }

  bool by_lines(std::size_t i) const { return estimates[i].evidence == geometry::Evidence::kLines; }
  std::size_t solved() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < estimates.size(); ++i) count += by_lines(i) ? 1 : 0;
    return count;
  }

  std::vector<geometry::CameraEstimate> estimates;

 private:
  std::span<const image::FramePtr> frames_;
  const pitch::PitchModel& pitch_;
  const CalibrateOptions& options_;
};

// The frames together, from one solved picture.
base::Result<CloseupSurvey> solve_take(std::span<const image::FramePtr> frames,
                                       const pitch::PitchModel& pitch, const Solved& start,
                                       const CloseupSurveyOptions& options) {
  TakeSurvey take(pitch, start.mount, options.views());
  Follower follower(frames, pitch, options.calibrate);
  geometry::CameraEstimate camera = start.camera;
  std::optional<CloseupSurvey> out;
  for (int pass = 0; pass < options.passes; ++pass) {
    follower.follow(take.mount(), start.frame, camera);
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (follower.by_lines(i)) take.add(*frames[i], follower.estimates[i]);
    auto solved = take.solve();
    if (!solved) break;
    if (follower.by_lines(start.frame)) camera = follower.estimates[start.frame];
    camera.covariance.setZero();
    out.emplace();
    out->take = std::move(*solved);
  }
  if (!out) return base::fail(no_place("too few views of the take can be followed by their lines"));
  follower.follow(take.mount(), start.frame, camera);
  out->first = follower.estimates.front();
  out->solved = follower.solved();
  if (static_cast<double>(out->solved) < options.least_solved * static_cast<double>(frames.size()))
    return base::fail(no_place(
        fmt::format("{} of {} frames are followed by their lines", out->solved, frames.size())));
  return *std::move(out);
}

}  // namespace

base::Status CloseupSurveyOptions::validate() const {
  for (const base::Status& part : {survey.validate(), take.validate(), calibrate.validate()})
    if (!part) return part;
  for (const base::Status& status :
       {base::in_bounds("pictures", pictures, 2, 64), base::in_bounds("passes", passes, 1, 20),
        base::in_bounds("most_focal", most_focal, 1, 40),
        base::in_bounds("roll_deg", roll_deg, 0.001, 30),
        base::in_bounds("principal_px", principal_px, 0.01, 1000),
        base::in_bounds("shift", shift, 0.0001, 1),
        base::in_bounds("spacing", spacing, 0.006, 0.99),
        base::in_bounds("thin_line_px", thin_line_px, 0.01, 10),
        base::in_bounds("least_confirmed", least_confirmed, 0, 1),
        base::in_bounds("least_explained", least_explained, 0, 1),
        base::in_bounds("agree_m", agree_m, 0.01, 100),
        base::in_bounds("agree_sigmas", agree_sigmas, 0.1, 100),
        base::in_bounds("least_solved", least_solved, 0, 1)})
    if (!status) return status;
  return {};
}

TakeSurveyOptions CloseupSurveyOptions::views() const {
  TakeSurveyOptions views = take;
  views.points.least_width_px = thin_line_px;
  views.spacing = spacing;
  return views;
}

base::Result<CloseupSurvey> survey_closeup(std::span<const image::FramePtr> frames,
                                           const pitch::PitchModel& pitch, Side side,
                                           const CloseupSurveyOptions& options) {
  if (auto status = options.validate(); !status) return base::fail(status.error());
  if (frames.empty()) return base::fail(no_place("no picture"));
  const SurveyOptions survey = of_picture(options);
  std::vector<Solved> solved;
  std::string why = "one picture alone does not tell the place";
  bool turned = false;
  for (const std::size_t i : order(frames.size(), options.pictures)) {
    auto found = survey_fixed(std::span(frames[i].get(), 1), pitch, side, survey);
    if (!found) {
      if (solved.empty()) why = found.error().what;
      continue;
    }
    const Solved now{i, std::move(found->mount), std::move(found->stills.front())};
    for (const Solved& other : solved) {
      if (!looks_elsewhere(now, other)) continue;
      turned = true;
      if (!agree(now, other, options)) continue;
      const auto variance = [](const Solved& s) {
        return s.mount.covariance.topLeftCorner<3, 3>().trace();
      };
      auto out = solve_take(frames, pitch, variance(now) < variance(other) ? now : other, options);
      if (out) return out;
      why = out.error().what;
    }
    solved.push_back(now);
  }
  if (solved.size() > 1 && !turned)
    why = fmt::format("{} pictures tell a place, but the head turned by less than {:.0f} % of one",
                      solved.size(), 100 * kNewViews);
  else if (solved.size() > 1)
    why = "pictures that were solved by themselves disagree on the place, or: " + why;
  return base::fail(no_place(std::move(why)));
}

}  // namespace touchline::calibrate
