#include "edge/calibrate/peers/people_registration.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "edge/calibrate/fit/pose_fit.h"
#include "edge/calibrate/peers/figures_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kGate = 3;  // standard deviations
constexpr int kSeedSteps = 12;
constexpr int kFitSteps = 8;
constexpr int kBestKept = 24;
constexpr double kSame = 0.05;       // cameras whose pictures differ by less of their width are one
constexpr double kLogHeights = 1.0;  // range of the logarithm of heights that chance gives

struct Match {
  std::size_t figure = 0;
  std::size_t place = 0;
};

struct Guess {
  geometry::HeadPose pose;
  std::vector<Match> matches;
  double evidence = 0;
};

// Foot and height in the picture of someone at a place.
struct Seen {
  Eigen::Vector2d foot;
  double height = 0;
  double sd = 0;  // of the foot, pixels
};

class Search {
 public:
  Search(const pitch::PitchModel& pitch, const geometry::Mount& mount,
         std::span<const StandingPlace> places, const Figures& figures,
         const std::optional<geometry::CameraEstimate>& prior, const PeopleOptions& options)
      : pitch_(pitch), mount_(mount), places_(places), figures_(figures), options_(options) {
    if (!prior) return;
    prior_ = head_pose(mount, *prior);
    sd_ = {std::sqrt(std::max(prior->covariance(0, 0), 1e-8)),
           std::sqrt(std::max(prior->covariance(1, 1), 1e-8)),
           std::sqrt(std::max(prior->covariance(3, 3), 1e-8))};
  }

  std::optional<Guess> best(std::string& reason) const {
    std::vector<Guess> guesses;
    int seeds = 0;
    for (std::size_t f = 0; f < figures_.standing.size(); ++f) {
      if (!figures_.standing[f].height) continue;
      for (std::size_t p = 0; p < places_.size(); ++p) {
        Guess guess;
        if (!seed(figures_.standing[f], places_[p], guess.pose) || !near_prior(guess.pose))
          continue;
        ++seeds;
        judge(Match{f, p}, guess);
        if (guess.matches.size() >= 2) guesses.push_back(std::move(guess));
      }
    }
    std::stable_sort(guesses.begin(), guesses.end(),
                     [](const Guess& a, const Guess& b) { return a.evidence > b.evidence; });
    if (guesses.size() > kBestKept) guesses.resize(kBestKept);
    for (Guess& guess : guesses) polish(guess);
    std::stable_sort(guesses.begin(), guesses.end(),
                     [](const Guess& a, const Guess& b) { return a.evidence > b.evidence; });
    if (guesses.empty()) {
      reason = fmt::format("{} people seen, {} known of: none agree", figures_.standing.size(),
                           places_.size());
      return std::nullopt;
    }
    const Guess& first = guesses.front();
    const double sure = first.evidence - std::log(std::max(seeds, 1));
    if (first.matches.size() < 3 || sure < options_.least_evidence) {
      reason = fmt::format("{} people agree, which may be chance ({:.1f} of {:.1f})",
                           first.matches.size(), sure, options_.least_evidence);
      return std::nullopt;
    }
    for (const Guess& other : guesses) {
      if (same(first.pose, other.pose)) continue;
      if (other.evidence > first.evidence - options_.least_margin) {
        reason = "people agree with more than one camera";
        return std::nullopt;
      }
    }
    return first;
  }

  // Of pan, tilt, log f, from the matches.
  Eigen::Matrix3d covariance(const Guess& guess) const {
    Eigen::Matrix3d normal;
    Eigen::Vector3d gradient;
    double chi2 = 0;
    int rows = 0;
    normal_equations(guess, normal, gradient, chi2, rows);
    return normal.inverse() * std::max(1.0, chi2 / std::max(rows - 3, 1));
  }

  double rms_px(const Guess& guess) const {
    double sum = 0;
    for (const Match& match : guess.matches) {
      const auto at = seen(guess.pose, places_[match.place]);
      if (at) sum += (at->foot - figures_.standing[match.figure].foot).squaredNorm();
    }
    return std::sqrt(sum / std::max<double>(1, static_cast<double>(guess.matches.size())));
  }

