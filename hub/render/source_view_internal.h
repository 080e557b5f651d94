// A camera's view prepared for texturing: its tiles as one picture with clean foreground colours,
// what its matte says, and how the turf near people is shaded.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "hub/render/plate_texture_internal.h"
#include "hub/render/render_options.h"
#include "shared/base/ids.h"
#include "shared/codec/camera_view.h"
#include "shared/image/image.h"

namespace touchline::render {

class SourceView {
 public:
  // `plate` may be null. The view must not be lost and must have a matte of its camera's size.
  SourceView(const codec::CameraView& view, const Eigen::Vector3d& gain, const PlateTexture* plate,
             const RenderOptions& options);

  const base::CameraId& id() const { return id_; }
  const Eigen::Vector3d& position() const { return position_; }
  double focal_px() const { return model_.fx; }
  bool has_texture() const { return has_texture_; }
  const codec::CameraView& view() const { return *view_; }

  // Pixel of a world point; false outside the picture.
  bool project(const Eigen::Vector3d& point, float& x, float& y) const;

  // 0..1: how far the matte allows foreground here; unknown allows it. The point must be inside.
  float support(float x, float y) const { return bilinear(support_, x, y); }
  // The same at the wider tolerance.
  float loose_support(float x, float y) const { return bilinear(loose_support_, x, y); }
  // 0..1: coverage as the matte has it.
  float alpha(float x, float y) const { return bilinear(view_->matte->alpha, x, y); }

  // Foreground colour 0..255 and a weight 0..1 that fades towards the border of tile and picture;
  // weight 0 where no tile holds foreground.
  Sample foreground(float x, float y) const;

  // The weight of foreground() alone.
  float shown(float x, float y) const;

  // How dark the turf is against the plate (1 = as the plate), with a weight 0..1.
  struct Shade {
    float factor = 1;
    float weight = 0;
  };
  Shade shade(float x, float y) const;

 private:
  struct Texel {
    std::uint8_t r = 0, g = 0, b = 0, a = 0;
  };
  static constexpr int kShadeCell = 2;  // pixels

  static float bilinear(const image::Image<std::uint8_t>& plane, float x, float y);
  void place_tiles(const Eigen::Vector3d& gain, double feather_px);
  void clean_colours();
  void allow(double tolerance_px, image::Image<std::uint8_t>& support) const;
  void measure_shade(const PlateTexture& plate);

  const codec::CameraView* view_;
  base::CameraId id_;
  geometry::CameraModel model_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  Eigen::Vector3d position_;
  double fold_ = 0;
  bool has_texture_ = false;
  image::Image<std::uint8_t> support_;
  image::Image<std::uint8_t> loose_support_;
  image::Image<Texel> raw_;    // tiles as sent, gains applied; a fades towards tile borders
  image::Image<Texel> clean_;  // foreground colours without background in them; a = 0 elsewhere
  image::Image<std::uint8_t> shade_;         // factor times 255, one for a cell
  image::Image<std::uint8_t> shade_weight_;  // 0..255
};

}  // namespace touchline::render
