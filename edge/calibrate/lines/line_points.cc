#include "edge/calibrate/lines/line_points.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "edge/calibrate/lines/line_profile_internal.h"
#include "shared/base/bounds.h"

namespace touchline::calibrate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using pitch::Marking;
using pitch::MarkingShape;

constexpr double kBendStep = 0.02;      // metres along an arc, to see it turn
constexpr double kMostBend = 0.06;      // radians that an arc may turn by within its own width
constexpr double kCoarseStep = 1.0;     // metres between projected nodes of a marking
constexpr double kLongestRun = 1e5;     // pixels between nodes; beyond, only the ends are looked at
constexpr double kJunctionSlack = 0.3;  // metres that two markings may miss each other and meet
constexpr double kClearance = 3.0;      // pixels at 1080 lines between a window and another marking

// Where another marking crosses or touches a marking.
struct Junction {
  double distance;   // along the marking
  Vector2d tangent;  // of the other
  double width;      // of the other
};

void meet_line_line(const Marking& a, const Marking& b, std::vector<Junction>& out) {
  const Vector2d ta = a.tangent(0);
  const Vector2d tb = b.tangent(0);
  const double cross = ta.x() * tb.y() - ta.y() * tb.x();
  if (std::abs(cross) < 1e-6) return;
  const Vector2d d = b.start - a.start;
  const double s = (d.x() * tb.y() - d.y() * tb.x()) / cross;
  const double t = (d.x() * ta.y() - d.y() * ta.x()) / cross;
  if (s < -kJunctionSlack || s > a.length() + kJunctionSlack || t < -kJunctionSlack ||
      t > b.length() + kJunctionSlack)
    return;
  out.push_back({s, tb, b.width});
}

// Calls visit(distance on line, distance on arc) where the line meets the arc.
template <typename Visit>
void meet_line_arc(const Marking& line, const Marking& arc, Visit visit) {
  const Vector2d t = line.tangent(0);
  const Vector2d d = line.start - arc.centre;
  const double b = d.dot(t);
  const double discriminant = b * b - d.squaredNorm() + arc.radius * arc.radius;
  if (discriminant <= 0) return;
  for (const double sign : {-1.0, 1.0}) {
    const double s = -b + sign * std::sqrt(discriminant);
    if (s < -kJunctionSlack || s > line.length() + kJunctionSlack) continue;
    const Vector2d p = line.start + s * t - arc.centre;
    double angle = std::atan2(p.y(), p.x());
    const double slack = kJunctionSlack / arc.radius;
    while (angle < arc.start_angle - slack) angle += 2 * M_PI;
    if (angle > arc.end_angle + slack) continue;
    visit(s, (angle - arc.start_angle) * arc.radius);
  }
}

std::vector<Junction> junctions(const pitch::PitchModel& pitch, const Marking& marking) {
  std::vector<Junction> out;
  const bool line = marking.shape == MarkingShape::kLine;
  for (const Marking& other : pitch.markings) {
    if (&other == &marking || other.shape == MarkingShape::kSpot) continue;
    const bool other_line = other.shape == MarkingShape::kLine;
    if (line && other_line) {
      meet_line_line(marking, other, out);
    } else if (line) {
      meet_line_arc(marking, other, [&](double s, double on_arc) {
        out.push_back({s, other.tangent(on_arc), other.width});
      });
    } else if (other_line) {
      meet_line_arc(other, marking, [&](double, double on_arc) {
        out.push_back({on_arc, other.tangent(0), other.width});
      });
    }
  }
  return out;
}

// The picture round one point of the turf.
struct Local {
  Vector2d pixel;
  Eigen::Matrix<double, 2, 3> pixel_by_cam;  // derivative by the point in camera axes
  Eigen::Matrix2d pixel_by_turf;             // derivative by (x, y) on the turf
  Vector3d point_in_cam;
};

std::optional<Local> look(const pitch::PitchModel& pitch, const geometry::CameraEstimate& camera,
                          const Eigen::Matrix3d& rotation, double fold, const Vector2d& p) {
  Local local;
  local.point_in_cam = rotation * pitch.on_turf(p) + camera.cam_from_world.translation;
  const double z = local.point_in_cam.z();
  if (!(z > 0.1)) return std::nullopt;
  const geometry::CameraModel& m = camera.model;
  const double x = local.point_in_cam.x() / z;
  const double y = local.point_in_cam.y() / z;
  const double r2 = x * x + y * y;
  if (r2 >= fold) return std::nullopt;
  const double d = 1 + r2 * (m.k1 + m.k2 * r2);
  const double e = 2 * (m.k1 + 2 * m.k2 * r2);  // derivative of d by r^2, times 2
  local.pixel = {m.fx * d * x + m.cx, m.fy * d * y + m.cy};
  Eigen::Matrix2d by_plane;
  by_plane << m.fx * (d + e * x * x), m.fx * e * x * y, m.fy * e * x * y, m.fy * (d + e * y * y);
  Eigen::Matrix<double, 2, 3> plane_by_cam;
  plane_by_cam << 1 / z, 0, -x / z, 0, 1 / z, -y / z;
  local.pixel_by_cam = by_plane * plane_by_cam;
  const double hw = pitch.width_m / 2;
  const double slope = std::abs(p.y()) < hw ? -2 * pitch.crown_m * p.y() / (hw * hw) : 0.0;
  local.pixel_by_turf.col(0) = local.pixel_by_cam * rotation.col(0);
  local.pixel_by_turf.col(1) = local.pixel_by_cam * (rotation.col(1) + slope * rotation.col(2));
  return local;
}