 private:
  geometry::CameraEstimate camera(const geometry::HeadPose& pose) const {
    geometry::CameraEstimate out;
    out.model = geometry::camera_model(mount_, pose.focal_px);
    out.cam_from_world = geometry::cam_from_world(mount_, pose);
    return out;
  }

  double foot_sd() const { return options_.foot_sd_px * mount_.height / 1080.0; }

  std::optional<Seen> seen(const geometry::CameraEstimate& camera,
                           const StandingPlace& place) const {
    const Eigen::Vector3d ground = pitch_.on_turf(place.at);
    const Eigen::Vector3d in_camera = camera.cam_from_world * ground;
    if (in_camera.z() < 1) return std::nullopt;
    const auto foot = camera.model.project(in_camera);
    const auto head = geometry::project(camera, ground + Eigen::Vector3d(0, 0, options_.height_m));
    if (!foot || !head) return std::nullopt;
    return Seen{*foot, (*foot - *head).norm(),
                std::hypot(camera.model.fx * place.sd_m / in_camera.z(), foot_sd())};
  }
  std::optional<Seen> seen(const geometry::HeadPose& pose, const StandingPlace& place) const {
    return seen(camera(pose), place);
  }

  bool possible(double focal) const {
    return focal >= options_.least_focal * mount_.width &&
           focal <= options_.most_focal * mount_.width;
  }

  bool near_prior(const geometry::HeadPose& pose) const {
    if (!prior_) return true;
    const double reach = options_.pan_reach_deg * kRadians;
    return std::abs(std::remainder(pose.pan - prior_->pan, 2 * std::numbers::pi)) <=
               kGate * sd_.x() + reach &&
           std::abs(pose.tilt - prior_->tilt) <= kGate * sd_.y() + reach &&
           std::abs(std::log(pose.focal_px / prior_->focal_px)) <=
               kGate * sd_.z() + options_.log_focal_reach;
  }

  // The head that shows someone at the place as this figure.
  bool seed(const Figure& figure, const StandingPlace& place, geometry::HeadPose& pose) const {
    const Eigen::Vector3d ground = pitch_.on_turf(place.at);
    const Eigen::Vector3d to =
        geometry::world_from_head(mount_).conjugate() * (ground - mount_.position_in_world);
    const double distance = to.norm();
    if (distance < 2) return false;
    pose.pan = std::atan2(to.x(), to.y());
    pose.tilt = std::asin(to.z() / distance);
    pose.roll = 0;
    pose.focal_px = *figure.height * distance / options_.height_m;
    for (int step = 0; step < kSeedSteps; ++step) {
      if (!possible(pose.focal_px)) return false;
      const auto at = seen(pose, place);
      if (!at || at->height < 1) return false;
      const Eigen::Vector2d off = figure.foot - at->foot;
      // To the right in the picture by turning to the left.
      pose.pan -= off.x() / (pose.focal_px * std::max(0.2, std::cos(pose.tilt)));
      pose.tilt += off.y() / pose.focal_px;
      pose.focal_px *= *figure.height / at->height;
      if (!(std::abs(pose.tilt) < 1.5)) return false;
    }
    const auto at = seen(pose, place);
    return at && possible(pose.focal_px) && (at->foot - figure.foot).norm() < foot_sd();
  }

