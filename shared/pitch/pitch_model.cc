#include "shared/pitch/pitch_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace touchline::pitch {
namespace {

constexpr double kPi = std::numbers::pi;

// Laws of the game, association football and rugby union; metres.
constexpr double kPenaltyDepth = 16.5;
constexpr double kPenaltyHalfWidth = 20.16;
constexpr double kGoalAreaDepth = 5.5;
constexpr double kGoalAreaHalfWidth = 9.16;
constexpr double kCircleRadius = 9.15;
constexpr double kPenaltyMark = 11.0;
constexpr double kCornerRadius = 1.0;
constexpr double kSpotRadius = 0.11;
constexpr double kPostDiameter = 0.12;
constexpr double kFlagHeight = 1.5;
constexpr double kFlagDiameter = 0.04;
constexpr double kRugbyPostGap = 5.6;
constexpr double kRugbyBarHeight = 3.0;
constexpr double kPadHeight = 2.0;
constexpr double kPadWidth = 0.6;
constexpr double kRugbyPostHeight = 12.0;  // at least 3.4 by the laws; what big grounds have
// The net's frame is not in the laws; what free-hanging box goals have.
constexpr double kNetDepth = 2.0;
constexpr double kNetBarDiameter = 0.05;

// Which end of the pitch: the sign of x there.
constexpr std::array<double, 2> kEnds{-1.0, 1.0};

struct Bounds {
  double low;
  double high;
};

// The value of a size, or the default; an error that names the bound where it lies outside.
base::Result<double> checked(const char* field, const std::optional<double>& value, double standard,
                             Bounds bounds) {
  const double v = value.value_or(standard);
  if (v >= bounds.low && v <= bounds.high) return v;
  return base::fail(base::ErrorKind::kConfiguration, fmt::format("pitch.{}", field),
                    fmt::format("{} m is outside {} to {} m", v, bounds.low, bounds.high),
                    "measure the pitch again, or leave the size out");
}

// Builds markings from centre lines.
class Painter {
 public:
  explicit Painter(PitchModel& model) : model_(model) {}

  void line(MarkingId id, double x0, double y0, double x1, double y1, bool dashed = false) {
    Marking m;
    m.id = id;
    m.shape = MarkingShape::kLine;
    m.start = {x0, y0};
    m.end = {x1, y1};
    m.width = model_.line_m;
    m.dashed = dashed;
    model_.markings.push_back(m);
  }
  void arc(MarkingId id, double cx, double cy, double radius, double from, double to) {
    Marking m;
    m.id = id;
    m.shape = MarkingShape::kArc;
    m.centre = {cx, cy};
    m.radius = radius;
    m.start_angle = from;
    m.end_angle = to;
    m.width = model_.line_m;
    m.start = m.at(0);
    m.end = m.at(m.length());
    model_.markings.push_back(m);
  }
  void spot(MarkingId id, double cx, double cy) {
    Marking m;
    m.id = id;
    m.shape = MarkingShape::kSpot;
    m.centre = m.start = m.end = {cx, cy};
    m.radius = kSpotRadius;
    m.width = 2 * kSpotRadius;
    model_.markings.push_back(m);
  }
  void bar(const Eigen::Vector3d& start, const Eigen::Vector3d& end, double diameter) {
    model_.bars.push_back({start, end, diameter});
  }
  void pole(double x, double y, double height, double diameter) {
    const double z = model_.turf_z(y);
    bar({x, y, z}, {x, y, z + height}, diameter);
  }