// Sets windows across the markings that the prediction sees.
class WindowPlacer {
 public:
  WindowPlacer(const image::Frame& frame, const pitch::PitchModel& pitch,
               const geometry::CameraEstimate& predicted, const LinePointOptions& options)
      : pitch_(pitch),
        camera_(predicted),
        options_(options),
        width_(frame.width()),
        height_(frame.height()),
        scale_(frame.height() / 1080.0),
        rotation_(predicted.cam_from_world.rotation.toRotationMatrix()),
        fold_(0.98 * predicted.model.fold_radius_squared()),
        spread_(predicted.covariance.topLeftCorner<4, 4>()) {}

  std::vector<LinePoint> place(double step_px) const {
    std::vector<LinePoint> windows;
    for (const Marking& marking : pitch_.markings)
      if (marking.shape != MarkingShape::kSpot) place_along(marking, step_px, windows);
    return windows;
  }

 private:
  bool in_picture(const Vector2d& p, double margin) const {
    return p.x() > margin && p.y() > margin && p.x() < width_ - 1 - margin &&
           p.y() < height_ - 1 - margin;
  }

  void place_along(const Marking& marking, double step_px, std::vector<LinePoint>& out) const {
    const double length = marking.length();
    const int pieces = std::max(2, static_cast<int>(std::ceil(length / kCoarseStep)));
    std::vector<Junction> meets;
    bool have_meets = false;
    std::optional<Local> last;
    double carry = step_px / 2;  // pixels until the next window
    for (int i = 0; i <= pieces; ++i) {
      const double s1 = length * i / pieces;
      const auto here = look(pitch_, camera_, rotation_, fold_, marking.at(s1));
      if (i > 0 && last && here) {
        const double s0 = length * (i - 1) / pieces;
        const double run = std::min((here->pixel - last->pixel).norm(), kLongestRun);
        // A metre that lies outside at both ends by more than its own length cannot be inside.
        if (in_picture(last->pixel, -run) || in_picture(here->pixel, -run)) {
          if (!have_meets) meets = junctions(pitch_, marking);
          have_meets = true;
          while (carry < run) {
            add_window(marking, s0 + (s1 - s0) * carry / run, step_px, meets, out);
            carry += step_px;
          }
        } else if (carry < run) {
          carry += step_px * std::ceil((run - carry) / step_px);
        }
        carry -= run;
      }
      last = here;
    }
  }

  void add_window(const Marking& marking, double s, double step_px,
                  const std::vector<Junction>& meets, std::vector<LinePoint>& out) const {
    const Vector2d on_pitch = marking.at(s);
    const auto local = look(pitch_, camera_, rotation_, fold_, on_pitch);
    if (!local || !in_picture(local->pixel, 2)) return;
    const Vector2d t = marking.tangent(s);
    const Vector2d along = local->pixel_by_turf * t;
    const double px_per_m = along.norm();
    if (px_per_m < 1e-6) return;
    const Vector2d normal = Vector2d(along.y(), -along.x()) / px_per_m;
    const double width =
        marking.width * std::abs(normal.dot(local->pixel_by_turf * Vector2d(-t.y(), t.x())));
    if (width < options_.least_width_px * scale_ || width > options_.most_width_px * scale_) return;
    if (marking.shape == MarkingShape::kArc && bends(marking, s, width, *local)) return;
    const double from_end = std::min(s, marking.length() - s) * px_per_m;
    const bool closed = marking.shape == MarkingShape::kArc &&
                        marking.end_angle - marking.start_angle > 2 * M_PI - 1e-9;
    if (!closed && from_end < width / 2 + kClearance * scale_) return;
    for (const Junction& meet : meets)
      if (spoils(meet, std::abs(s - meet.distance) * px_per_m, normal, width, *local)) return;
    LinePoint window;
    window.marking = marking.id;
    window.point_in_world = pitch_.on_turf(on_pitch);
    window.share = s / marking.length();
    window.predicted = local->pixel;
    window.normal = normal;
    window.width_px = width;
    window.length_px = step_px;
    window.search_px = search(*local, normal);
    out.push_back(window);
  }

  // True where an arc turns so sharply in the picture that paint `width` wide shows no straight
  // profile: the tip of a circle seen from near the turf.
  bool bends(const Marking& marking, double s, double width, const Local& local) const {
    const Vector2d before = local.pixel_by_turf * marking.tangent(s);
    const auto next = look(pitch_, camera_, rotation_, fold_, marking.at(s + kBendStep));
    if (!next) return true;
    const Vector2d after = next->pixel_by_turf * marking.tangent(s + kBendStep);
    const double turn =
        std::abs(std::atan2(before.x() * after.y() - before.y() * after.x(), before.dot(after)));
    return turn * width > kMostBend * (next->pixel - local.pixel).norm();
  }

