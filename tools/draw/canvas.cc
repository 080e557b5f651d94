#include "tools/draw/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace touchline::draw {

namespace {

constexpr int kShift = 4;  // fixed-point bits of OpenCV's drawing

cv::Mat mat(Picture& picture) {
  return {picture.height(), picture.width(), CV_8UC3, picture.data()};
}
// OpenCV has no matrix over constant data; the callers only read.
cv::Mat mat(const Picture& picture) {
  return {picture.height(), picture.width(), CV_8UC3,
          const_cast<image::Rgb8*>(picture.data())};  // NOLINT
}
cv::Mat mat(Mask& mask) { return {mask.height(), mask.width(), CV_8UC1, mask.data()}; }

cv::Scalar scalar(image::Rgb8 c) { return {double(c.r), double(c.g), double(c.b)}; }

// Far points would overflow OpenCV's fixed-point coordinates.
bool drawable(const Eigen::Vector2d& p) {
  return p.allFinite() && p.cwiseAbs().maxCoeff() < 30'000;
}

cv::Point fixed(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x() * (1 << kShift))),
          static_cast<int>(std::lround(p.y() * (1 << kShift)))};
}

}  // namespace

void draw_line(Picture& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
               image::Rgb8 colour, int width) {
  if (!drawable(from) || !drawable(to)) return;
  cv::Mat m = mat(picture);
  cv::line(m, fixed(from), fixed(to), scalar(colour), width, cv::LINE_AA, kShift);
}

void draw_arrow(Picture& picture, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                image::Rgb8 colour, int width) {
  draw_line(picture, from, to, colour, width);
  const Eigen::Vector2d along = to - from;
  const double length = along.norm();
  if (!(length >= 6)) return;
  const double head = std::min(7.0, 0.4 * length);
  const Eigen::Vector2d back = -along / length * head;
  for (const double turn : {0.5, -0.5}) {
    const Eigen::Vector2d side(std::cos(turn) * back.x() - std::sin(turn) * back.y(),
                               std::sin(turn) * back.x() + std::cos(turn) * back.y());
    draw_line(picture, to, to + side, colour, width);
  }
}

void draw_dot(Picture& picture, const Eigen::Vector2d& at, double radius, image::Rgb8 colour) {
  if (!drawable(at)) return;
  cv::Mat m = mat(picture);
  cv::circle(m, fixed(at), static_cast<int>(std::lround(radius * (1 << kShift))), scalar(colour),
             cv::FILLED, cv::LINE_AA, kShift);
}

void draw_frame(Picture& picture, const image::Rect& rect, image::Rgb8 colour, int width) {
  cv::Mat m = mat(picture);
  cv::rectangle(m, cv::Rect(rect.x, rect.y, rect.width, rect.height), scalar(colour), width);
}

void draw_label(Picture& picture, int x, int y, const std::string& text, image::Rgb8 colour) {
  constexpr double kSize = 0.5;
  int below = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kSize, 1, &below);
  cv::Mat m = mat(picture);
  cv::rectangle(m, {x, y, size.width + 10, size.height + below + 8}, {20, 22, 26}, cv::FILLED);
  cv::putText(m, text, {x + 5, y + size.height + 4}, cv::FONT_HERSHEY_SIMPLEX, kSize,
              scalar(colour), 1, cv::LINE_AA);
}

void draw_outline(Picture& picture, const Mask& mask, image::Rgb8 colour, int width) {
  Mask binary(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.size(); ++i) binary.data()[i] = mask.data()[i] >= 128 ? 255 : 0;
  std::vector<std::vector<cv::Point>> contours;
  cv::findContours(mat(binary), contours, cv::RETR_LIST, cv::CHAIN_APPROX_NONE);
  cv::Mat m = mat(picture);
  cv::drawContours(m, contours, -1, scalar(colour), width, cv::LINE_AA);
}

void fill_triangle(Mask& mask, const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                   const Eigen::Vector2d& c) {
  if (!drawable(a) || !drawable(b) || !drawable(c)) return;
  const auto area = [](const Eigen::Vector2d& p, const Eigen::Vector2d& q,
                       const Eigen::Vector2d& r) {
    return (q.x() - p.x()) * (r.y() - p.y()) - (q.y() - p.y()) * (r.x() - p.x());
  };
  const double turn = area(a, b, c) < 0 ? -1 : 1;
  const Eigen::Vector2d low = a.cwiseMin(b).cwiseMin(c);
  const Eigen::Vector2d high = a.cwiseMax(b).cwiseMax(c);
  const int y1 = std::min(mask.height() - 1, static_cast<int>(std::floor(high.y())));
  const int x1 = std::min(mask.width() - 1, static_cast<int>(std::floor(high.x())));
  for (int y = std::max(0, static_cast<int>(std::ceil(low.y()))); y <= y1; ++y) {
    for (int x = std::max(0, static_cast<int>(std::ceil(low.x()))); x <= x1; ++x) {
      const Eigen::Vector2d p(x, y);
      if (turn * area(a, b, p) >= 0 && turn * area(b, c, p) >= 0 && turn * area(c, a, p) >= 0) {
        mask(x, y) = 255;
      }
    }
  }
}

