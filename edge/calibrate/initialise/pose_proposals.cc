#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "edge/calibrate/initialise/pose_proposals_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kPictureLines = 9;        // strongest Hough lines that are tried
constexpr double kLeastProposed = 0.2;  // score of a proposal
constexpr double kCellPx = 1.7;         // places that differ by less are one, in tolerances
constexpr double kCellFocal = 0.07;     // the same, of log focal
constexpr double kSlideFocal = 1.2;  // picture widths of focal length for one slide to either side
constexpr int kMostSlides = 4;
constexpr double kArcStepDeg = 12;        // between tangents of an arc
constexpr double kCrossingSine = 0.08;    // least, between two lines whose crossing is tried
constexpr double kCrossingBeyond = 0.25;  // of the picture, that a crossing may lie outside of it
constexpr double kCrossingSlope = 0.05;   // sine between a picture line and the pitch's there
constexpr double kJoin_m = 0.5;           // markings that end this near to another meet it

// The strongest lines; those along a direction that others have count less: many lines one way
// leave open where the picture lies along them.
std::vector<const LineHypothesis*> lines_to_try(const LineMap& map) {
  constexpr double kSimilarSine = 0.15;
  std::vector<const LineHypothesis*> chosen;
  std::vector<bool> used(map.lines.size(), false);
  while (chosen.size() < std::min(map.lines.size(), static_cast<std::size_t>(kPictureLines))) {
    double most = -1;
    std::size_t best = 0;
    for (std::size_t i = 0; i < map.lines.size(); ++i) {
      if (used[i]) continue;
      const Eigen::Vector2d& n = map.lines[i].normal;
      const auto similar =
          std::count_if(chosen.begin(), chosen.end(), [&](const LineHypothesis* other) {
            return std::abs(n.x() * other->normal.y() - n.y() * other->normal.x()) < kSimilarSine;
          });
      const double weight = map.lines[i].points / (1.0 + 0.7 * static_cast<double>(similar));
      if (weight <= most) continue;
      most = weight;
      best = i;
    }
    used[best] = true;
    chosen.push_back(&map.lines[best]);
  }
  return chosen;
}

// Direction in the picture plane, at `at` (both on the plane z = 1), of a line through there.
Eigen::Vector2d seen_along(const Eigen::Vector3d& tangent, const Eigen::Vector2d& at) {
  return {tangent.x() - at.x() * tangent.z(), tangent.y() - at.y() * tangent.z()};
}

double sine(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return std::abs(a.x() * b.y() - a.y() * b.x()) /
         std::sqrt(std::max(1e-300, a.squaredNorm() * b.squaredNorm()));
}

}  // namespace

PoseProposer::PoseProposer(const pitch::PitchModel& pitch, const geometry::Mount& mount,
                           const InitialiseOptions& options)
    : mount_(mount),
      options_(options),
      head_from_world_(geometry::world_from_head(mount).conjugate().toRotationMatrix()),
      sparse_(sample_markings(pitch, kProposalSpacing)) {
  add_lines(pitch);
  add_crossings(pitch);
}

Pose PoseProposer::pose(double pan, double tilt, double focal) const {
  Pose result;
  result.model = geometry::camera_model(mount_, focal);
  result.rotation =
      geometry::cam_from_reference(pan, tilt, 0).toRotationMatrix() * head_from_world_;
  result.position = mount_.position_in_world;
  return result;
}

void PoseProposer::add_lines(const pitch::PitchModel& pitch) {
  const auto add = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    ModelLine line;
    line.start = head_from_world_ * (pitch.on_turf(a) - mount_.position_in_world);
    line.end = head_from_world_ * (pitch.on_turf(b) - mount_.position_in_world);
    const Eigen::Vector3d normal = line.start.cross(line.end);
    if (normal.norm() < 1e-6) return;
    line.normal_in_head = normal.normalized();
    lines_.push_back(line);
  };
  for (const pitch::Marking& marking : pitch.markings) {
    if (marking.shape == pitch::MarkingShape::kLine) {
      // Markings on one line of the pitch (a goal line with its boxes' ends) are one marking each.
      add(marking.start, marking.end);
    } else if (marking.shape == pitch::MarkingShape::kArc && marking.radius > 3) {
      const double length = marking.length();
      const double step = marking.radius * kArcStepDeg * kPi / 180;
      const int count = std::max(1, static_cast<int>(std::lround(length / step)));
      for (int i = 0; i < count; ++i) {
        const double at = (i + 0.5) * length / count;
        const Eigen::Vector2d p = marking.at(at);
        const Eigen::Vector2d t = marking.tangent(at);
        add(p - 0.45 * marking.radius * t, p + 0.45 * marking.radius * t);
      }
    }
  }
}

