#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "hub/track/measurement_internal.h"
#include "hub/track/plan_map_internal.h"
#include "shared/geometry/camera_estimate.h"

namespace touchline::track {

namespace {

// Heights above the turf between which a body is weighed, metres: round the pelvis, so that neither
// legs that stride out nor a trunk that leans forward draw the place away.
constexpr double kBodyLow = 0.7;
constexpr double kBodyHigh = 1.15;
// Share of the plan's spread that is left as error of its centre.
constexpr double kSpreadShare = 0.3;
constexpr double kLeastSd = 0.05;     // metres
constexpr double kBallRadius = 0.11;  // metres
constexpr double kMostBallSide = 0.8;
constexpr double kMostBallVolume = 0.08;
constexpr double kLeastPersonHeight = 0.5;
constexpr double kOnTrack = 0.3;  // metres between a group and someone expected in it
constexpr double kSamePerson = 1.0;
constexpr double kRemainder = 2.0;  // metres between a group and what it left of its silhouette

Measurement of_part(const PlanPart& part, std::uint32_t group, const pitch::PitchModel& pitch) {
  Measurement m;
  m.place = pitch.on_turf(part.centre);
  m.covariance =
      kSpreadShare * kSpreadShare * part.spread + kLeastSd * kLeastSd * Eigen::Matrix2d::Identity();
  m.groups = {group};
  return m;
}

bool is_ball_sized(const scene::HullGroup& group) {
  return group.volume_m3 <= kMostBallVolume && group.bounds.sizes().maxCoeff() <= kMostBallSide;
}

std::vector<PlanPart> people_of(const scene::HullGroup& group,
                                std::span<const Eigen::Vector2d> expected,
                                const pitch::PitchModel& pitch) {
  const PlanMap whole(group.surface, pitch, 0, 3);
  const PlanMap body(group.surface, pitch, kBodyLow, kBodyHigh);
  std::vector<PlanPart> parts = body.parts();
  if (parts.empty()) parts = whole.parts();  // lying, or cut off
  std::vector<Eigen::Vector2d> inside;
  for (const Eigen::Vector2d& place : expected) {
    if (body.distance(place) <= kOnTrack) inside.push_back(place);
  }
  if (inside.size() > parts.size()) return body.parts_of(inside);
  return parts;
}

const codec::CameraView* find_view(std::span<const codec::CameraView> views,
                                   const base::CameraId& camera) {
  for (const codec::CameraView& view : views) {
    if (view.id.camera == camera && !view.estimate.lost()) return &view;
  }
  return nullptr;
}

// The foot of a card under the middle of its silhouette. Along the line of sight the lowest pixel
// tells the distance, the less well the flatter the camera looks.
std::optional<Measurement> of_billboard(const scene::Billboard& card,
                                        std::span<const codec::CameraView> views,
                                        const pitch::PitchModel& pitch,
                                        const TrackOptions& options) {
  const codec::CameraView* view = find_view(views, card.camera);
  if (!view) return std::nullopt;
  const Eigen::Vector3d eye = geometry::position_in_world(view->estimate);
  const double distance = (card.foot_in_world - eye).norm();
  const double drop = eye.z() - card.foot_in_world.z();
  if (drop < 0.5) return std::nullopt;
  const double pixel = distance / view->estimate.model.fx;
  const Eigen::Vector2d along = (card.foot_in_world - eye).head<2>().normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const double along_sd = options.foot_sd_px * pixel * distance / drop + 0.15;
  const double across_sd = options.foot_sd_px * pixel + 0.1;
  Measurement m;
  m.place = card.foot_in_world;
  const Eigen::Vector2d middle(card.region.x + (card.region.width - 1) / 2.0,
                               card.region.y + card.region.height - 0.5);
  const auto foot =
      pitch::intersect_turf(pitch, eye, geometry::ray_in_world(view->estimate, middle));
  // Cut by the lower border the card stands elsewhere, with nothing to correct it by.
  if (foot && (*foot - card.foot_in_world).norm() < kSamePerson) m.place = *foot;
  m.covariance = along_sd * along_sd * along * along.transpose() +
                 across_sd * across_sd * across * across.transpose();
  return m;
}

// Whether a card is the part of someone's silhouette that their group does not cover.
bool is_remainder(const scene::Billboard& card, const Measurement& person,
                  const codec::CameraView& view) {
  if ((card.foot_in_world - person.place).head<2>().norm() > kRemainder) return false;
  const auto hip = geometry::project(view.estimate, person.place + Eigen::Vector3d(0, 0, 1));
  if (!hip) return false;
  const double across = std::abs(hip->x() - (card.region.x + card.region.width / 2.0));
  const double down = hip->y() - (card.region.y + card.region.height / 2.0);
  return across <= card.region.width && std::abs(down) <= 2 * card.region.height;
}

// Adds what another camera's card says about the same person, or the card as someone else.
void add_card(std::vector<Measurement>& people, const Measurement& card, std::size_t from_hull) {
  for (std::size_t i = 0; i < people.size(); ++i) {
    Measurement& known = people[i];
    const Eigen::Vector2d away = (card.place - known.place).head<2>();
    const Eigen::Matrix2d both = card.covariance + known.covariance;
    if (away.norm() > kSamePerson || away.dot(both.inverse() * away) > 9) continue;
    if (i < from_hull) return;  // what the hull already holds
    const Eigen::Matrix2d gain = known.covariance * both.inverse();
    known.place.head<2>() += gain * away;
    known.covariance = (Eigen::Matrix2d::Identity() - gain) * known.covariance;
    return;
  }
  people.push_back(card);
}

}  // namespace

Measurements measure(const scene::Hull& hull, std::span<const codec::CameraView> views,
                     std::span<const Eigen::Vector2d> expected, const pitch::PitchModel& pitch,
                     const TrackOptions& options) {
  struct Ball {
    Measurement measurement;
    std::size_t support = 0;
    double unlike = 0;  // how far from round, and from a ball's place
  };
  std::vector<Ball> balls;
  Measurements out;
  for (const scene::HullGroup& group : hull.groups) {
    if (group.phantom) continue;
    const Eigen::Vector3d sides = group.bounds.sizes();
    if (is_ball_sized(group)) {
      Ball ball;
      const Eigen::Vector3d centre = group.bounds.center();
      const double lowest = pitch.turf_z(centre.y()) + kBallRadius;
      ball.measurement.place = {centre.x(), centre.y(), std::max(centre.z(), lowest)};
      const Eigen::Vector2d sd = (sides.head<2>() / 4).cwiseMax(kLeastSd);
      ball.measurement.covariance = sd.cwiseAbs2().asDiagonal();
      ball.measurement.groups = {group.id};
      ball.support = group.support.size();
      ball.unlike = sides.maxCoeff() - sides.minCoeff();
      balls.push_back(std::move(ball));
      continue;
    }
    if (group.volume_m3 < options.least_person_m3 || sides.z() < kLeastPersonHeight) continue;
    for (const PlanPart& part : people_of(group, expected, pitch)) {
      out.people.push_back(of_part(part, group.id, pitch));
    }
  }
  const std::size_t from_hull = out.people.size();
  for (const scene::Billboard& card : hull.billboards) {
    if (card.height_m < kLeastPersonHeight) continue;
    const auto measurement = of_billboard(card, views, pitch, options);
    if (!measurement) continue;
    const codec::CameraView& view = *find_view(views, card.camera);
    const auto hull_end = out.people.begin() + static_cast<std::ptrdiff_t>(from_hull);
    if (std::any_of(out.people.begin(), hull_end,
                    [&](const Measurement& person) { return is_remainder(card, person, view); })) {
      continue;
    }
    add_card(out.people, *measurement, from_hull);
  }
  for (Measurement& person : out.people) {
    person.place = pitch.on_turf(person.place.head<2>());
  }
  std::stable_sort(
      out.people.begin(), out.people.end(),
      [](const Measurement& a, const Measurement& b) { return a.place.x() < b.place.x(); });
  std::stable_sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) {
    if (a.support != b.support) return a.support > b.support;
    return a.unlike < b.unlike;
  });
  for (Ball& ball : balls) out.balls.push_back(std::move(ball.measurement));
  return out;
}

}  // namespace touchline::track
