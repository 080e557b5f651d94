#include "edge/compensate/burnt_in.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "shared/base/bounds.h"
#include "shared/image/no_picture.h"

namespace touchline::compensate {
namespace {

using Mask = image::Image<std::uint8_t>;

constexpr int kLines = 540;             // about so many rows are looked at
constexpr double kAlike = 0.5;          // of an edge that two pictures may differ by
constexpr int kLeastEdges = 12;         // pixels of a graphic's edges, upright and level each
constexpr int kLeastArea = 120;         // pixels of a graphic
constexpr double kMostOfPicture = 0.2;  // share of the picture that graphics may take

struct Slopes {
  image::Image<float> x;
  image::Image<float> y;
};

// Means over squares of `step` pixels.
image::Image<float> reduced(image::ImageView<const std::uint16_t> luma, int step) {
  image::Image<float> out(luma.width / step, luma.height / step);
  const float scale = 1.0F / static_cast<float>(step * step);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      int sum = 0;
      for (int v = 0; v < step; ++v)
        for (int u = 0; u < step; ++u) sum += luma(x * step + u, y * step + v);
      out(x, y) = scale * static_cast<float>(sum);
    }
  }
  return out;
}

Slopes slopes_of(const image::Image<float>& picture) {
  Slopes out{image::Image<float>(picture.width(), picture.height()),
             image::Image<float>(picture.width(), picture.height())};
  for (int y = 1; y + 1 < picture.height(); ++y) {
    for (int x = 1; x + 1 < picture.width(); ++x) {
      out.x(x, y) = 0.5F * (picture(x + 1, y) - picture(x - 1, y));
      out.y(x, y) = 0.5F * (picture(x, y + 1) - picture(x, y - 1));
    }
  }
  return out;
}

// The middle value of each pixel's slopes over the pictures.
image::Image<float> middle_of(const std::vector<Slopes>& all, image::Image<float> Slopes::*axis) {
  image::Image<float> out((all[0].*axis).width(), (all[0].*axis).height());
  std::vector<float> values(all.size());
  const auto half = static_cast<std::ptrdiff_t>(all.size() / 2);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      for (std::size_t i = 0; i < all.size(); ++i) values[i] = (all[i].*axis)(x, y);
      std::nth_element(values.begin(), values.begin() + half, values.end());
      out(x, y) = values[static_cast<std::size_t>(half)];
    }
  }
  return out;
}

// Each pixel the greatest (or least) of those within `reach`, along rows, then along columns.
Mask spread_mask(const Mask& in, int reach, bool grow) {
  const auto along = [&](const Mask& from, int dx, int dy) {
    Mask out(from.width(), from.height());
    for (int y = 0; y < from.height(); ++y) {
      for (int x = 0; x < from.width(); ++x) {
        std::uint8_t value = from(x, y);
        for (int k = -reach; k <= reach; ++k) {
          const int u = std::clamp(x + k * dx, 0, from.width() - 1);
          const int v = std::clamp(y + k * dy, 0, from.height() - 1);
          value = grow ? std::max(value, from(u, v)) : std::min(value, from(u, v));
        }
        out(x, y) = value;
      }
    }
    return out;
  };
  return along(along(in, 1, 0), 0, 1);
}

// Pixels that hang together with (x, y) in `mask`; taken out of it.
std::vector<std::pair<int, int>> take_piece(Mask& mask, int x, int y) {
  std::vector<std::pair<int, int>> piece{{x, y}};
  mask(x, y) = 0;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const auto [px, py] = piece[i];
    for (int k = 0; k < 4; ++k) {
      const int u = px + (k == 0) - (k == 1);
      const int v = py + (k == 2) - (k == 3);
      if (!mask.contains(u, v) || mask(u, v) == 0) continue;
      mask(u, v) = 0;
      piece.emplace_back(u, v);
    }
  }
  return piece;
}

}  // namespace

base::Status BurntInOptions::validate() const {
  for (const base::Status& status : {base::in_bounds("least_pictures", least_pictures, 4, 1000),
                                     base::in_bounds("least_edge", least_edge, 1, 500),
                                     base::in_bounds("least_share", least_share, 0.5, 1),
                                     base::in_bounds("most_standing", most_standing, 0, 1),
                                     base::in_bounds("join_px", join_px, 0, 200),
                                     base::in_bounds("margin_px", margin_px, 0, 200)})
    if (!status) return status;
  return {};
}