image::Rgb8 mix(image::Rgb8 pixel, image::Rgb8 colour, double share) {
  const auto one = [share](std::uint8_t a, std::uint8_t b) {
    return static_cast<std::uint8_t>(std::lround(a + share * (double(b) - a)));
  };
  return {one(pixel.r, colour.r), one(pixel.g, colour.g), one(pixel.b, colour.b)};
}

Picture subdued(const Picture& picture, double keep, double light) {
  Picture out(picture.width(), picture.height());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const image::Rgb8 p = picture.data()[i];
    const double grey = 0.2126 * p.r + 0.7152 * p.g + 0.0722 * p.b;
    const auto one = [&](std::uint8_t v) {
      return static_cast<std::uint8_t>(std::clamp(light * (grey + keep * (v - grey)), 0.0, 255.0));
    };
    out.data()[i] = {one(p.r), one(p.g), one(p.b)};
  }
  return out;
}

namespace {

template <typename T>
image::Image<T> crop_of(const image::Image<T>& from, const image::Rect& rect, int zoom) {
  image::Image<T> out(rect.width * zoom, rect.height * zoom);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const int sx = rect.x + x / zoom;
      const int sy = rect.y + y / zoom;
      if (from.contains(sx, sy)) out(x, y) = from(sx, sy);
    }
  }
  return out;
}

}  // namespace

Picture crop(const Picture& picture, const image::Rect& rect, int zoom) {
  return crop_of(picture, rect, zoom);
}
Mask crop(const Mask& mask, const image::Rect& rect, int zoom) { return crop_of(mask, rect, zoom); }

Picture from_grey(const Mask& mask) {
  Picture out(mask.width(), mask.height());
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const std::uint8_t v = mask.data()[i];
    out.data()[i] = {v, v, v};
  }
  return out;
}

Picture at_most(const Picture& picture, int width) {
  if (picture.width() <= width) return picture;
  const int height = std::max(1, picture.height() * width / picture.width());
  Picture out(width, height);
  cv::Mat m = mat(out);
  cv::resize(mat(picture), m, {width, height}, 0, 0, cv::INTER_AREA);
  return out;
}

Picture beside(std::span<const Picture> pictures, int gap) {
  int width = 0;
  int height = 0;
  for (const Picture& p : pictures) {
    width += p.width() + (width > 0 ? gap : 0);
    height = std::max(height, p.height());
  }
  Picture out(width, height, kWhite);
  int left = 0;
  for (const Picture& p : pictures) {
    for (int y = 0; y < p.height(); ++y) {
      std::copy(p.row(y), p.row(y) + p.width(), out.row(y) + left);
    }
    left += p.width() + gap;
  }
  return out;
}

image::Rect heaviest_window(const image::Image<float>& map, int width, int height) {
  const int w = std::min(width, map.width());
  const int h = std::min(height, map.height());
  if (w < 1 || h < 1) return {0, 0, map.width(), map.height()};
  // Summed area table.
  image::Image<double> sum(map.width() + 1, map.height() + 1);
  for (int y = 0; y < map.height(); ++y) {
    double row = 0;
    for (int x = 0; x < map.width(); ++x) {
      row += map(x, y);
      sum(x + 1, y + 1) = sum(x + 1, y) + row;
    }
  }
  image::Rect best{(map.width() - w) / 2, (map.height() - h) / 2, w, h};
  double most = 0;
  constexpr int kStep = 4;
  for (int y = 0; y + h <= map.height(); y += kStep) {
    for (int x = 0; x + w <= map.width(); x += kStep) {
      const double s = sum(x + w, y + h) - sum(x, y + h) - sum(x + w, y) + sum(x, y);
      if (s > most * (1 + 1e-9)) {
        most = s;
        best.x = x;
        best.y = y;
      }
    }
  }
  return best;
}

base::Status write_picture(const std::filesystem::path& path, const Picture& picture) {
  if (picture.empty()) return base::fail(base::ErrorKind::kArgument, path.string(), "is empty");
  cv::Mat bgr;
  cv::cvtColor(mat(picture), bgr, cv::COLOR_RGB2BGR);
  bool written = false;
  try {
    written = cv::imwrite(path.string(), bgr, {cv::IMWRITE_PNG_COMPRESSION, 6});
  } catch (const cv::Exception&) {
    written = false;
  }
  if (!written) {
    return base::fail(base::ErrorKind::kIo, path.string(), "cannot be written",
                      "check the folder and the space on its disk");
  }
  return {};
}

}  // namespace touchline::draw
