#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "hub/render/source_view_internal.h"

namespace touchline::render {
namespace {

std::uint8_t to_byte(double v) {
  return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0));
}

// A header without copy; OpenCV does not write through it.
cv::Mat borrow(const image::Image<std::uint8_t>& plane) {
  return cv::Mat(plane.height(), plane.width(), CV_8U, const_cast<std::uint8_t*>(plane.data()));
}

}  // namespace

SourceView::SourceView(const codec::CameraView& view, const Eigen::Vector3d& gain,
                       const PlateTexture* plate, const RenderOptions& options)
    : view_(&view),
      id_(view.id.camera),
      model_(view.estimate.model),
      rotation_(view.estimate.cam_from_world.rotation.toRotationMatrix()),
      translation_(view.estimate.cam_from_world.translation),
      position_(geometry::position_in_world(view.estimate)),
      fold_(std::min(model_.fold_radius_squared(), 1e12)) {
  allow(options.matte_tolerance_px, support_);
  allow(options.far_matte_tolerance_px, loose_support_);
  if (!view.tiles || view.tiles->empty()) return;
  has_texture_ = true;
  place_tiles(gain, options.border_feather_px);
  clean_colours();
  if (options.shadows && plate != nullptr && !plate->empty()) measure_shade(*plate);
}

bool SourceView::project(const Eigen::Vector3d& point, float& x, float& y) const {
  const Eigen::Vector3d p = rotation_ * point + translation_;
  if (!(p.z() > 1e-3)) return false;
  const double nx = p.x() / p.z();
  const double ny = p.y() / p.z();
  const double r2 = nx * nx + ny * ny;
  if (r2 >= fold_) return false;
  const double d = 1 + r2 * (model_.k1 + model_.k2 * r2);
  x = static_cast<float>(model_.fx * d * nx + model_.cx);
  y = static_cast<float>(model_.fy * d * ny + model_.cy);
  return x >= 0 && y >= 0 && x <= static_cast<float>(model_.width - 1) &&
         y <= static_cast<float>(model_.height - 1);
}

float SourceView::bilinear(const image::Image<std::uint8_t>& plane, float x, float y) {
  const int x0 = std::min(static_cast<int>(x), plane.width() - 2);
  const int y0 = std::min(static_cast<int>(y), plane.height() - 2);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const std::uint8_t* p = plane.row(y0) + x0;
  const std::uint8_t* q = p + plane.stride();
  return ((static_cast<float>(p[0]) * (1 - fx) + static_cast<float>(p[1]) * fx) * (1 - fy) +
          (static_cast<float>(q[0]) * (1 - fx) + static_cast<float>(q[1]) * fx) * fy) *
         (1.f / 255.f);
}

void SourceView::allow(double tolerance_px, image::Image<std::uint8_t>& plane) const {
  const image::Matte& matte = *view_->matte;
  plane = matte.alpha;
  cv::Mat support(plane.height(), plane.width(), CV_8U, plane.data());
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {3, 3});
  double left = tolerance_px;
  while (left > 1e-3) {
    cv::Mat wider;
    cv::dilate(support, wider, square);
    const double share = std::min(1.0, left);
    cv::addWeighted(support, 1 - share, wider, share, 0, support);
    left -= 1;
  }
  if (matte.unknown.size() == plane.size()) cv::max(support, borrow(matte.unknown), support);
  if (matte.occluders.size() == plane.size()) cv::max(support, borrow(matte.occluders), support);
}