  // Pairs everyone and says how much more likely this is than chance.
  void judge(const std::optional<Match>& given, Guess& guess) const {
    struct Pair {
      Match match;
      double distance = 0;  // squared, in standard deviations
      double gain = 0;
    };
    const geometry::CameraEstimate looking = camera(guess.pose);
    std::vector<Pair> pairs;
    std::vector<std::optional<Seen>> at(places_.size());
    const double area = static_cast<double>(mount_.width) * mount_.height;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      at[p] = seen(looking, places_[p]);
      if (!at[p]) continue;
      for (std::size_t f = 0; f < figures_.standing.size(); ++f) {
        const Figure& figure = figures_.standing[f];
        double distance = (figure.foot - at[p]->foot).squaredNorm() / (at[p]->sd * at[p]->sd);
        double gain = std::log(area / (2 * std::numbers::pi * at[p]->sd * at[p]->sd));
        if (figure.height) {
          const double off = std::log(*figure.height / at[p]->height) / options_.log_height_sd;
          distance += off * off;
          gain +=
              std::log(kLogHeights / (std::sqrt(2 * std::numbers::pi) * options_.log_height_sd));
        }
        if (distance > kGate * kGate + 2) continue;
        gain -= distance / 2 + std::log(static_cast<double>(figures_.standing.size()));
        pairs.push_back({{f, p}, distance, gain});
      }
    }
    std::stable_sort(pairs.begin(), pairs.end(),
                     [](const Pair& a, const Pair& b) { return a.distance < b.distance; });
    std::vector<bool> taken(figures_.standing.size()), placed(places_.size());
    guess.matches.clear();
    guess.evidence = 0;
    const auto take = [&](const Match& match) {
      taken[match.figure] = placed[match.place] = true;
      guess.matches.push_back(match);
    };
    if (given) take(*given);
    double least_gain = 1e300;
    for (const Pair& pair : pairs) {
      if (taken[pair.match.figure] || placed[pair.match.place]) continue;
      take(pair.match);
      guess.evidence += pair.gain;
      least_gain = std::min(least_gain, pair.gain);
    }
    // One of them says where the camera looks, and is no evidence.
    if (!given && guess.matches.size() > 1) guess.evidence -= least_gain;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (placed[p] || !at[p]) continue;
      if (figures_.empty_at(at[p]->foot, at[p]->height))
        guess.evidence += std::log(1 - options_.seen_share);
    }
  }

  void normal_equations(const Guess& guess, Eigen::Matrix3d& normal, Eigen::Vector3d& gradient,
                        double& chi2, int& rows) const {
    normal.setZero();
    gradient.setZero();
    chi2 = 0;
    rows = 0;
    const std::array<double, 3> steps{1e-5, 1e-5, 1e-4};
    const auto moved = [&](int k, double by) {
      geometry::HeadPose pose = guess.pose;
      if (k == 0) pose.pan += by;
      if (k == 1) pose.tilt += by;
      if (k == 2) pose.focal_px *= std::exp(by);
      return camera(pose);
    };
    std::array<geometry::CameraEstimate, 3> beside;
    for (int k = 0; k < 3; ++k)
      beside[static_cast<std::size_t>(k)] = moved(k, steps[static_cast<std::size_t>(k)]);
    const geometry::CameraEstimate looking = camera(guess.pose);
    for (const Match& match : guess.matches) {
      const StandingPlace& place = places_[match.place];
      const Figure& figure = figures_.standing[match.figure];
      const auto at = seen(looking, place);
      if (!at) continue;
      Eigen::Vector3d residual(figure.foot.x() - at->foot.x(), figure.foot.y() - at->foot.y(), 0);
      residual.head<2>() /= at->sd;
      const bool tall = figure.height.has_value();
      if (tall) residual.z() = std::log(*figure.height / at->height) / options_.log_height_sd;
      Eigen::Matrix3d jacobian = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 3; ++k) {
        const auto next = seen(beside[static_cast<std::size_t>(k)], place);
        if (!next) continue;
        const double step = steps[static_cast<std::size_t>(k)];
        jacobian.block<2, 1>(0, k) = (next->foot - at->foot) / (step * at->sd);
        if (tall)
          jacobian(2, k) = std::log(next->height / at->height) / (step * options_.log_height_sd);
      }
      normal += jacobian.transpose() * jacobian;
      gradient += jacobian.transpose() * residual;
      chi2 += residual.squaredNorm();
      rows += tall ? 3 : 2;
    }
    if (prior_) {
      const Eigen::Vector3d off(std::remainder(prior_->pan - guess.pose.pan, 2 * std::numbers::pi),
                                prior_->tilt - guess.pose.tilt,
                                std::log(prior_->focal_px / guess.pose.focal_px));
      const Eigen::Vector3d weight = sd_.cwiseAbs2().cwiseInverse();
      normal += weight.asDiagonal();
      gradient += weight.cwiseProduct(off);
      chi2 += weight.dot(off.cwiseAbs2());
      rows += 3;
    }
  }

  // Least squares over everyone who agrees; who agrees is asked again.
  void polish(Guess& guess) const {
    const Guess before = guess;
    for (int step = 0; step < kFitSteps; ++step) {
      Eigen::Matrix3d normal;
      Eigen::Vector3d gradient;
      double chi2 = 0;
      int rows = 0;
      normal_equations(guess, normal, gradient, chi2, rows);
      const Eigen::Vector3d by = normal.ldlt().solve(gradient);
      if (!by.allFinite()) break;
      guess.pose.pan += by(0);
      guess.pose.tilt += by(1);
      guess.pose.focal_px *= std::exp(std::clamp(by(2), -0.3, 0.3));
      judge(std::nullopt, guess);
      if (guess.matches.size() < 2) break;
    }
    if (guess.matches.size() < 2 || !possible(guess.pose.focal_px) || !near_prior(guess.pose))
      guess = before;
  }

  bool same(const geometry::HeadPose& a, const geometry::HeadPose& b) const {
    const double wide = kSame * mount_.width;
    return std::abs(std::remainder(a.pan - b.pan, 2 * std::numbers::pi)) * a.focal_px < wide &&
           std::abs(a.tilt - b.tilt) * a.focal_px < wide &&
           std::abs(std::log(a.focal_px / b.focal_px)) < 2 * kSame;
  }

  const pitch::PitchModel& pitch_;
  const geometry::Mount& mount_;
  std::span<const StandingPlace> places_;
  const Figures& figures_;
  const PeopleOptions& options_;
  std::optional<geometry::HeadPose> prior_;
  Eigen::Vector3d sd_ = Eigen::Vector3d::Zero();
};

}  // namespace

