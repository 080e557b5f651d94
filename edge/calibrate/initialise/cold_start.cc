#include "edge/calibrate/initialise/cold_start.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "edge/calibrate/initialise/cold_arcs_internal.h"
#include "edge/calibrate/initialise/cold_circle_internal.h"
#include "edge/calibrate/initialise/pitch_pencil_internal.h"
#include "edge/calibrate/initialise/pose_score_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFurthestVanishingPoint = 60;  // in picture widths
constexpr double kConvincing = 0.85;            // score that ends the search
constexpr std::size_t kArcLines = 3;            // that are tried for the line beside an arc
constexpr int kCentreLines = 6;                 // that are tried for the halfway line
constexpr double kCentreSlope = 0.02;           // sine between a touchline and its hypothesis
constexpr std::size_t kCirclePoints = 240;      // that the circle is looked for in
constexpr double kLongLine = 0.4;               // of the picture's width
constexpr double kOnLinePx = 6;          // points this near to a line are on it, at 1080 lines
constexpr std::size_t kScored = 300;     // proposals that are looked at closer
constexpr double kCellPlace = 2.5;       // metres: places that differ by less are one
constexpr double kCellLog = 0.08;        // the same, of log height and log focal length
constexpr double kCellTurn = 0.02;       // the same, of the optical axis
constexpr double kLeastArcShare = 0.15;  // of the points off the line, on an arc
constexpr std::size_t kArcPoints = 150;  // that arcs are looked for in

using PlaceKey = std::array<int, 6>;

struct Proposal {
  Pose pose;
  double score = 0;
};

// A picture line in coordinates from the picture's middle.
struct CentredLine {
  Eigen::Vector3d line;  // a x + b y + c = 0, (a, b) unit
  Eigen::Vector2d start, end;
};

class Search {
 public:
  Search(const LineMap& map, const pitch::PitchModel& pitch, Side side,
         const ColdStartOptions& options)
      : map_(map),
        pitch_(pitch),
        side_(side),
        options_(options),
        coarse_(sample_markings(pitch, 2.0)),
        fine_(sample_markings(pitch, 0.5)),
        scale_(std::max(map.height / 1080.0, 0.4)) {
    for (int axis = 0; axis < 2; ++axis)
      pencils_[static_cast<std::size_t>(axis)] = pencil(pitch, axis);
    if (options.arcs) arcs_ = arcs_beside_lines(pitch);
    centre_ = {0.5 * (map.width - 1), 0.5 * (map.height - 1)};
    const std::size_t count = std::min(map.lines.size(), static_cast<std::size_t>(options.lines));
    for (std::size_t i = 0; i < count; ++i) {
      const LineHypothesis& line = map.lines[i];
      lines_.push_back({Eigen::Vector3d(line.normal.x(), line.normal.y(),
                                        line.normal.dot(centre_) - line.offset),
                        line.start - centre_, line.end - centre_});
    }
  }