void SourceView::place_tiles(const Eigen::Vector3d& gain, double feather_px) {
  raw_ = image::Image<Texel>(model_.width, model_.height);
  std::array<std::array<std::uint8_t, 256>, 3> table;
  for (std::size_t k = 0; k < 3; ++k) {
    for (int v = 0; v < 256; ++v) {
      table[k][static_cast<std::size_t>(v)] = to_byte(v * gain[static_cast<Eigen::Index>(k)]);
    }
  }
  const double step = 255 / std::max(feather_px, 1e-3);
  for (const codec::TextureTile& tile : *view_->tiles) {
    const int w = std::min(tile.place.width, tile.pixels.width());
    const int h = std::min(tile.place.height, tile.pixels.height());
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const int fx = tile.place.x + x;
        const int fy = tile.place.y + y;
        if (!raw_.contains(fx, fy)) continue;
        const int border = std::min(std::min(x, w - 1 - x), std::min(y, h - 1 - y));
        const auto a = static_cast<std::uint8_t>(std::clamp((border + 0.5) * step, 1.0, 255.0));
        Texel& t = raw_(fx, fy);
        if (t.a >= a) continue;
        const image::Rgb8& p = tile.pixels(x, y);
        t = {table[0][p.r], table[1][p.g], table[2][p.b], a};
      }
    }
  }
}

void SourceView::clean_colours() {
  // Mixed pixels take the colour of the most opaque foreground within two pixels.
  clean_ = image::Image<Texel>(model_.width, model_.height);
  const image::Image<std::uint8_t>& alpha = view_->matte->alpha;
  std::array<float, 256> opacity;
  for (int v = 0; v < 256; ++v) {
    const float a = static_cast<float>(v) / 255.f;
    opacity[static_cast<std::size_t>(v)] = v < 16 ? 0.f : a * a * a * a * a * a;
  }
  constexpr std::array<float, 3> kNear = {1.f, 0.6f, 0.2f};
  for (const codec::TextureTile& tile : *view_->tiles) {
    const int x0 = std::max(0, tile.place.x);
    const int y0 = std::max(0, tile.place.y);
    const int x1 = std::min(model_.width, tile.place.x + tile.place.width);
    const int y1 = std::min(model_.height, tile.place.y + tile.place.height);
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        Texel& out = clean_(x, y);
        const Texel& own = raw_(x, y);
        if (out.a != 0 || own.a == 0) continue;
        if (alpha(x, y) >= 250) {
          out = own;
          continue;
        }
        float r = 0, g = 0, b = 0, total = 0;
        for (int dy = -2; dy <= 2; ++dy) {
          for (int dx = -2; dx <= 2; ++dx) {
            if (!alpha.contains(x + dx, y + dy)) continue;
            const float o = opacity[alpha(x + dx, y + dy)];
            const Texel& t = raw_(x + dx, y + dy);
            if (o <= 0 || t.a == 0) continue;
            const float k = o * kNear[static_cast<std::size_t>(std::abs(dx))] *
                            kNear[static_cast<std::size_t>(std::abs(dy))];
            r += k * static_cast<float>(t.r);
            g += k * static_cast<float>(t.g);
            b += k * static_cast<float>(t.b);
            total += k;
          }
        }
        if (total <= 0) continue;
        out = {to_byte(r / total), to_byte(g / total), to_byte(b / total), own.a};
      }
    }
  }
}

