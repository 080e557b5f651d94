#include "hub/output/png.h"

#include <opencv2/imgcodecs.hpp>
#include <string>
#include <system_error>
#include <vector>

#include "hub/output/file_internal.h"

namespace touchline::output {
namespace {

base::Status write(const std::filesystem::path& path, const cv::Mat& picture,
                   const PngOptions& options) {
  if (auto status = options.validate(); !status) return status;
  if (picture.empty()) {
    return base::fail(base::ErrorKind::kInternal, path.string(), "the picture is empty");
  }
  std::vector<unsigned char> bytes;
  try {
    if (!cv::imencode(".png", picture, bytes, {cv::IMWRITE_PNG_COMPRESSION, options.compression})) {
      return base::fail(base::ErrorKind::kInternal, path.string(), "the PNG encoder failed");
    }
  } catch (const cv::Exception& error) {
    return base::fail(base::ErrorKind::kInternal, path.string(), error.what());
  }
  return write_whole(path, bytes.data(), bytes.size());
}

}  // namespace

base::Status PngOptions::validate() const {
  if (compression >= 0 && compression <= 9) return {};
  return base::fail(base::ErrorKind::kConfiguration, "png.compression",
                    std::to_string(compression) + " is outside 0..9");
}

base::Status write_png(const std::filesystem::path& path, const image::Image<image::Rgb8>& picture,
                       const PngOptions& options) {
  cv::Mat out(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const image::Rgb8& p = picture(x, y);
      out.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
    }
  }
  return write(path, out, options);
}

base::Status write_png(const std::filesystem::path& path, const scene::Picture& picture,
                       const PngOptions& options) {
  cv::Mat out(picture.height(), picture.width(), CV_8UC4);
  for (int y = 0; y < picture.height(); ++y) {
    for (int x = 0; x < picture.width(); ++x) {
      const scene::Rgba8& p = picture(x, y);
      out.at<cv::Vec4b>(y, x) = {p.b, p.g, p.r, p.a};
    }
  }
  return write(path, out, options);
}

base::Status write_png(const std::filesystem::path& path, const image::Image<std::uint8_t>& grey,
                       const PngOptions& options) {
  cv::Mat out(grey.height(), grey.width(), CV_8UC1);
  for (int y = 0; y < grey.height(); ++y) {
    for (int x = 0; x < grey.width(); ++x) out.at<std::uint8_t>(y, x) = grey(x, y);
  }
  return write(path, out, options);
}

base::Result<image::Image<image::Rgb8>> read_png_rgb(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "does not exist");
  }
  cv::Mat picture;
  try {
    picture = cv::imread(path.string(), cv::IMREAD_COLOR);
  } catch (const cv::Exception& error) {
    return base::fail(base::ErrorKind::kFormat, path.string(), error.what());
  }
  if (picture.empty()) {
    return base::fail(base::ErrorKind::kFormat, path.string(), "is no picture that can be read");
  }
  image::Image<image::Rgb8> out(picture.cols, picture.rows);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      const cv::Vec3b& p = picture.at<cv::Vec3b>(y, x);
      out(x, y) = {p[2], p[1], p[0]};
    }
  }
  return out;
}

}  // namespace touchline::output