 private:
  PitchModel& model_;
};

// Posts and cross bar of a soccer goal on its goal line (x = `line_x`).
void add_goal_frame(Painter& painter, const PitchModel& model, double line_x) {
  const double y = model.goal_width_m / 2 + kPostDiameter / 2;
  const double bar_z = model.goal_height_m + kPostDiameter / 2;
  for (const double side : kEnds)
    painter.bar({line_x, side * y, model.turf_z(y)}, {line_x, side * y, bar_z}, kPostDiameter);
  painter.bar({line_x, -y, bar_z}, {line_x, y, bar_z}, kPostDiameter);
}

// The box behind a goal: stanchions, bars on the ground, and the four panels of net between them.
void add_net(Painter& painter, PitchModel& model, double line_x, double end) {
  const double y = model.goal_width_m / 2 + kPostDiameter / 2;
  const double z = model.turf_z(y);
  const double top = model.goal_height_m + kPostDiameter / 2;
  const double back_x = line_x + end * kNetDepth;
  for (const double side : kEnds) {
    painter.bar({back_x, side * y, z}, {back_x, side * y, top}, kNetBarDiameter);
    painter.bar({line_x, side * y, z}, {back_x, side * y, z}, kNetBarDiameter);
  }
  painter.bar({back_x, -y, z}, {back_x, y, z}, kNetBarDiameter);
  for (const double side : kEnds)
    model.nets.push_back({{Eigen::Vector3d(line_x, side * y, z),
                           {back_x, side * y, z},
                           {back_x, side * y, top},
                           {line_x, side * y, top}}});
  model.nets.push_back(
      {{Eigen::Vector3d(back_x, -y, z), {back_x, y, z}, {back_x, y, top}, {back_x, -y, top}}});
  model.nets.push_back(
      {{Eigen::Vector3d(line_x, -y, top), {line_x, y, top}, {back_x, y, top}, {back_x, -y, top}}});
}

// A box of markings in front of a goal: outer edges `depth` from the goal line's outer edge and
// `half_width` from the middle.
void add_area(Painter& painter, const PitchModel& model, double end, double depth,
              double half_width, std::array<MarkingId, 3> front_near_far) {
  const double half_line = model.line_m / 2;
  const double goal_x = end * model.length_m / 2;
  const double front_x = end * (model.length_m / 2 - depth);
  const double centre_x = end * (model.length_m / 2 - depth + half_line);
  const double centre_y = half_width - half_line;
  painter.line(front_near_far[0], centre_x, -half_width, centre_x, half_width);
  painter.line(front_near_far[1], goal_x, -centre_y, front_x, -centre_y);
  painter.line(front_near_far[2], goal_x, centre_y, front_x, centre_y);
}

void paint_soccer(PitchModel& model) {
  using enum MarkingId;
  Painter painter(model);
  const double half_line = model.line_m / 2;
  const double hl = model.length_m / 2;
  const double hw = model.width_m / 2;
  painter.line(kNearTouchline, -hl, -(hw - half_line), hl, -(hw - half_line));
  painter.line(kFarTouchline, -hl, hw - half_line, hl, hw - half_line);
  painter.line(kLeftGoalLine, -(hl - half_line), -hw, -(hl - half_line), hw);
  painter.line(kRightGoalLine, hl - half_line, -hw, hl - half_line, hw);
  painter.line(kHalfwayLine, 0, -hw, 0, hw);
  painter.arc(kCentreCircle, 0, 0, kCircleRadius - half_line, 0, 2 * kPi);
  painter.spot(kCentreSpot, 0, 0);

  add_area(painter, model, -1, kPenaltyDepth, kPenaltyHalfWidth,
           {kLeftPenaltyFront, kLeftPenaltyNear, kLeftPenaltyFar});
  add_area(painter, model, -1, kGoalAreaDepth, kGoalAreaHalfWidth,
           {kLeftGoalAreaFront, kLeftGoalAreaNear, kLeftGoalAreaFar});
  add_area(painter, model, 1, kPenaltyDepth, kPenaltyHalfWidth,
           {kRightPenaltyFront, kRightPenaltyNear, kRightPenaltyFar});
  add_area(painter, model, 1, kGoalAreaDepth, kGoalAreaHalfWidth,
           {kRightGoalAreaFront, kRightGoalAreaNear, kRightGoalAreaFar});

  const double arc_radius = kCircleRadius - half_line;
  const double arc_half_angle = std::acos((kPenaltyDepth - kPenaltyMark) / arc_radius);
  painter.spot(kLeftPenaltySpot, -(hl - kPenaltyMark), 0);
  painter.spot(kRightPenaltySpot, hl - kPenaltyMark, 0);
  painter.arc(kLeftPenaltyArc, -(hl - kPenaltyMark), 0, arc_radius, -arc_half_angle,
              arc_half_angle);
  painter.arc(kRightPenaltyArc, hl - kPenaltyMark, 0, arc_radius, kPi - arc_half_angle,
              kPi + arc_half_angle);

  const double corner = kCornerRadius - half_line;
  painter.arc(kLeftNearCorner, -hl, -hw, corner, 0, kPi / 2);
  painter.arc(kRightNearCorner, hl, -hw, corner, kPi / 2, kPi);
  painter.arc(kRightFarCorner, hl, hw, corner, kPi, 1.5 * kPi);
  painter.arc(kLeftFarCorner, -hl, hw, corner, 1.5 * kPi, 2 * kPi);

  for (const double end : kEnds) add_goal_frame(painter, model, end * (hl - half_line));
  for (const double end : kEnds) add_net(painter, model, end * (hl - half_line), end);
  for (const double x : kEnds)
    for (const double y : kEnds) painter.pole(x * hl, y * hw, kFlagHeight, kFlagDiameter);
}

void paint_rugby(PitchModel& model) {
  using enum MarkingId;
  Painter painter(model);
  const double half_line = model.line_m / 2;
  const double try_x = model.length_m / 2;
  const double dead_x = try_x + model.in_goal_m;
  const double hw = model.width_m / 2;
  painter.line(kNearTouchline, -dead_x, -(hw - half_line), dead_x, -(hw - half_line));
  painter.line(kFarTouchline, -dead_x, hw - half_line, dead_x, hw - half_line);
  painter.line(kHalfwayLine, 0, -hw, 0, hw);
  const auto across = [&](MarkingId left, MarkingId right, double x, double half_width,
                          bool dashed) {
    painter.line(left, -x, -half_width, -x, half_width, dashed);
    painter.line(right, x, -half_width, x, half_width, dashed);
  };
  across(kLeftGoalLine, kRightGoalLine, try_x, hw, false);
  across(kLeftDeadBall, kRightDeadBall, dead_x - half_line, hw, false);
  across(kLeft22, kRight22, try_x - 22, hw, false);
  across(kLeft10, kRight10, 10, hw, true);
  across(kLeft5, kRight5, try_x - 5, hw - 5, true);
  const auto along = [&](MarkingId near_id, MarkingId far_id, double distance) {
    const double end_x = try_x - 5;
    painter.line(near_id, -end_x, -(hw - distance), end_x, -(hw - distance), true);
    painter.line(far_id, -end_x, hw - distance, end_x, hw - distance, true);
  };
  along(kNear5, kFar5, 5);
  along(kNear15, kFar15, 15);

  const double post_y = kRugbyPostGap / 2 + kPostDiameter / 2;
  const double bar_z = kRugbyBarHeight - kPostDiameter / 2;
  for (const double end : kEnds) {
    const double x = end * try_x;
    for (const double side : kEnds) painter.pole(x, side * post_y, kRugbyPostHeight, kPostDiameter);
    painter.bar({x, -post_y, bar_z}, {x, post_y, bar_z}, kPostDiameter);
  }
  for (const double x : {-dead_x, -try_x, try_x, dead_x})
    for (const double y : kEnds) painter.pole(x, y * hw, kFlagHeight, kFlagDiameter);
}

}  // namespace