base::Status PeopleOptions::validate() const {
  if (base::Status status = turf.validate(); !status) return status;
  for (const base::Status& status : {base::in_bounds("height_m", height_m, 1.2, 2.2),
                                     base::in_bounds("log_height_sd", log_height_sd, 0.02, 0.5),
                                     base::in_bounds("foot_sd_px", foot_sd_px, 0.5, 50),
                                     base::in_bounds("least_focal", least_focal, 0.1, 20),
                                     base::in_bounds("most_focal", most_focal, least_focal, 100),
                                     base::in_bounds("seen_share", seen_share, 0.1, 0.99),
                                     base::in_bounds("least_evidence", least_evidence, 1, 100),
                                     base::in_bounds("least_margin", least_margin, 1, 100),
                                     base::in_bounds("pan_reach_deg", pan_reach_deg, 0, 180),
                                     base::in_bounds("log_focal_reach", log_focal_reach, 0, 5)}) {
    if (!status) return status;
  }
  return {};
}

state::TrackResult register_people(const image::Frame& frame, const pitch::PitchModel& pitch,
                                   const geometry::Mount& mount,
                                   std::span<const StandingPlace> places,
                                   const std::optional<geometry::CameraEstimate>& prior,
                                   const PeopleOptions& options) {
  state::TrackResult out;
  out.estimate.model.width = mount.width;
  out.estimate.model.height = mount.height;
  if (frame.width() != mount.width || frame.height() != mount.height) {
    out.report.stopped_because = fmt::format("frame of {}x{}, mount for {}x{}", frame.width(),
                                             frame.height(), mount.width, mount.height);
    return out;
  }
  if (places.size() < 3) {
    out.report.stopped_because = fmt::format("{} people known of", places.size());
    return out;
  }
  const Figures figures = find_figures(frame, options.turf);
  if (figures.standing.size() < 3) {
    out.report.stopped_because =
        fmt::format("{} people stand in the picture", figures.standing.size());
    return out;
  }
  const Search search(pitch, mount, places, figures, prior, options);
  const auto found = search.best(out.report.stopped_because);
  if (!found) return out;
  out.estimate.model = geometry::camera_model(mount, found->pose.focal_px);
  out.estimate.cam_from_world = geometry::cam_from_world(mount, found->pose);
  const Eigen::Matrix3d spread = search.covariance(*found);
  constexpr std::array<int, 3> kPlace{0, 1, 3};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      out.estimate.covariance(kPlace[i], kPlace[k]) =
          spread(static_cast<int>(i), static_cast<int>(k));
  }
  out.estimate.covariance.block<3, 3>(6, 6) = mount.covariance.topLeftCorner<3, 3>();
  out.estimate.evidence = geometry::Evidence::kPeers;
  out.estimate.rms_px = out.report.rms_px = search.rms_px(*found);
  out.report.points = static_cast<int>(found->matches.size());
  out.report.stopped_because = "converged: people";
  return out;
}

}  // namespace touchline::calibrate