void PoseProposer::add_crossings(const pitch::PitchModel& pitch) {
  const auto along = [](const pitch::Marking& m) {
    return m.shape == pitch::MarkingShape::kLine && std::abs(m.start.y() - m.end.y()) < 0.01;
  };
  const auto across = [](const pitch::Marking& m) {
    return m.shape == pitch::MarkingShape::kLine && std::abs(m.start.x() - m.end.x()) < 0.01;
  };
  const auto covers = [](double a, double b, double at) {
    return at > std::min(a, b) - kJoin_m && at < std::max(a, b) + kJoin_m;
  };
  for (const pitch::Marking& a : pitch.markings) {
    if (!along(a)) continue;
    for (const pitch::Marking& b : pitch.markings) {
      if (!across(b)) continue;
      const double x = b.start.x();
      const double y = a.start.y();
      if (!covers(a.start.x(), a.end.x(), x) || !covers(b.start.y(), b.end.y(), y)) continue;
      const double slope = pitch.turf_z(y + 0.5) - pitch.turf_z(y - 0.5);
      crossings_.push_back({head_from_world_ * (pitch.on_turf({x, y}) - mount_.position_in_world),
                            {head_from_world_ * Eigen::Vector3d::UnitX(),
                             head_from_world_ * Eigen::Vector3d(0, 1, slope)}});
    }
  }
}

// Whether a direction in the plane through the camera and a line meets the line's length.
bool PoseProposer::within_span(const Eigen::Vector3d& direction, const ModelLine& line,
                               double slack) {
  const Eigen::Vector3d a = line.start.normalized();
  const Eigen::Vector3d b = line.end.normalized();
  const Eigen::Vector3d u = a;
  const Eigen::Vector3d v = (b - b.dot(u) * u).normalized();
  const double span = std::atan2(b.dot(v), b.dot(u));
  const double angle = std::atan2(direction.dot(v), direction.dot(u));
  return angle > -slack && angle < span + slack;
}

void PoseProposer::try_pose(const LineMap& map, double pan, double tilt, double focal,
                            double tolerance, Places& places, int& tried) const {
  ++tried;
  const double score = score_fast(map, sparse_, pose(pan, tilt, focal), tolerance).score();
  if (score < kLeastProposed) return;
  const double cell = kCellPx * tolerance / focal;
  const PlaceKey key{static_cast<int>(std::lround(pan * std::cos(tilt) / cell)),
                     static_cast<int>(std::lround(tilt / cell)),
                     static_cast<int>(std::lround(std::log(focal) / kCellFocal))};
  PoseProposal& best = places[key];
  if (score > best.score) best = {pan, tilt, focal, score};
}

// Poses without roll that put a model line on the picture line between the directions `from` and
// `to` (in the camera's frame), for one focal length.
void PoseProposer::propose_line(const LineMap& map, const Eigen::Vector3d& from,
                                const Eigen::Vector3d& to, double focal, double tolerance,
                                Places& places, int& tried) const {
  const Eigen::Vector3d n = from.cross(to).normalized();
  // The longer the lens, the farther a small error of roll puts the picture along the line.
  const int slides =
      std::clamp(static_cast<int>(std::lround(focal / (kSlideFocal * map.width))), 1, kMostSlides);
  const double slack = (30 + slides * 1.3 * tolerance) / focal;
  // One step along the picture line, pixels.
  const Eigen::Vector2d along = to.head<2>() - from.head<2>();
  const Eigen::Vector2d slide = 1.3 * tolerance * along.normalized();
  for (const ModelLine& line : lines_) {
    const Eigen::Vector3d& m = line.normal_in_head;
    const double level = m.head<2>().norm();
    if (std::abs(n.x()) >= level) continue;
    const double phase = std::atan2(m.y(), m.x());
    for (const double sign : {1.0, -1.0}) {
      const double open = std::acos(sign * n.x() / level);
      for (const double branch : {1.0, -1.0}) {
        const double pan = -phase + branch * open;
        const double h = std::sin(pan) * m.x() + std::cos(pan) * m.y();
        const double tilt = std::atan2(m.z() * sign * n.z() + h * sign * n.y(),
                                       h * sign * n.z() - m.z() * sign * n.y());
        if (tilt < options_.least_tilt_deg * kPi / 180 || tilt > options_.most_tilt_deg * kPi / 180)
          continue;
        const Eigen::Matrix3d rotation =
            geometry::cam_from_reference(pan, tilt, 0).toRotationMatrix();
        const Eigen::Vector3d a = rotation.transpose() * from;
        const Eigen::Vector3d b = rotation.transpose() * to;
        if (!within_span(a, line, slack) || !within_span(b, line, slack)) continue;
        // Where along the line the picture lies hangs on the line's slope alone, and that on roll
        // and lens: places to both sides are tried as well.
        for (int step = -slides; step <= slides; ++step)
          try_pose(map, pan - step * slide.x() / (focal * std::cos(tilt)),
                   tilt + step * slide.y() / focal, focal, tolerance, places, tried);
      }
    }
  }
}