std::string_view name(MarkingId id) {
  switch (id) {
    case MarkingId::kNearTouchline:
      return "near touchline";
    case MarkingId::kFarTouchline:
      return "far touchline";
    case MarkingId::kLeftGoalLine:
      return "left goal line";
    case MarkingId::kRightGoalLine:
      return "right goal line";
    case MarkingId::kHalfwayLine:
      return "halfway line";
    case MarkingId::kCentreCircle:
      return "centre circle";
    case MarkingId::kCentreSpot:
      return "centre spot";
    case MarkingId::kLeftPenaltyFront:
      return "left penalty area front";
    case MarkingId::kLeftPenaltyNear:
      return "left penalty area near";
    case MarkingId::kLeftPenaltyFar:
      return "left penalty area far";
    case MarkingId::kLeftGoalAreaFront:
      return "left goal area front";
    case MarkingId::kLeftGoalAreaNear:
      return "left goal area near";
    case MarkingId::kLeftGoalAreaFar:
      return "left goal area far";
    case MarkingId::kLeftPenaltySpot:
      return "left penalty mark";
    case MarkingId::kLeftPenaltyArc:
      return "left penalty arc";
    case MarkingId::kRightPenaltyFront:
      return "right penalty area front";
    case MarkingId::kRightPenaltyNear:
      return "right penalty area near";
    case MarkingId::kRightPenaltyFar:
      return "right penalty area far";
    case MarkingId::kRightGoalAreaFront:
      return "right goal area front";
    case MarkingId::kRightGoalAreaNear:
      return "right goal area near";
    case MarkingId::kRightGoalAreaFar:
      return "right goal area far";
    case MarkingId::kRightPenaltySpot:
      return "right penalty mark";
    case MarkingId::kRightPenaltyArc:
      return "right penalty arc";
    case MarkingId::kLeftNearCorner:
      return "left near corner";
    case MarkingId::kLeftFarCorner:
      return "left far corner";
    case MarkingId::kRightNearCorner:
      return "right near corner";
    case MarkingId::kRightFarCorner:
      return "right far corner";
    case MarkingId::kLeftDeadBall:
      return "left dead-ball line";
    case MarkingId::kRightDeadBall:
      return "right dead-ball line";
    case MarkingId::kLeft22:
      return "left 22 m";
    case MarkingId::kRight22:
      return "right 22 m";
    case MarkingId::kLeft10:
      return "left 10 m";
    case MarkingId::kRight10:
      return "right 10 m";
    case MarkingId::kNear5:
      return "near 5 m";
    case MarkingId::kFar5:
      return "far 5 m";
    case MarkingId::kNear15:
      return "near 15 m";
    case MarkingId::kFar15:
      return "far 15 m";
    case MarkingId::kLeft5:
      return "left 5 m";
    case MarkingId::kRight5:
      return "right 5 m";
  }
  return "unknown marking";
}

