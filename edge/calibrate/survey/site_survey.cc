#include "edge/calibrate/survey/site_survey.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "edge/calibrate/survey/survey_run_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kUnknownSigma = 20;  // metres: of a length or width that nobody measured
constexpr double kUnknownCrown = 0.5;
constexpr double kSettled = 0.003;  // metres
// A camera's word holds for sizes so near to those it was surveyed on; metres.
constexpr double kLinear = 0.05;
constexpr double kAnySize = 100;

Eigen::Vector3d sizes_of(const pitch::PitchModel& pitch) {
  return {pitch.length_m, pitch.width_m, pitch.crown_m};
}

base::Result<pitch::PitchModel> pitch_of(const pitch::PitchModel& like,
                                         const Eigen::Vector3d& size_m) {
  pitch::PitchSizes sizes{size_m(0), size_m(1), std::nullopt, std::max(0.0, size_m(2)),
                          like.line_m};
  if (like.sport == pitch::Sport::kRugbyUnion) sizes.in_goal_m = like.in_goal_m;
  return pitch::make_pitch(like.sport, sizes);
}

double sigmas(const Eigen::Vector3d& off, const Eigen::Matrix3d& covariance) {
  return std::sqrt(std::max(0.0, off.dot(covariance.ldlt().solve(off))) / 3);
}

}  // namespace

base::Status SiteSurveyOptions::validate() const {
  if (auto status = survey.validate(); !status) return status;
  for (const base::Status& status :
       {base::in_bounds("passes", passes, 1, 20),
        base::in_bounds("measured_sigma_m", measured_sigma_m, 0.001, 1),
        base::in_bounds("common_sigma_m", common_sigma_m, 0, 1),
        base::in_bounds("most_sigmas", most_sigmas, 1, 100)})
    if (!status) return status;
  return {};
}

FusedSizes fuse_sizes(std::span<const SizeEstimate> estimates, const SizeEstimate& prior,
                      double most_sigmas) {
  FusedSizes fused;
  fused.used.assign(estimates.size(), true);
  for (std::size_t left = estimates.size();; --left) {
    Eigen::Matrix3d information = prior.covariance.inverse();
    Eigen::Vector3d sum = information * prior.size_m;
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      if (!fused.used[i]) continue;
      const Eigen::Matrix3d weight = estimates[i].covariance.inverse();
      information += weight;
      sum += weight * estimates[i].size_m;
    }
    fused.sizes.covariance = information.inverse();
    fused.sizes.size_m = fused.sizes.covariance * sum;
    fused.off_sigmas.clear();
    std::size_t worst = estimates.size();
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      fused.off_sigmas.push_back(
          sigmas(estimates[i].size_m - fused.sizes.size_m, estimates[i].covariance));
      if (fused.used[i] && fused.off_sigmas[i] > most_sigmas &&
          (worst == estimates.size() || fused.off_sigmas[i] > fused.off_sigmas[worst]))
        worst = i;
    }
    if (worst == estimates.size() || 2 * (left - 1) < estimates.size() || left <= 2) return fused;
    fused.used[worst] = false;
  }
}

SiteSurvey::SiteSurvey(pitch::PitchModel pitch, SiteSurveyOptions options)
    : pitch_(std::move(pitch)), options_(std::move(options)) {}

base::Status SiteSurvey::add(const base::CameraId& camera, Side side,
                             std::span<const image::Frame> stills) {
  if (static_cast<int>(stills.size()) < options_.survey.least_stills) {
    return base::fail(base::ErrorKind::kConfiguration, camera.value,
                      fmt::format("has {} survey stills", stills.size()),
                      fmt::format("at least {} are needed", options_.survey.least_stills));
  }
  Camera added{camera, side, {}};
  for (const image::Frame& still : stills) {
    if (still.width() != stills.front().width() || still.height() != stills.front().height()) {
      return base::fail(base::ErrorKind::kConfiguration, camera.value,
                        fmt::format("has stills of {} x {} and {} x {}", stills.front().width(),
                                    stills.front().height(), still.width(), still.height()),
                        "all stills of a camera must have one size");
    }
    added.maps.push_back(detect_lines(still, options_.survey.line_map));
  }
  cameras_.push_back(std::move(added));
  return {};
}

