#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "edge/calibrate/texture/patch_match_internal.h"
#include "edge/calibrate/texture/texture_track_internal.h"

namespace touchline::calibrate {
namespace {

constexpr int kTop = LumaPyramid::kLevels - 1;
constexpr int kColumns = 20;  // cells of the picture with one patch each
constexpr int kRows = 12;
constexpr std::size_t kCells = static_cast<std::size_t>(kColumns) * kRows;
constexpr std::size_t kVoters = 64;  // patches that are correlated over the whole reach
constexpr int kLeastReach = 6;       // pixels of the top level
constexpr int kMostReach = 28;
constexpr int kNearVote = 2;        // pixels of the top level round the common shift
constexpr double kVoteFloor = 0.3;  // correlation that counts for a shift
constexpr double kReachSigmas = 3;
constexpr double kEps = 1e-4;          // radians, for a difference
constexpr double kCoarseSd = 0.5;      // pixels of the top level, of the common shift
constexpr double kEnoughTexture = 20;  // code values a pixel
constexpr double kAgrees = 0.25;       // weight of a patch that does
constexpr double kNoCutoff = 1e6;
constexpr int kStartIterations = 4;

struct Candidate {
  std::size_t view = 0;
  std::size_t index = 0;
  const KeyPoint* point = nullptr;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // predicted
  double merit = 0;
};

// How pixel differences of the picture map to those of the view, round a point.
std::optional<Eigen::Matrix2d> key_from_picture(const KeyView& view, const PoseModel& model,
                                                const KeyPoint& point,
                                                const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = point.point_in_world - geometry::position_in_world(view.camera);
  const Eigen::Vector3d across = ray.norm() * ray.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d up = across.cross(ray.normalized());
  const geometry::CameraModel picture = model.camera_model();
  const geometry::Rigid3 cam_from_world = model.cam_from_world();
  Eigen::Matrix2d key, seen;
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector3d p = point.point_in_world + kEps * (i == 0 ? across : up);
    const auto a = geometry::project(view.camera, p);
    const auto b = picture.project(cam_from_world * p);
    if (!a || !b) return std::nullopt;
    key.col(i) = *a - point.pixel;
    seen.col(i) = *b - pixel;
  }
  if (!(std::abs(seen.determinant()) > 1e-12)) return std::nullopt;
  return Eigen::Matrix2d(key * seen.inverse());
}

// Every view's best point in every cell of the picture: much texture, and found where it was
// looked for.
std::vector<Candidate> choose(const std::vector<KeyView*>& views, const PoseModel& model,
                              const TextureTrackOptions& options) {
  const geometry::CameraModel camera = model.camera_model();
  std::vector<Candidate> out;
  for (std::size_t v = 0; v < views.size(); ++v) {
    std::array<Candidate, kCells> cells;
    for (std::size_t i = 0; i < views[v]->points.size(); ++i) {
      const KeyPoint& point = views[v]->points[i];
      const auto image = model.project(point.point_in_world);
      if (!image || !camera.sees(image->pixel)) continue;
      const double trust = (point.found + 1.0) / (point.looked + 1.0);
      const double merit = std::min<double>(point.texture, kEnoughTexture) * trust * trust;
      const int column = std::clamp(
          static_cast<int>((image->pixel.x() + 0.5) / camera.width * kColumns), 0, kColumns - 1);
      const int row = std::clamp(static_cast<int>((image->pixel.y() + 0.5) / camera.height * kRows),
                                 0, kRows - 1);
      Candidate& cell = cells[static_cast<std::size_t>(row * kColumns + column)];
      if (cell.point == nullptr || merit > cell.merit) cell = {v, i, &point, image->pixel, merit};
    }
    for (const Candidate& cell : cells)
      if (cell.point != nullptr) out.push_back(cell);
  }
  if (out.size() > static_cast<std::size_t>(options.most_points)) {
    std::stable_sort(out.begin(), out.end(),
                     [](const Candidate& a, const Candidate& b) { return a.merit > b.merit; });
    out.resize(static_cast<std::size_t>(options.most_points));
  }
  return out;
}

struct Shift {
  double dx = 0;  // pixels of the top level
  double dy = 0;
  double zoom = 0;  // relative
};

// The shift and zoom that most patches agree on.
Shift vote(const std::vector<Correlation>& maps, const std::vector<Eigen::Vector2d>& places,
           const Eigen::Vector2d& middle, int reach, double zoom_sd) {
  const double corner = middle.norm();
  const double step = 1.0 / corner;  // a pixel at the corner
  const int zooms = std::min(6, static_cast<int>(std::ceil(kReachSigmas * zoom_sd / step)));
  const int side = 2 * reach + 1;
  std::vector<float> sums(static_cast<std::size_t>(side * side));
  Shift best;
  float most = -1;
  for (int k = 0; k <= 2 * zooms; ++k) {
    const double zoom = step * (k % 2 == 0 ? k / 2 : -(k + 1) / 2);  // the prior's own first
    std::fill(sums.begin(), sums.end(), 0.0F);
    for (std::size_t i = 0; i < maps.size(); ++i) {
      const Eigen::Vector2d off = zoom * (places[i] - middle);
      const int ox = static_cast<int>(std::lround(off.x()));
      const int oy = static_cast<int>(std::lround(off.y()));
      for (int dy = -reach; dy <= reach; ++dy)
        for (int dx = -reach; dx <= reach; ++dx) {
          const float c = maps[i].at(dx + ox, dy + oy);
          sums[static_cast<std::size_t>((dy + reach) * side + dx + reach)] +=
              std::max(0.0F, c - static_cast<float>(kVoteFloor));
        }
    }
    const auto top = std::max_element(sums.begin(), sums.end());
    if (!(*top > most)) continue;
    most = *top;
    const int at = static_cast<int>(top - sums.begin());
    best = {static_cast<double>(at % side - reach), static_cast<double>(at / side - reach), zoom};
  }
  return best;
}

class Tracker {
 public:
  Tracker(const LumaPyramid& picture, const std::vector<KeyView*>& views,
          const geometry::Mount& mount, const PoseVector& prior_pose, const Eigen::Matrix4d& prior,
          const TextureTrackOptions& options)
      : picture_(picture),
        views_(views),
        mount_(mount),
        prior_pose_(prior_pose),
        prior_(prior),
        options_(options) {}

