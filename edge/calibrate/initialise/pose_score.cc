#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "edge/calibrate/initialise/pose_score_internal.h"

namespace touchline::calibrate {
namespace {

constexpr double kLeastVisibleWidthPx = 0.9;  // paint thinner than this counts less
constexpr double kOffTurfWeight = 0.4;        // a predicted line where no turf is may be hidden
constexpr float kThinAtEdgePx = 1.2F;         // paint that the turf's edge may hide
constexpr double kEdgeReachPx = 16;           // of that edge, at 1080 lines
constexpr double kFullWidthPx = 1.6;          // paint this wide has its full contrast
constexpr std::size_t kMostMarkings = 48;     // of a pitch
constexpr double kDashShare = 0.45;           // of a dashed line that is painted, at least
constexpr double kMostDashShare = 0.85;       // a line seen over more of its length is solid
constexpr double kSolidPenalty = 5;           // of its credit, by the share that is seen beyond
constexpr double kLeastGap_m = 1.5;           // between dashes
constexpr double kShowingGap = 3.5;           // in reaches of a ridge point along its line

// Projection in single precision for scoring.
struct FastCamera {
  Eigen::Matrix3f rotation;
  Eigen::Vector3f translation;
  float f, cx, cy, k1, k2, width, height, fold;

  explicit FastCamera(const Pose& pose)
      : rotation(pose.rotation.cast<float>()),
        translation((-(pose.rotation * pose.position)).cast<float>()),
        f(static_cast<float>(pose.model.fx)),
        cx(static_cast<float>(pose.model.cx)),
        cy(static_cast<float>(pose.model.cy)),
        k1(static_cast<float>(pose.model.k1)),
        k2(static_cast<float>(pose.model.k2)),
        width(static_cast<float>(pose.model.width)),
        height(static_cast<float>(pose.model.height)),
        fold(static_cast<float>(std::min(pose.model.fold_radius_squared(), 1e6))) {}

