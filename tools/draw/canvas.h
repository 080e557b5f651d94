// Drawing on 8-bit R'G'B' pictures, for what people look at: pages of scores, pictures of
// calibration.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "shared/base/result.h"
#include "shared/image/image.h"

namespace touchline::draw {

using Picture = image::Image<image::Rgb8>;
using Mask = image::Image<std::uint8_t>;

inline constexpr image::Rgb8 kTrue{60, 230, 110};    // what is true
inline constexpr image::Rgb8 kFound{255, 150, 30};   // what was found
inline constexpr image::Rgb8 kMissing{255, 45, 45};  // true and not found
inline constexpr image::Rgb8 kExtra{60, 120, 255};   // found and not true
inline constexpr image::Rgb8 kWhite{255, 255, 255};

// Pixel centres at integers; anti-aliased; what lies outside the picture is cut.
void draw_line(Picture& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               image::Rgb8 colour, int width = 1);
// A line with a head at `to` once it is long enough for one.
void draw_arrow(Picture& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                image::Rgb8 colour, int width = 1);
void draw_dot(Picture& picture, const Eigen::Vector2d& at, double radius, image::Rgb8 colour);
void draw_frame(Picture& picture, const image::Rect& rect, image::Rgb8 colour, int width = 2);
// ASCII text on a dark ground, its upper left corner at `x`, `y`.
void draw_label(Picture& picture, int x, int y, const std::string& text,
                image::Rgb8 colour = kWhite);
// The boundary of what is 128 or more.
void draw_outline(Picture& picture, const Mask& mask, image::Rgb8 colour, int width = 1);
// Sets the pixels whose centres a triangle holds to 255.
void fill_triangle(Mask& mask, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                   const Eigen::Vector2d& c);

// Mixes `share` of a colour into a pixel; 0..1.
image::Rgb8 mix(image::Rgb8 pixel, image::Rgb8 colour, double share);
// Grey and darker, so that colours on it show: `keep` of the saturation and `light` of the light.
Picture subdued(const Picture& picture, double keep, double light);
// The part of a picture, black where there is none, every pixel `zoom` by `zoom`.
Picture crop(const Picture& picture, const image::Rect& rect, int zoom = 1);
Mask crop(const Mask& mask, const image::Rect& rect, int zoom = 1);
Picture from_grey(const Mask& mask);
// Smaller by area, so that the width is at most `width`; unchanged when it is.
Picture at_most(const Picture& picture, int width);
// Left to right, tops aligned, a few pixels between.
Picture beside(std::span<const Picture> pictures, int gap = 6);

// The `width` by `height` window inside the picture with the largest sum; each of the map's values
// counts. The window is the whole picture where that is smaller.
image::Rect heaviest_window(const image::Image<float>& map, int width, int height);

base::Status write_picture(const std::filesystem::path& path, const Picture& picture);

}  // namespace touchline::draw