  // True where a marking that meets this one `distance_px` away is too near for a clean profile.
  bool spoils(const Junction& meet, double distance_px, const Vector2d& normal, double width,
              const Local& local) const {
    if (distance_px > 60 * scale_ + 8 * width) return false;
    const Vector2d across(-meet.tangent.y(), meet.tangent.x());
    const Vector2d direction = (local.pixel_by_turf * meet.tangent).normalized();
    const Vector2d other_normal(direction.y(), -direction.x());
    const double sine = std::abs(normal.dot(direction));
    const double other_width =
        meet.width * std::abs(other_normal.dot(local.pixel_by_turf * across));
    const double cosine = std::sqrt(std::max(0.0, 1 - sine * sine));
    return distance_px * sine < (other_width + width * cosine) / 2 + kClearance * scale_;
  }

  // Half width of a window: the sigma of the prediction across the line decides, within bounds.
  double search(const Local& local, const Vector2d& normal) const {
    const double least = options_.search_px * scale_;
    if (!(spread_.trace() > 0)) return least;
    const Vector3d& p = local.point_in_cam;
    const Vector3d up = rotation_.col(2);
    Eigen::Vector4d gradient;
    const Eigen::RowVector3d by_cam = normal.transpose() * local.pixel_by_cam;
    gradient(0) = by_cam * up.cross(p);
    gradient(1) = by_cam * Vector3d(0, p.z(), -p.y());
    gradient(2) = by_cam * Vector3d(p.y(), -p.x(), 0);
    gradient(3) = normal.dot(local.pixel - Vector2d(camera_.model.cx, camera_.model.cy));
    const double variance = gradient.dot(spread_ * gradient);
    const double sigmas = options_.search_sigmas * std::sqrt(std::max(0.0, variance));
    return std::max(least, std::min(sigmas, options_.most_search_px * scale_));
  }

  const pitch::PitchModel& pitch_;
  const geometry::CameraEstimate& camera_;
  const LinePointOptions& options_;
  int width_;
  int height_;
  double scale_;
  Eigen::Matrix3d rotation_;
  double fold_;
  Eigen::Matrix4d spread_;
};

}  // namespace

base::Status LinePointOptions::validate() const {
  if (!(step_px >= 1)) return base::out_of_bounds("step_px", step_px, "at least 1");
  if (most_windows < 10) return base::out_of_bounds("most_windows", most_windows, "at least 10");
  if (!(search_px >= 1)) return base::out_of_bounds("search_px", search_px, "at least 1");
  if (!(search_sigmas >= 0))
    return base::out_of_bounds("search_sigmas", search_sigmas, "at least 0");
  if (!(most_search_px >= search_px))
    return base::out_of_bounds("most_search_px", most_search_px, "at least search_px");
  if (!(blur_px > 0.1 && blur_px < 5))
    return base::out_of_bounds("blur_px", blur_px, "between 0.1 and 5");
  if (!(least_width_px > 0))
    return base::out_of_bounds("least_width_px", least_width_px, "above 0");
  if (!(most_width_px > least_width_px))
    return base::out_of_bounds("most_width_px", most_width_px, "above least_width_px");
  if (!(least_contrast > 0))
    return base::out_of_bounds("least_contrast", least_contrast, "above 0");
  if (!(noise_factor >= 0)) return base::out_of_bounds("noise_factor", noise_factor, "at least 0");
  if (!(least_match >= 0 && least_match < 1))
    return base::out_of_bounds("least_match", least_match, "in [0, 1)");
  if (!(sigma_floor_px > 0))
    return base::out_of_bounds("sigma_floor_px", sigma_floor_px, "above 0");
  return {};
}

std::vector<LinePoint> measure_lines(const image::Frame& frame, const pitch::PitchModel& pitch,
                                     const geometry::CameraEstimate& predicted,
                                     const LinePointOptions& options) {
  if (frame.width() < 16 || frame.height() < 16) return {};
  const WindowPlacer placer(frame, pitch, predicted, options);
  const double step = options.step_px * frame.height() / 1080.0;
  std::vector<LinePoint> windows = placer.place(step);
  const auto most = static_cast<std::size_t>(options.most_windows);
  if (windows.size() > most)
    windows = placer.place(step * static_cast<double>(windows.size()) / static_cast<double>(most));
  ProfileReader reader(frame, options);
  std::size_t kept = 0;
  for (LinePoint& window : windows) {
    if (!reader.measure(window)) continue;
    // Nobody says where the dashes are.
    if (window.state == WindowState::kBare && pitch.find(window.marking)->dashed)
      window.state = WindowState::kFaint;
    if (kept != static_cast<std::size_t>(&window - windows.data())) windows[kept] = window;
    ++kept;
  }
  windows.resize(kept);
  return windows;
}

}  // namespace touchline::calibrate