  // Pixel of a point and the image of a unit tangent there, pixels a metre.
  bool project(const Eigen::Vector3f& point, const Eigen::Vector3f& tangent, Eigen::Vector2f& pixel,
               Eigen::Vector2f& along, float& depth) const {
    const Eigen::Vector3f p = rotation * point + translation;
    if (p.z() < 1.0F) return false;
    const float inverse = 1 / p.z();
    const float x = p.x() * inverse;
    const float y = p.y() * inverse;
    const float r2 = x * x + y * y;
    if (r2 >= fold) return false;
    const float d = 1 + r2 * (k1 + k2 * r2);
    pixel = {f * d * x + cx, f * d * y + cy};
    if (pixel.x() < 0 || pixel.y() < 0 || pixel.x() > width - 1 || pixel.y() > height - 1)
      return false;
    const Eigen::Vector3f t = rotation * tangent;
    along = {f * inverse * (t.x() - x * t.z()), f * inverse * (t.y() - y * t.z())};
    depth = p.z();
    return true;
  }
};

struct Tally {
  // One a marking: line length in pixels that should be seen, and that is.
  struct Marking {
    double predicted = 0;
    double confirmed = 0;
    double matched_px = 0;
    double dash_px = 0;  // sum of the gaps' lengths by predicted length, for their mean
  };
  std::array<Marking, kMostMarkings> markings{};
  double seen_m = 0;
  double squares = 0;
  double weights = 0;
  std::array<double, 6> by_direction{};  // confirmed length by image direction, 30 degrees each
};

// Off the turf; or thin paint at its edge, where a hoarding's foot or paler ground takes the dark
// side from it that a ridge needs.
bool may_be_hidden(const LineMap& map, const Eigen::Vector2f& pixel, const Eigen::Vector2f& along,
                   float paint_px) {
  const Eigen::Vector2d at = pixel.cast<double>();
  if (!map.on_turf(at)) return true;
  if (paint_px >= kThinAtEdgePx) return false;
  const double reach = kEdgeReachPx * std::max(map.height / 1080.0, 0.5);
  const Eigen::Vector2d across = reach * Eigen::Vector2d(-along.y(), along.x());
  return (map.inside(at + across) && !map.on_turf(at + across)) ||
         (map.inside(at - across) && !map.on_turf(at - across));
}

Tally tally(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
            double tolerance_px) {
  const FastCamera camera(pose);
  const float tolerance = static_cast<float>(tolerance_px);
  const float reach = tolerance + 8 * static_cast<float>(std::max(map.height / 1080.0, 0.5));
  Tally sum;
  Eigen::Vector2f pixel, along;
  float depth = 0;
  for (const MarkingSamples::Sample& sample : samples.samples) {
    if (!camera.project(sample.point, sample.tangent, pixel, along, depth)) continue;
    const float speed = along.norm();
    const float length = speed * sample.step;
    // Paint across the line of sight is foreshortened by the height over the distance; the same
    // factor that shortens a tangent along it. A bound from both is enough here.
    const float paint =
        sample.width * camera.f / depth *
        std::max(0.15F, std::min(1.0F, static_cast<float>(pose.position.z()) / depth * 1.2F +
                                           std::abs(along.y()) / (speed + 1e-6F)));
    // Thin paint, and paint on dark turf, stands out less than what is found.
    const float contrast = map.strength_at(pixel.x(), pixel.y()) *
                           std::min(1.0F, paint / static_cast<float>(kFullWidthPx));
    const float visible = std::min(1.0F, paint / static_cast<float>(kLeastVisibleWidthPx)) *
                          std::clamp(contrast - 1, 0.1F, 1.0F);
    double weight = std::min(length, 60.0F) * visible;
    Tally::Marking& marking = sum.markings[static_cast<std::size_t>(sample.marking)];
    const int at = map.nearest_to(pixel.cast<double>());
    bool hit = false;
    if (at >= 0) {
      const RidgePoint& ridge = map.points[static_cast<std::size_t>(at)];
      const float across = ridge.normal.dot(pixel - ridge.position);
      const Eigen::Vector2f ridge_along(-ridge.normal.y(), ridge.normal.x());
      const float beyond = std::abs(ridge_along.dot(pixel - ridge.position));
      if (std::abs(across) < tolerance && beyond < reach &&
          std::abs(ridge.normal.dot(along)) < kLeastAlong * speed) {
        hit = true;
        const double share =
            1 - static_cast<double>(across * across) / (tolerance_px * tolerance_px);
        marking.confirmed += weight * share;
        marking.matched_px +=
            std::max(std::abs(along.x()), std::abs(along.y())) * sample.step * share;
        sum.seen_m += sample.step;
        sum.squares += weight * across * across;
        sum.weights += weight;
        double angle = std::atan2(along.y(), along.x()) / 3.14159265358979 * 6;
        if (angle < 0) angle += 6;
        sum.by_direction[static_cast<std::size_t>(angle) % 6] += length;
      }
    }
    if (!hit && may_be_hidden(map, pixel, along / speed, paint)) weight *= kOffTurfWeight;
    marking.predicted += weight;
    marking.dash_px += weight * kLeastGap_m * speed;
  }
  // Gaps shorter than what a ridge point confirms beyond itself do not show.
  for (std::size_t i = 0; i < samples.dashed.size(); ++i) {
    Tally::Marking& marking = sum.markings[i];
    if (!samples.dashed[i] || marking.predicted <= 0) continue;
    const double share = marking.confirmed / marking.predicted;
    // Of a dashed line no more than its dashes can be seen, and need be.
    const bool gaps_show = marking.dash_px > kShowingGap * double{reach} * marking.predicted;
    double credit = std::min(1.0, share / kDashShare);
    if (gaps_show && share > kMostDashShare)
      credit = std::max(0.0, credit - kSolidPenalty * (share - kMostDashShare));
    marking.predicted *= kDashShare;
    marking.confirmed = marking.predicted * credit;
  }
  return sum;
}

PoseScore from_tally(const Tally& sum) {
  PoseScore score;
  double predicted = 0;
  double confirmed = 0;
  for (const Tally::Marking& marking : sum.markings) {
    predicted += marking.predicted;
    confirmed += marking.confirmed;
  }
  if (predicted > 0) score.confirmed = confirmed / predicted;
  score.missing_px = predicted - confirmed;
  score.seen_m = sum.seen_m;
  if (sum.weights > 0) score.rms_px = std::sqrt(sum.squares / sum.weights);
  for (const double length : sum.by_direction)
    if (length > 40) ++score.directions;
  return score;
}

}  // namespace

MarkingSamples sample_markings(const pitch::PitchModel& pitch, double spacing_m) {
  MarkingSamples result;
  result.bars = pitch.bars;
  for (std::size_t i = 0; i < std::min(pitch.markings.size(), kMostMarkings); ++i)
    result.dashed.push_back(pitch.markings[i].dashed);
  for (std::size_t i = 0; i < result.dashed.size(); ++i) {
    const pitch::Marking& marking = pitch.markings[i];
    if (marking.shape == pitch::MarkingShape::kSpot) continue;
    const double length = marking.length();
    const double spacing = std::min(spacing_m, std::max(0.1, length / 4));
    const int count = std::max(2, static_cast<int>(std::lround(length / spacing)));
    for (int k = 0; k < count; ++k) {
      const double at = (k + 0.5) * length / count;
      const Eigen::Vector2d p = marking.at(at);
      const Eigen::Vector2d t = marking.tangent(at);
      MarkingSamples::Sample sample;
      sample.point = pitch.on_turf(p).cast<float>();
      const double slope = (pitch.turf_z(p.y() + 0.5 * t.y()) - pitch.turf_z(p.y() - 0.5 * t.y()));
      sample.tangent = Eigen::Vector3d(t.x(), t.y(), slope).normalized().cast<float>();
      sample.step = static_cast<float>(length / count);
      sample.width = static_cast<float>(marking.width);
      sample.marking = static_cast<int>(i);
      result.samples.push_back(sample);
    }
  }
  return result;
}

PoseScore score_markings(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                         double tolerance_px) {
  return from_tally(tally(map, samples, pose, tolerance_px));
}

PoseScore score_fast(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                     double tolerance_px) {
  const Tally sum = tally(map, samples, pose, tolerance_px);
  PoseScore score = from_tally(sum);
  double matched = 0;
  for (const Tally::Marking& marking : sum.markings) matched += marking.matched_px;
  if (!map.points.empty())
    score.explained = std::min(1.0, matched / static_cast<double>(map.points.size()));
  return score;
}

LineConflict line_conflict(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                           double tolerance_px) {
  constexpr double kLong = 0.15;  // of the picture's width
  constexpr double kHardly = 0.2;
  const double least = kLong * map.width;
  LineConflict conflict;
  const Tally sum = tally(map, samples, pose, tolerance_px);
  for (std::size_t i = 0; i < samples.dashed.size(); ++i) {
    const Tally::Marking& marking = sum.markings[i];
    const double should = marking.predicted / (samples.dashed[i] ? kDashShare : 1);
    if (should > least && marking.confirmed < kHardly * marking.predicted) ++conflict.missing;
  }
  if (conflict.missing == 0) return conflict;
  // The predicted markings as points, against each line of the picture.
  const FastCamera camera(pose);
  std::vector<Eigen::Vector4f> predicted;  // place, direction
  Eigen::Vector2f pixel, along;
  float depth = 0;
  for (const MarkingSamples::Sample& sample : samples.samples) {
    if (!camera.project(sample.point, sample.tangent, pixel, along, depth)) continue;
    const Eigen::Vector2f u = along.normalized();
    predicted.emplace_back(pixel.x(), pixel.y(), u.x(), u.y());
  }
  const std::vector<SeenBar> bars = seen_bars(map, samples, pose, 2 * tolerance_px);
  constexpr int kBins = 24;
  for (const LineHypothesis& line : map.lines) {
    const Eigen::Vector2f start = line.start.cast<float>();
    const Eigen::Vector2f span = (line.end - line.start).cast<float>();
    const float length = span.norm();
    if (line.points < least || length < least) continue;
    const Eigen::Vector2f u = span / length;
    std::array<bool, kBins> named{};
    for (const Eigen::Vector4f& p : predicted) {
      const Eigen::Vector2f off = p.head<2>() - start;
      const float t = u.dot(off) / length;
      if (t < 0 || t >= 1 || std::abs(u.x() * p.w() - u.y() * p.z()) > kLeastAlong) continue;
      if (std::abs(u.x() * off.y() - u.y() * off.x()) > 2 * static_cast<float>(tolerance_px))
        continue;
      named[static_cast<std::size_t>(t * kBins)] = true;
    }
    for (int i = 0; i < kBins; ++i) {
      const Eigen::Vector2f p = start + span * ((static_cast<float>(i) + 0.5F) / kBins);
      for (const SeenBar& bar : bars)
        if (bar.passes(p, {-u.y(), u.x()}, 2 * static_cast<float>(tolerance_px)))
          named[static_cast<std::size_t>(i)] = true;
    }
    if (static_cast<double>(std::count(named.begin(), named.end(), true)) < kHardly * kBins)
      ++conflict.unnamed;
  }
  return conflict;
}

double width_ratio(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                   double tolerance_px) {
  constexpr double kLeastPredictedPx = 3;
  constexpr std::size_t kFewest = 12;
  const FastCamera camera(pose);
  const auto tolerance = static_cast<float>(tolerance_px);
  std::vector<double> ratios;
  Eigen::Vector2f pixel, along;
  float depth = 0;
  for (const MarkingSamples::Sample& sample : samples.samples) {
    if (!camera.project(sample.point, sample.tangent, pixel, along, depth)) continue;
    const int at = map.nearest_to(pixel.cast<double>());
    if (at < 0) continue;
    const RidgePoint& ridge = map.points[static_cast<std::size_t>(at)];
    if (std::abs(ridge.normal.dot(pixel - ridge.position)) > tolerance ||
        std::abs(ridge.normal.dot(along)) > kLeastAlong * along.norm())
      continue;
    const Eigen::Vector3f across(-sample.tangent.y(), sample.tangent.x(), 0);
    Eigen::Vector2f end, along_end;
    if (!camera.project(sample.point + sample.width * across, sample.tangent, end, along_end,
                        depth))
      continue;
    const double predicted = std::abs(ridge.normal.dot(end - pixel));
    if (predicted < kLeastPredictedPx) continue;
    ratios.push_back(double{ridge.width} / predicted);
  }
  if (ratios.size() < kFewest) return 0;
  const auto middle = ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2);
  std::nth_element(ratios.begin(), middle, ratios.end());
  return *middle;
}

bool widths_agree(const LineMap& map, const MarkingSamples& samples, const Pose& pose,
                  double tolerance_px) {
  const double ratio = width_ratio(map, samples, pose, tolerance_px);
  return ratio == 0 || (ratio > 0.62 && ratio < 1.7);
}

}  // namespace touchline::calibrate