  std::vector<ColdHypothesis> run() {
    for (std::size_t i = 0; i < lines_.size(); ++i)
      for (std::size_t j = i + 1; j < lines_.size(); ++j)
        for (std::size_t k = 0; k < lines_.size(); ++k)
          if (k != i && k != j) try_lines(lines_[i], lines_[j], lines_[k]);
    std::vector<ColdHypothesis> found = finish();
    if (!found.empty() && found.front().score >= kConvincing) return found;
    // The middle of the pitch shows a touchline, the halfway line and the circle: too few lines,
    // but the circle tells the scale.
    places_.clear();
    const std::size_t count = std::min<std::size_t>(lines_.size(), kCentreLines);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j)
        if (i != j) try_centre(lines_[i], lines_[j]);
    for (ColdHypothesis& hypothesis : finish()) found.push_back(std::move(hypothesis));
    // Or no more than the halfway line and the circle.
    places_.clear();
    for (std::size_t i = 0; i < count; ++i) try_circle(lines_[i]);
    if (options_.arcs) {
      for (std::size_t i = 0; i < std::min<std::size_t>(count, kArcLines); ++i) try_arcs(lines_[i]);
    }
    for (ColdHypothesis& hypothesis : finish()) found.push_back(std::move(hypothesis));
    std::stable_sort(
        found.begin(), found.end(),
        [](const ColdHypothesis& a, const ColdHypothesis& b) { return a.score > b.score; });
    if (found.size() > static_cast<std::size_t>(options_.kept))
      found.resize(static_cast<std::size_t>(options_.kept));
    return found;
  }

 private:
  // i and j taken for parallel, k for a line across them.
  void try_lines(const CentredLine& i, const CentredLine& j, const CentredLine& k) {
    const Eigen::Vector3d v = i.line.cross(j.line);
    if (std::abs(v.z()) < 1e-9) return;
    const Eigen::Vector2d vanishing = v.head<2>() / v.z();
    if (vanishing.norm() > kFurthestVanishingPoint * map_.width) return;
    if (between(i, vanishing) || between(j, vanishing)) return;
    const double horizon = vanishing.y();
    if (std::abs(k.line.x()) < 1e-6) return;
    const double across = -(k.line.y() * horizon + k.line.z()) / k.line.x();
    if (between(k, {across, horizon})) return;
    const double squared = -(vanishing.x() * across + horizon * horizon);
    if (squared <= 0) return;
    const double focal = std::sqrt(squared);
    if (focal < options_.least_focal * map_.width || focal > options_.most_focal * map_.width)
      return;
    const Eigen::Vector3d up = Eigen::Vector3d(0, -focal, horizon).normalized();
    const Eigen::Vector3d along = Eigen::Vector3d(vanishing.x(), horizon, focal).normalized();
    for (const double sign : {1.0, -1.0}) {
      for (int axis = 0; axis < 2; ++axis) {
        Eigen::Matrix3d rotation;
        if (axis == 0) {
          rotation.col(0) = sign * along;
          rotation.col(1) = up.cross(rotation.col(0));
        } else {
          rotation.col(1) = sign * along;
          rotation.col(0) = rotation.col(1).cross(up);
        }
        rotation.col(2) = up;
        if (faces_pitch(rotation)) try_rotation(i, j, k, axis, focal, rotation);
      }
    }
  }

  // `halfway` taken for the halfway line and `touch` for a touchline, over all horizons, focal
  // lengths and heights.
  void try_centre(const CentredLine& halfway, const CentredLine& touch) {
    if (std::abs(halfway.line.x()) < 1e-6) return;
    const Eigen::Vector2d middle = 0.5 * (touch.start + touch.end);
    const Eigen::Vector2d along = (touch.end - touch.start).normalized();
    const double width = map_.width;
    for (double focal = options_.least_focal * width; focal < options_.most_focal * width;
         focal *= 1.08) {
      for (double tilt = -4 * kPi / 180; tilt > -40 * kPi / 180; tilt *= 1.06) {
        const double horizon = focal * std::tan(tilt);
        const double across = -(halfway.line.y() * horizon + halfway.line.z()) / halfway.line.x();
        if (between(halfway, {across, horizon})) continue;
        const Eigen::Vector3d up = Eigen::Vector3d(0, -focal, horizon).normalized();
        for (const double sign : {1.0, -1.0}) {
          Eigen::Matrix3d rotation;
          rotation.col(1) = sign * Eigen::Vector3d(across, horizon, focal).normalized();
          rotation.col(0) = rotation.col(1).cross(up);
          rotation.col(2) = up;
          if (!faces_pitch(rotation)) continue;
          // Direction in the picture of a line along X through the middle of `touch`.
          const Eigen::Vector3d& x = rotation.col(0);
          Eigen::Vector2d seen(x.x() * focal - middle.x() * x.z(),
                               x.y() * focal - middle.y() * x.z());
          seen.normalize();
          if (std::abs(seen.x() * along.y() - seen.y() * along.x()) > kCentreSlope) continue;
          try_heights(halfway, touch, focal, rotation);
        }
      }
    }
  }

  void try_circle(const CentredLine& halfway) {
    const auto circle = std::find_if(pitch_.markings.begin(), pitch_.markings.end(),
                                     [](const pitch::Marking& marking) {
                                       return marking.id == pitch::MarkingId::kCentreCircle;
                                     });
    if (circle == pitch_.markings.end()) return;
    // Points on long lines are not on the circle, whose flat parts are short.
    const auto on_line = [&](const Eigen::Vector2d& p) {
      return std::any_of(lines_.begin(), lines_.end(), [&](const CentredLine& line) {
        return (line.end - line.start).norm() > kLongLine * map_.width &&
               std::abs(line.line.head<2>().dot(p) + line.line.z()) < kOnLinePx * scale_ &&
               between(line, p);
      });
    };
    std::vector<Eigen::Vector2d> all;
    for (const RidgePoint& point : map_.points) {
      const Eigen::Vector2d p = point.position.cast<double>() - centre_;
      if (!on_line(p)) all.push_back(p);
    }
    std::vector<Eigen::Vector2d> points;
    const std::size_t stride = 1 + all.size() / kCirclePoints;
    for (std::size_t i = 0; i < all.size(); i += stride) points.push_back(all[i]);
    CircleSearch search;
    search.least_focal = options_.least_focal * map_.width;
    search.most_focal = options_.most_focal * map_.width;
    search.radius_m = circle->radius;
    search.tolerance_px = 5 * scale_;
    for (const CircleProposal& proposal : circle_proposals(halfway.line, points, search))
      propose_seen(proposal, Eigen::Vector3d::Zero());
  }

  // `beside` taken for a line across the pitch beside the centre of an arc, from any height.
  void try_arcs(const CentredLine& beside) {
    std::vector<Eigen::Vector2d> points;
    const std::size_t stride = 1 + map_.points.size() / kArcPoints;
    for (std::size_t i = 0; i < map_.points.size(); i += stride)
      points.push_back(map_.points[i].position.cast<double>() - centre_);
    for (const ArcBeside& arc : arcs_) {
      CircleSearch search;
      search.least_focal = options_.least_focal * map_.width;
      search.most_focal = options_.most_focal * map_.width;
      search.radius_m = arc.radius;
      search.tolerance_px = 5 * scale_;
      search.offset = arc.offset;
      search.least_sectors = 2;
      search.least_share = kLeastArcShare;
      search.any_horizon = true;
      for (const CircleProposal& proposal : circle_proposals(beside.line, points, search))
        for (const Eigen::Vector3d& centre : proposal.turned ? arc.turned : arc.centres)
          propose_seen(proposal, centre);
    }
  }

  void propose_seen(const CircleProposal& proposal, const Eigen::Vector3d& centre) {
    const Eigen::Vector3d position = proposal.position + centre;
    if (faces_pitch(proposal.rotation) && plausible(position, side_, pitch_, options_.bounds))
      propose(proposal.focal, proposal.rotation, position);
  }

  void try_heights(const CentredLine& halfway, const CentredLine& touch, double focal,
                   const Eigen::Matrix3d& rotation) {
    Eigen::Matrix3d planes;
    const auto plane = [&](const Eigen::Vector3d& line) -> Eigen::Vector3d {
      return (rotation.transpose() * Eigen::Vector3d(line.x(), line.y(), line.z() / focal))
          .normalized();
    };
    planes.row(0) = plane(halfway.line);
    planes.row(1) = plane(touch.line);
    planes.row(2) = Eigen::RowVector3d(0, 0, 1);
    if (std::abs(planes.determinant()) < 1e-4) return;
    const Eigen::Matrix3d inverse = planes.inverse();
    const PencilLine middle{
        0, -pitch_.crown_m / 3, {{-0.5 * pitch_.width_m, 0.5 * pitch_.width_m}}};
    for (const double at : {-0.5 * pitch_.width_m, 0.5 * pitch_.width_m}) {
      const PencilLine line{at, -pitch_.crown_m, {{-0.5 * pitch_.length_m, 0.5 * pitch_.length_m}}};
      for (double height = 3; height < 45; height *= 1.07) {
        const Eigen::Vector3d position =
            inverse * Eigen::Vector3d(planes(0, 2) * middle.z,
                                      planes(1, 1) * line.at + planes(1, 2) * line.z, height);
        if (!plausible(position, side_, pitch_, options_.bounds)) continue;
        if (!lies_on(halfway, middle, 1, focal, rotation, position) ||
            !lies_on(touch, line, 0, focal, rotation, position))
          continue;
        propose(focal, rotation, position);
      }
    }
  }

  // The optical axis points away from the camera's own side.
  bool faces_pitch(const Eigen::Matrix3d& rotation) const {
    const Eigen::Vector3d forward = rotation.row(2);
    const double least = -0.3;  // a camera at a corner may look a little backwards
    switch (side_) {
      case Side::kMain:
        return forward.y() > least;
      case Side::kReverse:
        return forward.y() < -least;
      case Side::kLeft:
        return forward.x() > least;
      case Side::kRight:
        break;
    }
    return forward.x() < -least;
  }

  void try_rotation(const CentredLine& i, const CentredLine& j, const CentredLine& k, int axis,
                    double focal, const Eigen::Matrix3d& rotation) {
    const std::array<const CentredLine*, 3> picture{&i, &j, &k};
    Eigen::Matrix3d planes;
    for (int r = 0; r < 3; ++r) {
      const Eigen::Vector3d& line = picture[static_cast<std::size_t>(r)]->line;
      planes.row(r) = (rotation.transpose() * Eigen::Vector3d(line.x(), line.y(), line.z() / focal))
                          .normalized();
    }
    const Eigen::FullPivLU<Eigen::Matrix3d> lu(planes);
    if (!lu.isInvertible() || lu.rcond() < 1e-5) return;
    const Eigen::Matrix3d inverse = planes.inverse();
    const auto& parallel = pencils_[static_cast<std::size_t>(axis)];
    const auto& others = pencils_[static_cast<std::size_t>(1 - axis)];
    const auto offset = [&](int row, const PencilLine& line, int line_axis) {
      return planes(row, 1 - line_axis) * line.at + planes(row, 2) * line.z;
    };
    for (const PencilLine& a : parallel) {
      for (const PencilLine& b : parallel) {
        if (&a == &b) continue;
        for (const PencilLine& c : others) {
          const Eigen::Vector3d position =
              inverse *
              Eigen::Vector3d(offset(0, a, axis), offset(1, b, axis), offset(2, c, 1 - axis));
          if (!plausible(position, side_, pitch_, options_.bounds)) continue;
          if (!lies_on(i, a, axis, focal, rotation, position) ||
              !lies_on(j, b, axis, focal, rotation, position) ||
              !lies_on(k, c, 1 - axis, focal, rotation, position))
            continue;
          propose(focal, rotation, position);
        }
      }
    }
  }

  // The middle of the picture line, cast on the turf, lies where the pitch line is painted.
  bool lies_on(const CentredLine& line, const PencilLine& on, int axis, double focal,
               const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position) const {
    for (const double t : {0.25, 0.75}) {
      const Eigen::Vector2d p = (1 - t) * line.start + t * line.end;
      const Eigen::Vector3d ray = rotation.transpose() * Eigen::Vector3d(p.x(), p.y(), focal);
      if (ray.z() >= -1e-6) return false;
      const double along = position[axis] + ray[axis] * (on.z - position.z()) / ray.z();
      if (!on.covers(along, 4.0)) return false;
    }
    return true;
  }

  void propose(double focal, const Eigen::Matrix3d& rotation, const Eigen::Vector3d& position) {
    Proposal proposal;
    proposal.pose.model = {map_.width, map_.height, focal, focal, centre_.x(), centre_.y(), 0, 0};
    proposal.pose.rotation = rotation;
    proposal.pose.position = position;
    const PoseScore score = score_fast(map_, coarse_, proposal.pose, 16 * scale_);
    proposal.score = score.score();
    if (proposal.score < 0.15) return;
    const auto cell = [](double value, double size) {
      return static_cast<int>(std::lround(value / size));
    };
    const PlaceKey key{cell(position.x(), kCellPlace),         cell(position.y(), kCellPlace),
                       cell(std::log(position.z()), kCellLog), cell(std::log(focal), kCellLog),
                       cell(rotation(2, 0), kCellTurn),        cell(rotation(2, 1), kCellTurn)};
    Proposal& best = places_[key];
    if (proposal.score > best.score) best = proposal;
  }

  static bool between(const CentredLine& line, const Eigen::Vector2d& p) {
    const Eigen::Vector2d d = line.end - line.start;
    const double t = (p - line.start).dot(d) / d.squaredNorm();
    return t > 0.02 && t < 0.98;
  }

  static bool same(const Pose& a, const Pose& b) {
    return (a.position - b.position).norm() < 1.0 &&
           std::abs(std::log(a.model.fx / b.model.fx)) < 0.03 && picture_distance(a, b) < 40;
  }

  // The proposals that are refined to the end: a short refinement puts them in order, and those
  // whose lines are of the wrong width are left out.
  std::vector<Proposal> choose(const RefineOptions& refine_options) const {
    std::vector<Proposal> proposals;
    for (const auto& [key, proposal] : places_) proposals.push_back(proposal);
    const auto better = [](const Proposal& a, const Proposal& b) { return a.score > b.score; };
    std::stable_sort(proposals.begin(), proposals.end(), better);
    if (proposals.size() > kScored) proposals.resize(kScored);
    RefineOptions first = refine_options;
    first.tolerances_px = refine_options.tolerances_px.first(4);
    std::vector<Proposal> refined;
    for (Proposal& proposal : proposals) {
      if (!refine(map_, coarse_, first, proposal.pose)) continue;
      if (!plausible(proposal.pose.position, side_, pitch_, options_.bounds)) continue;
      if (!widths_agree(map_, coarse_, proposal.pose, 12 * scale_)) continue;
      proposal.score = score_fast(map_, coarse_, proposal.pose, 12 * scale_).score();
      refined.push_back(proposal);
    }
    std::stable_sort(refined.begin(), refined.end(), better);
    std::vector<Proposal> chosen;
    for (const Proposal& proposal : refined) {
      if (static_cast<int>(chosen.size()) >= options_.refined) break;
      if (std::none_of(chosen.begin(), chosen.end(),
                       [&](const Proposal& other) { return same(other.pose, proposal.pose); }))
        chosen.push_back(proposal);
    }
    return chosen;
  }

  std::vector<ColdHypothesis> finish() {
    std::vector<ColdHypothesis> found;
    std::vector<Pose> poses;
    const std::array<double, 12> tolerances{24, 24, 20, 16, 14, 12, 10, 8, 6, 5, 4, 4};
    std::array<double, 12> scaled{};
    for (std::size_t i = 0; i < scaled.size(); ++i) scaled[i] = tolerances[i] * scale_;
    RefineOptions refine_options;
    refine_options.position = true;
    refine_options.lens = options_.refine_lens;
    refine_options.shift_sigma = 0.02;
    refine_options.roll_sigma = 0.5 * options_.most_roll_deg * kPi / 180;
    refine_options.tolerances_px = scaled;
    const std::vector<Proposal> chosen = choose(refine_options);
    struct Candidate {
      Pose pose;
      PoseScore score;
    };
    std::vector<Candidate> candidates;
    for (const Proposal& proposal : chosen) {
      Pose pose = proposal.pose;
      if (!refine(map_, coarse_, refine_options, pose)) continue;
      if (!plausible(pose.position, side_, pitch_, options_.bounds)) continue;
      if (pose.model.fx < options_.least_focal * map_.width ||
          pose.model.fx > options_.most_focal * map_.width)
        continue;
      const double roll = geometry::pan_tilt_roll(Eigen::Quaterniond(pose.rotation)).z();
      if (std::abs(roll) > options_.most_roll_deg * kPi / 180) continue;
      if (!widths_agree(map_, coarse_, pose, 5 * scale_)) continue;
      candidates.push_back({pose, score_exact(map_, fine_, pitch_, pose, 5 * scale_, 1200)});
    }
    std::stable_sort(
        candidates.begin(), candidates.end(),
        [](const Candidate& a, const Candidate& b) { return a.score.score() > b.score.score(); });
    for (const Candidate& candidate : candidates) {
      if (static_cast<int>(found.size()) >= options_.kept) break;
      if (candidate.score.confirmed < options_.least_confirmed ||
          candidate.score.explained < options_.least_explained || candidate.score.directions < 2)
        continue;
      if (std::any_of(poses.begin(), poses.end(),
                      [&](const Pose& other) { return same(other, candidate.pose); }))
        continue;
      poses.push_back(candidate.pose);
      ColdHypothesis hypothesis;
      hypothesis.model = candidate.pose.model;
      const Eigen::Quaterniond rotation = Eigen::Quaterniond(candidate.pose.rotation).normalized();
      hypothesis.cam_from_world = {rotation, -(rotation * candidate.pose.position)};
      hypothesis.score = candidate.score.score();
      hypothesis.confirmed = candidate.score.confirmed;
      hypothesis.explained = candidate.score.explained;
      hypothesis.rms_px = candidate.score.rms_px;
      found.push_back(hypothesis);
    }
    return found;
  }

  const LineMap& map_;
  const pitch::PitchModel& pitch_;
  Side side_;
  const ColdStartOptions& options_;
  MarkingSamples coarse_;
  MarkingSamples fine_;
  double scale_;
  Eigen::Vector2d centre_;
  std::array<std::vector<PencilLine>, 2> pencils_;
  std::vector<ArcBeside> arcs_;
  std::vector<CentredLine> lines_;
  std::map<PlaceKey, Proposal> places_;  // the best of each place and view
};

}  // namespace

base::Status ColdStartOptions::validate() const {
  for (const base::Status& status :
       {base::in_bounds("least_focal", least_focal, 0.2, 20),
        base::in_bounds("most_focal", most_focal, least_focal, 40),
        base::in_bounds("most_roll_deg", most_roll_deg, 0.01, 20),
        base::in_bounds("lines", lines, 3, 40), base::in_bounds("refined", refined, 1, 2000),
        base::in_bounds("kept", kept, 1, 1000),
        base::in_bounds("least_confirmed", least_confirmed, 0, 1),
        base::in_bounds("least_explained", least_explained, 0, 1)})
    if (!status) return status;
  return {};
}

std::vector<ColdHypothesis> cold_start(const LineMap& map, const pitch::PitchModel& pitch,
                                       Side side, const ColdStartOptions& options) {
  if (map.lines.size() < 3) return {};
  return Search(map, pitch, side, options).run();
}

}  // namespace touchline::calibrate