  TextureTrack run(double reach_px) {
    out_.fit.pose = prior_pose_;
    out_.share_of_view.assign(views_.size(), 0.0);
    const PoseModel model(mount_, prior_pose_);
    candidates_ = choose(views_, model, options_);
    out_.looked = static_cast<int>(candidates_.size());
    found_.resize(candidates_.size());
    known_.assign(candidates_.size(), 0);
    if (candidates_.size() < 4) return stop("too little texture");
    coarse(model, reach_px);
    if (!solve()) return stop("no common motion");
    for (int l = kTop - 1; l >= 0; --l) {
      finer(l);
      if (!solve()) return stop("no common motion");
    }
    judge();
    return std::move(out_);
  }

 private:
  TextureTrack stop(const char* why) {
    out_.fit.solved = false;
    out_.stopped_because = why;
    return std::move(out_);
  }

  void coarse(const PoseModel& model, double reach_px) {
    const image::Image<std::uint16_t>& top = picture_.level[kTop];
    const int scale = picture_.scale(kTop);
    const Eigen::Matrix4d spread = prior_.inverse();
    const double focal = std::exp(prior_pose_(3));
    const double sd = focal * std::sqrt(std::max(spread(0, 0), spread(1, 1)));
    const double asked = reach_px > 0 ? reach_px : kReachSigmas * sd;
    const int reach =
        std::clamp(static_cast<int>(std::ceil(asked / scale)) + 1, kLeastReach, kMostReach);
    std::vector<std::optional<Patch>> patches(candidates_.size());
    std::vector<Correlation> maps;
    std::vector<Eigen::Vector2d> places;
    const std::size_t stride = (candidates_.size() + kVoters - 1) / kVoters;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const Candidate& c = candidates_[i];
      const auto map = key_from_picture(*views_[c.view], model, *c.point, c.pixel);
      if (map) patches[i] = draw_patch(views_[c.view]->pyramid, c.point->pixel, *map, scale);
      if (!patches[i] || i % stride != 0) continue;
      places.push_back(picture_.at_level(c.pixel, kTop));
      maps.push_back(correlate(*patches[i], top, places.back(), reach));
    }
    if (maps.empty()) return;
    const Eigen::Vector2d middle((top.width() - 1) / 2.0, (top.height() - 1) / 2.0);
    const Shift shift = vote(maps, places, middle, reach, std::sqrt(std::max(0.0, spread(3, 3))));
    std::vector<TexturePoint> voted;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (!patches[i]) continue;
      const Eigen::Vector2d place = picture_.at_level(candidates_[i].pixel, kTop);
      const Eigen::Vector2d moved =
          place + Eigen::Vector2d(shift.dx, shift.dy) + shift.zoom * (place - middle);
      voted.emplace_back();
      voted.back().point_in_world = candidates_[i].point->point_in_world;
      voted.back().pixel = picture_.in_picture(moved, kTop);
      voted.back().covariance = kCoarseSd * kCoarseSd * scale * scale * Eigen::Matrix2d::Identity();
      const Correlation near = correlate(*patches[i], top, moved, kNearVote);
      int bx = 0, by = 0;
      float best = -1;
      for (int dy = -kNearVote; dy <= kNearVote; ++dy)
        for (int dx = -kNearVote; dx <= kNearVote; ++dx)
          if (near.at(dx, dy) > best) {
            best = near.at(dx, dy);
            bx = dx;
            by = dy;
          }
      if (best < 0.5F * static_cast<float>(options_.least_correlation)) continue;
      take(i, *patches[i], kTop, Eigen::Vector2d(near.x + bx, near.y + by));
    }
    const TextureFit start = fit_texture(voted, mount_, prior_pose_, prior_, prior_pose_,
                                         {kNoCutoff, 1, kStartIterations});
    if (start.solved) out_.fit.pose = start.pose;
  }

  // The places found at a coarser level looked at again.
  void finer(int l) {
    const PoseModel model(mount_, out_.fit.pose);
    const geometry::CameraModel camera = model.camera_model();
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const Candidate& c = candidates_[i];
      const auto image = model.project(c.point->point_in_world);
      if (!image || !camera.sees(image->pixel)) continue;
      const auto map = key_from_picture(*views_[c.view], model, *c.point, image->pixel);
      if (!map) continue;
      const auto patch =
          draw_patch(views_[c.view]->pyramid, c.point->pixel, *map, picture_.scale(l));
      if (patch) take(i, *patch, l, picture_.at_level(image->pixel, l));
    }
  }

  // Keeps what a level says of a patch, unless a coarser one said it more surely.
  void take(std::size_t i, const Patch& patch, int l, const Eigen::Vector2d& place) {
    const auto match =
        refine(patch, picture_.level[static_cast<std::size_t>(l)], place, kNearVote + 1.0);
    if (!match || match->correlation < options_.least_correlation) return;
    const double scale = picture_.scale(l);
    TexturePoint point;
    point.point_in_world = candidates_[i].point->point_in_world;
    point.pixel = picture_.in_picture(match->position, l);
    const double floor = std::max(options_.point_floor_px, 0.05 * scale);
    point.covariance =
        scale * scale * match->covariance + floor * floor * Eigen::Matrix2d::Identity();
    if (known_[i] && found_[i].covariance.trace() < point.covariance.trace()) return;
    found_[i] = point;
    known_[i] = 1;
  }

  bool solve() {
    points_.clear();
    for (std::size_t i = 0; i < found_.size(); ++i)
      if (known_[i]) points_.push_back(found_[i]);
    if (points_.size() < 4) return false;
    out_.fit = fit_texture(points_, mount_, prior_pose_, prior_, out_.fit.pose, {});
    return out_.fit.solved;
  }

  void judge() {
    double sum = 0, all = 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < found_.size(); ++i) {
      if (!known_[i]) continue;
      const TexturePoint& point = points_[k++];
      const bool agrees = point.weight > kAgrees && point.residual_px < options_.inlier_px;
      out_.points.push_back({candidates_[i].view, candidates_[i].index, agrees});
      const double information = point.weight / point.covariance.trace();
      out_.share_of_view[candidates_[i].view] += information;
      all += information;
      if (!agrees) continue;
      ++out_.supporting;
      sum += point.residual_px * point.residual_px;
    }
    out_.found = static_cast<int>(points_.size());
    out_.rms_px = out_.supporting > 0 ? std::sqrt(sum / out_.supporting) : 0;
    for (double& share : out_.share_of_view) share /= std::max(all, 1e-12);
  }

  const LumaPyramid& picture_;
  const std::vector<KeyView*>& views_;
  const geometry::Mount& mount_;
  const PoseVector& prior_pose_;
  const Eigen::Matrix4d& prior_;
  const TextureTrackOptions& options_;
  std::vector<Candidate> candidates_;
  std::vector<TexturePoint> found_;
  std::vector<char> known_;
  std::vector<TexturePoint> points_;
  TextureTrack out_;
};

}  // namespace

TextureTrack track_texture(const LumaPyramid& picture, const std::vector<KeyView*>& views,
                           const geometry::Mount& mount, const PoseVector& prior_pose,
                           const Eigen::Matrix4d& prior, double reach_px,
                           const TextureTrackOptions& options) {
  return Tracker(picture, views, mount, prior_pose, prior, options).run(reach_px);
}

}  // namespace touchline::calibrate