double Marking::length() const {
  switch (shape) {
    case MarkingShape::kLine:
      return (end - start).norm();
    case MarkingShape::kArc:
      return radius * (end_angle - start_angle);
    case MarkingShape::kSpot:
      return 0;
  }
  return 0;
}

Eigen::Vector2d Marking::at(double distance) const {
  switch (shape) {
    case MarkingShape::kLine:
      return start + distance * tangent(distance);
    case MarkingShape::kArc: {
      const double angle = start_angle + distance / radius;
      return centre + radius * Eigen::Vector2d(std::cos(angle), std::sin(angle));
    }
    case MarkingShape::kSpot:
      return centre;
  }
  return centre;
}

Eigen::Vector2d Marking::tangent(double distance) const {
  switch (shape) {
    case MarkingShape::kLine:
      return (end - start).normalized();
    case MarkingShape::kArc: {
      const double angle = start_angle + distance / radius;
      return {-std::sin(angle), std::cos(angle)};
    }
    case MarkingShape::kSpot:
      return Eigen::Vector2d::UnitX();
  }
  return Eigen::Vector2d::UnitX();
}

double PitchModel::turf_z(double y) const {
  const double s = std::min(1.0, std::abs(y) / (width_m / 2));
  return -crown_m * s * s;
}

const Marking* PitchModel::find(MarkingId id) const {
  const auto found =
      std::find_if(markings.begin(), markings.end(), [&](const Marking& m) { return m.id == id; });
  return found == markings.end() ? nullptr : &*found;
}