// Poses without roll that put a crossing of the pitch on one of the picture, where the lines there
// run as they should.
void PoseProposer::propose_crossing(const LineMap& map, const PictureCrossing& crossing,
                                    double focal, double tolerance, Places& places,
                                    int& tried) const {
  const geometry::CameraModel model = geometry::camera_model(mount_, focal);
  const Eigen::Vector3d ray = model.unproject(crossing.pixel).normalized();
  const Eigen::Vector2d at = ray.head<2>() / ray.z();
  std::array<Eigen::Vector2d, 2> along;
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d a = model.unproject(crossing.of[i]->start);
    const Eigen::Vector3d b = model.unproject(crossing.of[i]->end);
    along[i] = b.head<2>() / b.z() - a.head<2>() / a.z();
  }
  const double reach = std::hypot(ray.y(), ray.z());
  const double ray_turn = std::atan2(ray.y(), ray.z());
  for (const ModelCrossing& on : crossings_) {
    const Eigen::Vector3d direction = on.point.normalized();
    const double height = direction.z() / reach;
    if (std::abs(height) >= 1) continue;
    const double tilt = std::asin(height) + ray_turn;
    if (tilt < options_.least_tilt_deg * kPi / 180 || tilt > options_.most_tilt_deg * kPi / 180)
      continue;
    const double ahead = ray.z() * std::cos(tilt) + ray.y() * std::sin(tilt);
    const double pan = std::atan2(direction.x(), direction.y()) - std::atan2(ray.x(), ahead);
    const Eigen::Matrix3d rotation = geometry::cam_from_reference(pan, tilt, 0).toRotationMatrix();
    const Eigen::Vector2d x = seen_along(rotation * on.of[0], at);
    const Eigen::Vector2d y = seen_along(rotation * on.of[1], at);
    if ((sine(x, along[0]) < kCrossingSlope && sine(y, along[1]) < kCrossingSlope) ||
        (sine(x, along[1]) < kCrossingSlope && sine(y, along[0]) < kCrossingSlope))
      try_pose(map, pan, tilt, focal, tolerance, places, tried);
  }
}

std::vector<PoseProposal> PoseProposer::propose(const LineMap& map, int& tried) const {
  Places places;
  const double tolerance = 24 * std::max(map.height / 1080.0, 0.4);
  const double least = std::log(options_.least_focal * map.width);
  const double most = std::log(options_.most_focal * map.width);
  const int steps = std::max(1, static_cast<int>(std::ceil((most - least) / options_.focal_step)));
  const std::vector<const LineHypothesis*> lines = lines_to_try(map);
  std::vector<PictureCrossing> crossings;
  const Eigen::AlignedBox2d near_picture(
      Eigen::Vector2d(-kCrossingBeyond * map.width, -kCrossingBeyond * map.height),
      Eigen::Vector2d((1 + kCrossingBeyond) * map.width, (1 + kCrossingBeyond) * map.height));
  for (std::size_t i = 0; i < lines.size(); ++i) {
    for (std::size_t k = i + 1; k < lines.size(); ++k) {
      const Eigen::Vector2d& a = lines[i]->normal;
      const Eigen::Vector2d& b = lines[k]->normal;
      const double determinant = a.x() * b.y() - a.y() * b.x();
      if (std::abs(determinant) < kCrossingSine) continue;
      const Eigen::Vector2d pixel((b.y() * lines[i]->offset - a.y() * lines[k]->offset),
                                  (a.x() * lines[k]->offset - b.x() * lines[i]->offset));
      if (near_picture.contains(pixel / determinant))
        crossings.push_back({pixel / determinant, {lines[i], lines[k]}});
    }
  }
  for (int s = 0; s <= steps; ++s) {
    const double focal = std::exp(least + (most - least) * s / steps);
    const geometry::CameraModel model = geometry::camera_model(mount_, focal);
    for (const LineHypothesis* line : lines)
      propose_line(map, model.unproject(line->start), model.unproject(line->end), focal, tolerance,
                   places, tried);
    for (const PictureCrossing& crossing : crossings)
      propose_crossing(map, crossing, focal, tolerance, places, tried);
  }
  std::vector<PoseProposal> kept;
  kept.reserve(places.size());
  for (const auto& [key, proposal] : places) kept.push_back(proposal);
  std::stable_sort(kept.begin(), kept.end(),
                   [](const PoseProposal& a, const PoseProposal& b) { return a.score > b.score; });
  return kept;
}

}  // namespace touchline::calibrate