void SourceView::measure_shade(const PlateTexture& plate) {
  const int w = (model_.width + kShadeCell - 1) / kShadeCell;
  const int h = (model_.height + kShadeCell - 1) / kShadeCell;
  shade_ = image::Image<std::uint8_t>(w, h, 255);
  shade_weight_ = image::Image<std::uint8_t>(w, h, 0);
  // People's outlines are mixed with what lies behind them, a little beyond the matte too.
  image::Image<std::uint8_t> near_people(model_.width, model_.height);
  cv::Mat wide(model_.height, model_.width, CV_8U, near_people.data());
  cv::dilate(borrow(view_->matte->alpha), wide, cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
  const double texels = 1 / (model_.fx * plate.radians_per_px());
  const auto span = static_cast<float>(kShadeCell * texels);
  for (int cy = 0; cy < h; ++cy) {
    for (int cx = 0; cx < w; ++cx) {
      double light = 0;
      int n = 0;
      int fade = 255;
      for (int y = cy * kShadeCell; y < std::min(model_.height, (cy + 1) * kShadeCell); ++y) {
        for (int x = cx * kShadeCell; x < std::min(model_.width, (cx + 1) * kShadeCell); ++x) {
          const Texel& t = raw_(x, y);
          if (t.a == 0) continue;
          if (near_people(x, y) > 8 || support_(x, y) > 200) continue;
          light += 0.2126 * t.r + 0.7152 * t.g + 0.0722 * t.b;
          fade = std::min(fade, static_cast<int>(t.a));
          ++n;
        }
      }
      if (n < 2) continue;
      const Eigen::Vector3d ray = model_.unproject(
          {cx * kShadeCell + (kShadeCell - 1) / 2.0, cy * kShadeCell + (kShadeCell - 1) / 2.0});
      const Eigen::Vector2f p = plate.position(rotation_.transpose() * ray);
      if (plate.border_distance(p.x(), p.y()) <= 0) continue;
      const Sample s = plate.sample(p.x(), p.y(), {span, 0}, {0, span});
      if (s.weight <= 0) continue;
      const double known = 0.2126 * s.colour[0] + 0.7152 * s.colour[1] + 0.0722 * s.colour[2];
      if (known < 8) continue;
      shade_(cx, cy) = to_byte(255 * std::min(1.0, light / n / known));
      shade_weight_(cx, cy) = static_cast<std::uint8_t>(fade * n / (kShadeCell * kShadeCell));
    }
  }
}

Sample SourceView::foreground(float x, float y) const {
  Sample out;
  const int x0 = std::min(static_cast<int>(x), clean_.width() - 2);
  const int y0 = std::min(static_cast<int>(y), clean_.height() - 2);
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const float w[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  const Texel* t = clean_.row(y0) + x0;
  const Texel* p[4] = {t, t + 1, t + clean_.stride(), t + clean_.stride() + 1};
  float total = 0;
  float fade = 0;
  for (int k = 0; k < 4; ++k) {
    if (p[k]->a == 0) continue;
    out.colour += w[k] * Eigen::Vector3f(p[k]->r, p[k]->g, p[k]->b);
    fade += w[k] * static_cast<float>(p[k]->a);
    total += w[k];
  }
  if (total <= 1e-3f) return {};
  out.colour /= total;
  out.weight = fade / 255.f;
  return out;
}

float SourceView::shown(float x, float y) const {
  const Texel& nearest = clean_(static_cast<int>(x + 0.5f), static_cast<int>(y + 0.5f));
  return nearest.a == 0 ? foreground(x, y).weight : static_cast<float>(nearest.a) / 255.f;
}

SourceView::Shade SourceView::shade(float x, float y) const {
  Shade out;
  if (shade_.empty()) return out;
  const float sx = std::clamp((x - (kShadeCell - 1) / 2.f) / kShadeCell, 0.f,
                              static_cast<float>(shade_.width() - 1));
  const float sy = std::clamp((y - (kShadeCell - 1) / 2.f) / kShadeCell, 0.f,
                              static_cast<float>(shade_.height() - 1));
  const int x0 = std::min(static_cast<int>(sx), shade_.width() - 2);
  const int y0 = std::min(static_cast<int>(sy), shade_.height() - 2);
  const float fx = sx - static_cast<float>(x0);
  const float fy = sy - static_cast<float>(y0);
  float factor = 0;
  for (int dy = 0; dy < 2; ++dy) {
    for (int dx = 0; dx < 2; ++dx) {
      const float k = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy) *
                      static_cast<float>(shade_weight_(x0 + dx, y0 + dy)) / 255.f;
      factor += k * static_cast<float>(shade_(x0 + dx, y0 + dy)) / 255.f;
      out.weight += k;
    }
  }
  if (out.weight > 0) out.factor = factor / out.weight;
  return out;
}

}  // namespace touchline::render