base::Result<PitchModel> make_pitch(Sport sport, const PitchSizes& sizes) {
  // The laws' ranges with a metre of slack: grounds are measured with a tape.
  const bool soccer = sport == Sport::kSoccer;
  const auto length = checked("length_m", sizes.length_m, soccer ? 105 : 100,
                              soccer ? Bounds{89, 121} : Bounds{93, 101});
  if (!length) return base::fail(length.error());
  const auto width =
      checked("width_m", sizes.width_m, soccer ? 68 : 70, soccer ? Bounds{44, 91} : Bounds{66, 71});
  if (!width) return base::fail(width.error());
  const auto crown = checked("crown_m", sizes.crown_m, 0, {0, 1});
  if (!crown) return base::fail(crown.error());
  const auto line = checked("line_m", sizes.line_m, 0.12, {0.05, 0.2});
  if (!line) return base::fail(line.error());
  PitchModel model;
  model.sport = sport;
  model.length_m = *length;
  model.width_m = *width;
  model.crown_m = *crown;
  model.line_m = *line;
  if (soccer) {
    if (sizes.in_goal_m)
      return base::fail(base::ErrorKind::kConfiguration, "pitch.in_goal_m",
                        "a soccer pitch has no in-goal area", "remove the key");
    paint_soccer(model);
    return model;
  }
  const auto in_goal = checked("in_goal_m", sizes.in_goal_m, 10, {5.5, 22.5});
  if (!in_goal) return base::fail(in_goal.error());
  model.in_goal_m = *in_goal;
  model.goal_width_m = kRugbyPostGap;
  model.goal_height_m = kRugbyBarHeight - kPostDiameter;
  paint_rugby(model);
  return model;
}

std::vector<Bar> post_pads(const PitchModel& pitch) {
  std::vector<Bar> pads;
  if (pitch.sport != Sport::kRugbyUnion) return pads;
  for (const Bar& bar : pitch.bars)
    if (bar.end.z() - bar.start.z() > kRugbyBarHeight)
      pads.push_back({bar.start, bar.start + Eigen::Vector3d(0, 0, kPadHeight), kPadWidth});
  return pads;
}

std::optional<Eigen::Vector3d> intersect_turf(const PitchModel& pitch,
                                              const Eigen::Vector3d& origin,
                                              const Eigen::Vector3d& direction) {
  constexpr double kFarthest = 1000;  // metres
  constexpr double kEdge = 1e-9;      // metres; the two parts of the surface meet at the touchline
  const double norm = direction.norm();
  if (!(norm > 0) || !origin.allFinite() || !direction.allFinite()) return std::nullopt;
  const Eigen::Vector3d d = direction / norm;
  const double hw = pitch.width_m / 2;
  double best = kFarthest;
  bool hit = false;
  const auto consider = [&](double t, bool inside) {
    if (!(t >= 0) || t > best) return;
    const double y = std::abs(origin.y() + t * d.y());
    if (inside ? y > hw + kEdge : y < hw - kEdge) return;
    best = t;
    hit = true;
  };
  if (d.z() != 0) consider((-pitch.crown_m - origin.z()) / d.z(), pitch.crown_m == 0);
  if (pitch.crown_m == 0) {
    if (d.z() != 0) consider(-origin.z() / d.z(), false);
  } else {
    // z0 + t dz + q (y0 + t dy)^2 = 0 with q = crown / hw^2, solved without cancellation.
    const double q = pitch.crown_m / (hw * hw);
    const double a = q * d.y() * d.y();
    const double b = d.z() + 2 * q * origin.y() * d.y();
    const double c = origin.z() + q * origin.y() * origin.y();
    const double discriminant = b * b - 4 * a * c;
    if (discriminant >= 0) {
      const double s = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
      if (a > 0) consider(s / a, true);
      if (s != 0) consider(c / s, true);
    }
  }
  if (!hit) return std::nullopt;
  const Eigen::Vector3d point = origin + best * d;
  return Eigen::Vector3d(point.x(), point.y(), pitch.turf_z(point.y()));
}

}  // namespace touchline::pitch
