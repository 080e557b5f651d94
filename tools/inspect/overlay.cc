#include "tools/inspect/overlay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/draw/markings.h"

namespace touchline::inspect {
namespace {

using namespace draw;  // NOLINT: this file draws

constexpr double kDegrees = 180 / 3.14159265358979323846;
constexpr image::Rgb8 kMarking{255, 60, 200};
constexpr image::Rgb8 kOccluder{255, 220, 40};
constexpr double kPlanScale = 10;  // pixels a metre
constexpr int kLetterPx = 10;      // of a label, about
constexpr double kRoom = 12;       // metres round everything that is shown

}  // namespace

Picture lines_overlay(Picture frame, const geometry::CameraEstimate& camera,
                      const pitch::PitchModel& pitch) {
  const image::Rect all{0, 0, frame.width(), frame.height()};
  if (camera.lost()) {
    draw_label(frame, 8, 8, "lost", kMissing);
    return frame;
  }
  draw_markings(frame, camera, pitch, kMarking, all, 1);
  const Eigen::Vector3d angles = geometry::pan_tilt_roll(camera.cam_from_world.rotation);
  const Eigen::Vector3d p = geometry::position_in_world(camera);
  draw_label(frame, 8, 8,
             fmt::format("{}: rms {:.2f} px, pan {:.3f} tilt {:.3f} roll {:.3f} deg, focal {:.0f} "
                         "px, at {:.2f} {:.2f} {:.2f} m",
                         geometry::name(camera.evidence), camera.rms_px, angles.x() * kDegrees,
                         angles.y() * kDegrees, angles.z() * kDegrees, camera.model.fx, p.x(),
                         p.y(), p.z()));
  return frame;
}

Picture key_overlay(const Picture& frame, const image::Matte& matte) {
  Picture out = subdued(frame, 0.15, 0.5);
  for (int y = 0; y < std::min(out.height(), matte.alpha.height()); ++y) {
    for (int x = 0; x < std::min(out.width(), matte.alpha.width()); ++x) {
      image::Rgb8& pixel = out(x, y);
      if (matte.occluders(x, y) != 0) {
        pixel = mix(pixel, kOccluder, 0.45);
      } else if (matte.unknown(x, y) != 0) {
        pixel = mix(pixel, kExtra, 0.45);
      }
      const double alpha = matte.alpha(x, y) / 255.0;
      if (alpha > 0) pixel = mix(pixel, frame(x, y), alpha);
    }
  }
  draw_outline(out, matte.alpha, kFound);
  draw_frame(out, matte.region, kWhite, 1);
  return out;
}

Picture site_plan(std::span<const PlacedHead> heads, const pitch::PitchModel& pitch) {
  double reach_x = pitch.length_m / 2 + pitch.in_goal_m, reach_y = pitch.width_m / 2;
  for (const PlacedHead& head : heads) {
    const Eigen::Vector3d& p = head.survey.mount.position_in_world;
    reach_x = std::max(reach_x, std::abs(p.x()));
    reach_y = std::max(reach_y, std::abs(p.y()));
  }
  reach_x += kRoom;
  reach_y += kRoom;
  Picture plan(static_cast<int>(2 * reach_x * kPlanScale),
               static_cast<int>(2 * reach_y * kPlanScale), image::Rgb8{38, 84, 44});
  // The main camera side is below.
  const auto at = [&](double x, double y) -> Eigen::Vector2d {
    return {(x + reach_x) * kPlanScale, (reach_y - y) * kPlanScale};
  };
  for (const pitch::Marking& marking : pitch.markings) {
    const int steps = std::max(2, static_cast<int>(std::ceil(marking.length() / 0.5)));
    for (int i = 0; i < steps; ++i) {
      const Eigen::Vector2d a = marking.at(marking.length() * i / steps);
      const Eigen::Vector2d b = marking.at(marking.length() * (i + 1) / steps);
      if (!marking.dashed || i % 2 == 0)
        draw_line(plan, at(a.x(), a.y()), at(b.x(), b.y()), kWhite, 2);
    }
  }
  for (const PlacedHead& head : heads) {
    const Eigen::Vector3d& p = head.survey.mount.position_in_world;
    for (const geometry::CameraEstimate& still : head.survey.stills) {
      if (still.lost()) continue;
      const double pan = geometry::pan_tilt_roll(still.cam_from_world.rotation).x();
      const double half = std::atan(0.5 * still.model.width / still.model.fx);
      for (const double angle : {pan - half, pan + half}) {
        draw_line(plan, at(p.x(), p.y()),
                  at(p.x() + 25 * std::sin(angle), p.y() + 25 * std::cos(angle)), {140, 170, 140});
      }
    }
    draw_dot(plan, at(p.x(), p.y()), 7, kFound);
  }
  for (const PlacedHead& head : heads) {
    const Eigen::Vector3d& p = head.survey.mount.position_in_world;
    const Eigen::Vector2d corner = at(p.x(), p.y()) + Eigen::Vector2d(10, 10);
    const std::string label =
        fmt::format("{}: {:.2f} {:.2f}, {:.2f} m up, {} of {} stills", head.camera.value, p.x(),
                    p.y(), p.z(), head.survey.solved, head.survey.stills.size());
    const int room = kLetterPx * static_cast<int>(label.size()) + 20;
    draw_label(plan, std::min(static_cast<int>(corner.x()), plan.width() - room),
               std::min(static_cast<int>(corner.y()), plan.height() - 30), label);
  }
  return plan;
}

}  // namespace touchline::inspect