base::Result<SiteSurveyResult> SiteSurvey::solve() const {
  if (cameras_.empty()) {
    return base::fail(base::ErrorKind::kConfiguration, "survey", "no camera has survey stills",
                      "put 12 to 16 stills of the empty pitch in each head's survey folder");
  }
  SurveyOptions open = options_.survey;  // every size is told by every camera
  open.length_stated = open.width_stated = open.crown_stated = false;
  SurveyOptions closed = options_.survey;  // the sizes are the site's
  closed.length_stated = closed.width_stated = closed.crown_stated = true;
  closed.size_tolerance_m = kAnySize;

  const Eigen::Array<bool, 3, 1> stated(options_.survey.length_stated, options_.survey.width_stated,
                                        options_.survey.crown_stated);
  SizeEstimate prior;
  prior.size_m = sizes_of(pitch_);
  for (int i = 0; i < 3; ++i) {
    const double unknown = i == 2 ? kUnknownCrown : kUnknownSigma;
    const double measured = i == 2 ? options_.survey.crown_sigma_m : options_.measured_sigma_m;
    prior.covariance(i, i) = std::pow(stated(i) ? measured : unknown, 2);
  }

  struct Word {
    std::optional<SizeEstimate> sizes;
    Eigen::Vector3d told_on = Eigen::Vector3d::Zero();  // the sizes it was surveyed on
  };
  std::vector<Word> words(cameras_.size());
  SiteSurveyResult out;
  for (const Camera& camera : cameras_) {
    out.cameras.push_back({camera.camera, base::fail(base::Error{}), {}, {}, 0, false});
    out.cameras.back().size_m.setZero();
    out.cameras.back().size_sigma_m.setZero();
  }
  out.pitch = pitch_;
  FusedSizes fused;
  std::vector<std::size_t> of_estimate;
  for (out.passes = 1; out.passes <= options_.passes; ++out.passes) {
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      if (words[i].sizes &&
          (words[i].told_on - sizes_of(out.pitch)).cwiseAbs().maxCoeff() <= kLinear)
        continue;
      auto& survey = out.cameras[i].survey;
      // On the usual sizes a camera looks for its own; later all are on those of the site.
      survey = out.passes == 1
                   ? survey_on_any_size(cameras_[i].maps, out.pitch, cameras_[i].side, open, true)
                   : run_survey(cameras_[i].maps, out.pitch, cameras_[i].side, open, true);
      if (!survey) continue;
      words[i].told_on = {survey->length_m, survey->width_m, survey->crown_m};
      words[i].sizes =
          SizeEstimate{words[i].told_on + survey->size_change_m,
                       survey->size_covariance_m2 +
                           std::pow(options_.common_sigma_m, 2) * Eigen::Matrix3d::Identity()};
    }
    std::vector<SizeEstimate> estimates;
    of_estimate.clear();
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (!words[i].sizes) continue;
      estimates.push_back(*words[i].sizes);
      of_estimate.push_back(i);
    }
    if (estimates.empty()) return base::fail(out.cameras.front().survey.error());
    fused = fuse_sizes(estimates, prior, options_.most_sigmas);
    const Eigen::Vector3d before = sizes_of(out.pitch);
    auto next = pitch_of(pitch_, fused.sizes.size_m);
    if (!next) return base::fail(next.error());
    out.pitch = std::move(*next);
    if ((sizes_of(out.pitch) - before).cwiseAbs().maxCoeff() < kSettled) break;
  }
  out.passes = std::min(out.passes, options_.passes);
  out.size_sigma_m = fused.sizes.covariance.diagonal().cwiseSqrt();

  for (std::size_t e = 0; e < of_estimate.size(); ++e) {
    SiteCameraSurvey& camera = out.cameras[of_estimate[e]];
    camera.size_m = words[of_estimate[e]].sizes->size_m;
    camera.size_sigma_m = words[of_estimate[e]].sizes->covariance.diagonal().cwiseSqrt();
    camera.used = fused.used[e];
    camera.off_sigmas = fused.off_sigmas[e];
  }
  const Eigen::Array3d off = (sizes_of(out.pitch) - sizes_of(pitch_)).array().abs();
  const Eigen::Array3d most =
      (options_.most_sigmas * out.size_sigma_m.array()).max(options_.survey.size_tolerance_m);
  if ((stated && off > most).any()) {
    return base::fail(
        base::ErrorKind::kNumerical, "survey",
        fmt::format("the lines of {} cameras fit a pitch of {:.2f} x {:.2f} m with a crown of "
                    "{:.2f} m, not the stated one of {:.2f} x {:.2f} m with {:.2f} m",
                    of_estimate.size(), out.pitch.length_m, out.pitch.width_m, out.pitch.crown_m,
                    pitch_.length_m, pitch_.width_m, pitch_.crown_m),
        "measure the pitch and state its sizes, or state none");
  }
  // The sizes are one draw for all cameras: every mount errs with them.
  closed.stated_covariance_m2 = fused.sizes.covariance;
  for (std::size_t i = 0; i < cameras_.size(); ++i)
    out.cameras[i].survey = run_survey(cameras_[i].maps, out.pitch, cameras_[i].side, closed, true);
  return out;
}

}  // namespace touchline::calibrate
