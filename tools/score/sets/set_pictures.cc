#include "tools/score/sets/set_pictures.h"

#include <array>
#include <opencv2/imgcodecs.hpp>

#include "tools/draw/canvas.h"
#include "tools/score/page/matte_map.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

base::Result<cv::Mat> read_any(const fs::path& path) {
  cv::Mat read;
  try {
    read = cv::imread(path.string(), cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception&) {
    read.release();
  }
  if (read.empty()) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "cannot be read as a picture");
  }
  if (read.depth() != CV_8U || read.channels() > 4) {
    return base::fail(base::ErrorKind::kFormat, path.string(), "is no 8-bit picture");
  }
  return read;
}

}  // namespace

base::Result<image::Image<std::uint8_t>> read_grey(const fs::path& path) {
  const auto read = read_any(path);
  if (!read) return base::fail(read.error());
  image::Image<std::uint8_t> out(read->cols, read->rows);
  for (int y = 0; y < read->rows; ++y) {
    const std::uint8_t* row = read->ptr<std::uint8_t>(y);
    for (int x = 0; x < read->cols; ++x) out(x, y) = row[x * read->channels()];
  }
  return out;
}

base::Result<image::Image<image::Rgb8>> read_rgb(const fs::path& path) {
  const auto read = read_any(path);
  if (!read) return base::fail(read.error());
  image::Image<image::Rgb8> out(read->cols, read->rows);
  const int n = read->channels();
  for (int y = 0; y < read->rows; ++y) {
    const std::uint8_t* row = read->ptr<std::uint8_t>(y);
    for (int x = 0; x < read->cols; ++x) {
      const std::uint8_t* p = row + x * n;
      out(x, y) = n >= 3 ? image::Rgb8{p[2], p[1], p[0]} : image::Rgb8{p[0], p[0], p[0]};
    }
  }
  return out;
}

base::Status write_mask_picture(const fs::path& path, const image::Image<image::Rgb8>& picture,
                                const image::Image<std::uint8_t>& truth,
                                const image::Image<std::uint8_t>& found) {
  const std::array parts = {picture, page::mask_errors(picture, truth, found)};
  return write_rgb(path, draw::beside(parts));
}

base::Status write_rgb(const fs::path& path, const image::Image<image::Rgb8>& picture) {
  std::error_code error;
  if (path.has_parent_path()) fs::create_directories(path.parent_path(), error);
  if (error) return base::fail(base::ErrorKind::kIo, path.string(), error.message());
  return draw::write_picture(path, picture);
}

}  // namespace touchline::score
