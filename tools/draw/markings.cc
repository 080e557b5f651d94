#include "tools/draw/markings.h"

#include <algorithm>
#include <cmath>

namespace touchline::draw {

void draw_markings(Picture& picture, const geometry::CameraEstimate& camera,
                   const pitch::PitchModel& pitch, image::Rgb8 colour, const image::Rect& window,
                   int zoom) {
  const auto in_window = [&](const Eigen::Vector2d& p) -> Eigen::Vector2d {
    return (p - Eigen::Vector2d(window.x, window.y) + Eigen::Vector2d(0.5, 0.5)) * zoom -
           Eigen::Vector2d(0.5, 0.5);
  };
  for (const pitch::Marking& marking : pitch.markings) {
    const double length = marking.length();
    const int steps = std::max(2, static_cast<int>(std::ceil(length / 0.25)));
    Eigen::Vector2d last = Eigen::Vector2d::Zero();
    bool joined = false;
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector3d point = pitch.on_turf(marking.at(length * i / steps));
      const auto pixel = geometry::project(camera, point);
      if (pixel && joined) draw_line(picture, in_window(last), in_window(*pixel), colour);
      joined = pixel.has_value();
      if (joined) last = *pixel;
    }
  }
}

}  // namespace touchline::draw
