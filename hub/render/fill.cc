#include <algorithm>
#include <cmath>
#include <vector>

#include "hub/render/fill_internal.h"

namespace touchline::render {
namespace {

constexpr int kFillLevels = 6;

struct Level {
  image::Image<Eigen::Vector3f> colour;
  image::Image<float> weight;
};

Eigen::Vector3f linear(const image::Image<Eigen::Vector3f>& picture, double x, double y) {
  const double cx = std::clamp(x, 0.0, static_cast<double>(picture.width() - 1));
  const double cy = std::clamp(y, 0.0, static_cast<double>(picture.height() - 1));
  const int x0 = static_cast<int>(cx);
  const int y0 = static_cast<int>(cy);
  const int x1 = std::min(x0 + 1, picture.width() - 1);
  const int y1 = std::min(y0 + 1, picture.height() - 1);
  const auto fx = static_cast<float>(cx - x0);
  const auto fy = static_cast<float>(cy - y0);
  return (1 - fy) * ((1 - fx) * picture(x0, y0) + fx * picture(x1, y0)) +
         fy * ((1 - fx) * picture(x0, y1) + fx * picture(x1, y1));
}

}  // namespace

void fill_smoothly(image::Image<Eigen::Vector3f>& colour, const image::Image<float>& weight,
                   const std::function<Eigen::Vector3f(double x, double y)>& otherwise) {
  if (colour.empty()) return;
  std::vector<Level> levels(kFillLevels);
  const image::Image<Eigen::Vector3f>* fine = &colour;
  const image::Image<float>* fine_weight = &weight;
  for (Level& level : levels) {
    const int w = (fine->width() + 1) / 2;
    const int h = (fine->height() + 1) / 2;
    level.colour = image::Image<Eigen::Vector3f>(w, h, Eigen::Vector3f::Zero());
    level.weight = image::Image<float>(w, h, 0.f);
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        float total = 0;
        for (int dy = 0; dy < 2; ++dy) {
          for (int dx = 0; dx < 2; ++dx) {
            if (!fine->contains(2 * x + dx, 2 * y + dy)) continue;
            const float k = (*fine_weight)(2 * x + dx, 2 * y + dy);
            sum += k * (*fine)(2 * x + dx, 2 * y + dy);
            total += k;
          }
        }
        if (total > 0) level.colour(x, y) = sum / total;
        level.weight(x, y) = std::min(1.f, total);
      }
    }
    fine = &level.colour;
    fine_weight = &level.weight;
  }
  for (int l = kFillLevels - 1; l >= -1; --l) {
    image::Image<Eigen::Vector3f>& target =
        l < 0 ? colour : levels[static_cast<std::size_t>(l)].colour;
    const image::Image<float>& known = l < 0 ? weight : levels[static_cast<std::size_t>(l)].weight;
    for (int y = 0; y < target.height(); ++y) {
      for (int x = 0; x < target.width(); ++x) {
        const float k = known(x, y);
        if (k >= 0.999f) continue;
        Eigen::Vector3f other;
        if (l == kFillLevels - 1) {
          const double scale = 1 << (l + 1);
          other = otherwise((x + 0.5) * scale - 0.5, (y + 0.5) * scale - 0.5);
        } else {
          other = linear(levels[static_cast<std::size_t>(l + 1)].colour, (x + 0.5) / 2 - 0.5,
                         (y + 0.5) / 2 - 0.5);
        }
        target(x, y) = k * target(x, y) + (1 - k) * other;
      }
    }
  }
}

}  // namespace touchline::render