BurntIn find_burnt_in(std::span<const image::FramePtr> pictures, const BurntInOptions& options) {
  if (static_cast<int>(pictures.size()) < options.least_pictures) return {};
  const int width = pictures[0]->width();
  const int height = pictures[0]->height();
  const int step = std::max(1, static_cast<int>(std::lround(static_cast<double>(height) / kLines)));
  if (width < 8 * step || height < 8 * step) return {};
  std::vector<Slopes> all;
  for (const image::FramePtr& picture : pictures) {
    if (picture->width() != width || picture->height() != height) return {};
    all.push_back(slopes_of(reduced(picture->luma(), step)));
  }
  const image::Image<float> mx = middle_of(all, &Slopes::x);
  const image::Image<float> my = middle_of(all, &Slopes::y);
  const auto least = static_cast<float>(options.least_edge);
  const auto needed = static_cast<float>(options.least_share) * static_cast<float>(all.size());
  Mask edges(mx.width(), mx.height());
  std::size_t standing = 0;
  std::size_t seen = 0;
  for (int y = 0; y < edges.height(); ++y) {
    for (int x = 0; x < edges.width(); ++x) {
      const float strength = std::hypot(mx(x, y), my(x, y));
      float alike = 0;
      for (const Slopes& slopes : all) {
        const float sx = slopes.x(x, y);
        const float sy = slopes.y(x, y);
        seen += std::hypot(sx, sy) >= least ? 1U : 0U;
        if (std::hypot(sx - mx(x, y), sy - my(x, y)) <= static_cast<float>(kAlike) * strength)
          ++alike;
      }
      if (strength < least || alike < needed) continue;
      edges(x, y) = std::abs(mx(x, y)) > std::abs(my(x, y)) ? 1 : 2;
      ++standing;
    }
  }
  const double in_a_picture = static_cast<double>(seen) / static_cast<double>(all.size());
  if (standing == 0 || static_cast<double>(standing) > options.most_standing * in_a_picture)
    return {};

  const double pixels = height / 1080.0 / step;  // of the reduced picture, a pixel at 1080 lines
  const int join = std::max(1, static_cast<int>(std::lround(0.5 * options.join_px * pixels)));
  const int margin = std::max(1, static_cast<int>(std::lround(options.margin_px * pixels)));
  Mask pieces = spread_mask(spread_mask(edges, join, true), join, false);
  Mask graphics(edges.width(), edges.height());
  std::size_t area = 0;
  for (int y = 0; y < pieces.height(); ++y) {
    for (int x = 0; x < pieces.width(); ++x) {
      if (pieces(x, y) == 0) continue;
      const auto piece = take_piece(pieces, x, y);
      int upright = 0;
      int level = 0;
      for (const auto& [u, v] : piece) {
        upright += edges(u, v) == 1 ? 1 : 0;
        level += edges(u, v) == 2 ? 1 : 0;
      }
      // A hoarding's edge stands as well while a head only pans, but has no other edges.
      if (static_cast<int>(piece.size()) < kLeastArea || upright < kLeastEdges ||
          level < kLeastEdges)
        continue;
      // Whole between its outermost edges, row by row.
      std::vector<std::pair<int, int>> rows(static_cast<std::size_t>(edges.height()), {1, 0});
      for (const auto& [u, v] : piece) {
        auto& [from, to] = rows[static_cast<std::size_t>(v)];
        if (from > to) from = to = u;
        from = std::min(from, u);
        to = std::max(to, u);
      }
      for (int v = 0; v < edges.height(); ++v) {
        const auto& [from, to] = rows[static_cast<std::size_t>(v)];
        for (int u = from; u <= to; ++u) {
          area += graphics(u, v) == 0 ? 1U : 0U;
          graphics(u, v) = 255;
        }
      }
    }
  }
  if (area == 0 || static_cast<double>(area) > kMostOfPicture * static_cast<double>(edges.size()))
    return {};
  graphics = spread_mask(graphics, margin, true);
  BurntIn out{Mask(width, height), {}};
  int left = width, top = height, right = -1, bottom = -1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int u = std::min(x / step, graphics.width() - 1);
      const int v = std::min(y / step, graphics.height() - 1);
      if (graphics(u, v) == 0) continue;
      out.mask(x, y) = 255;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = std::max(bottom, y);
    }
  }
  out.bounds = {left, top, right - left + 1, bottom - top + 1};
  return out;
}

void blank(const BurntIn& graphics, image::Frame& frame) {
  const Mask& mask = graphics.mask;
  if (mask.width() != frame.width() || mask.height() != frame.height()) return;
  const image::Rect& box = graphics.bounds;
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (int y = box.y; y < box.y + box.height; ++y) {
    std::uint16_t* luma = frame.planes[0].row(y);
    for (int x = box.x; x < box.x + box.width;) {
      if (mask(x, y) == 0) {
        ++x;
        continue;
      }
      int end = x;
      while (end < mask.width() && mask(end, y) != 0) ++end;
      const int before = x > 0 ? luma[x - 1] : end < mask.width() ? luma[end] : 512;
      const int after = end < mask.width() ? luma[end] : before;
      for (int k = x; k < end; ++k) {
        luma[k] =
            static_cast<std::uint16_t>(before + (after - before) * (k - x + 1) / (end - x + 1));
        for (const std::size_t plane : {std::size_t{1}, std::size_t{2}}) {
          image::Image<std::uint16_t>& chroma = frame.planes[plane];
          const int u = std::min(k >> shift.x, chroma.width() - 1);
          const int v = std::min(y >> shift.y, chroma.height() - 1);
          chroma(u, v) = image::kNoPictureChroma;
        }
      }
      x = end;
    }
  }
}

void keep_off(const BurntIn& graphics, image::Matte& matte) {
  const image::Rect& box = graphics.bounds;
  if (graphics.empty() || matte.alpha.width() != graphics.mask.width() ||
      matte.alpha.height() != graphics.mask.height())
    return;
  for (int y = box.y; y < box.y + box.height; ++y) {
    for (int x = box.x; x < box.x + box.width; ++x) {
      if (graphics.mask(x, y) == 0) continue;
      matte.alpha(x, y) = 0;
      matte.unknown(x, y) = 255;
      matte.occluders(x, y) = 255;
    }
  }
  image::Rect& region = matte.region;
  if (region.empty()) {
    region = box;
    return;
  }
  const int right = std::max(region.x + region.width, box.x + box.width);
  const int bottom = std::max(region.y + region.height, box.y + box.height);
  region.x = std::min(region.x, box.x);
  region.y = std::min(region.y, box.y);
  region.width = right - region.x;
  region.height = bottom - region.y;
}

}  // namespace touchline::compensate
