// Pictures to look at: the pitch as a camera sees it, and marks, drawn over a frame.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "shared/base/result.h"
#include "shared/geometry/camera_estimate.h"
#include "shared/image/frame.h"
#include "shared/pitch/pitch_model.h"

namespace touchline::score {

using Colour = std::array<std::uint8_t, 3>;  // R, G, B

class Overlay {
 public:
  // An empty picture, or a frame's.
  Overlay(int width, int height);
  explicit Overlay(const image::Frame& frame);
  Overlay(Overlay&&) noexcept;
  Overlay& operator=(Overlay&&) noexcept;
  ~Overlay();

  // Every marking and the goal frames, one pixel wide.
  void draw_pitch(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                  Colour colour);
  void draw_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour, int width);
  void draw_box(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Colour colour);
  void draw_dot(const Eigen::Vector2d& at, Colour colour, int radius);
  void draw_text(const Eigen::Vector2d& at, const std::string& text, Colour colour);
  // Mixes `colour` in where a matte of the picture's size is set.
  void draw_matte(image::ImageView<const std::uint8_t> matte, Colour colour);

  // PNG, at most 1600 pixels wide; makes the folder.
  base::Status write(const std::filesystem::path& path) const;

 private:
  struct Picture;
  std::unique_ptr<Picture> picture_;
};

}  // namespace touchline::score
