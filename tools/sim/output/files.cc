#include "tools/sim/output/files.h"

#include <bit>
#include <cstring>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

namespace touchline::sim::output {

namespace {

base::Status write_bytes(const std::filesystem::path& path, const void* bytes, std::size_t size) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(size));
  out.close();
  if (out) return {};
  return base::fail(base::ErrorKind::kIo, path.string(), "cannot be written",
                    "check the folder's permissions and the room on the disk");
}

base::Status write_picture(const std::filesystem::path& path, const char* extension,
                           const cv::Mat& picture, const std::vector<int>& options) {
  std::vector<unsigned char> bytes;
  try {
    if (!cv::imencode(extension, picture, bytes, options)) {
      return base::fail(base::ErrorKind::kInternal, path.string(), "cannot be encoded");
    }
  } catch (const cv::Exception& error) {
    return base::fail(base::ErrorKind::kInternal, path.string(), error.what());
  }
  return write_bytes(path, bytes.data(), bytes.size());
}

cv::Mat bgr(const image::Image<image::Rgb8>& picture) {
  cv::Mat out(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < picture.height(); ++y) {
    auto* to = out.ptr<cv::Vec3b>(y);
    const image::Rgb8* from = picture.row(y);
    for (int x = 0; x < picture.width(); ++x) to[x] = {from[x].b, from[x].g, from[x].r};
  }
  return out;
}

}  // namespace

base::Status write_text(const std::filesystem::path& path, std::string_view text) {
  return write_bytes(path, text.data(), text.size());
}

base::Status write_grey_png(const std::filesystem::path& path,
                            const image::Image<std::uint8_t>& picture) {
  cv::Mat grey(picture.height(), picture.width(), CV_8UC1);
  for (int y = 0; y < picture.height(); ++y) {
    std::memcpy(grey.ptr(y), picture.row(y), static_cast<std::size_t>(picture.width()));
  }
  return write_picture(path, ".png", grey, {cv::IMWRITE_PNG_COMPRESSION, 1});
}

base::Status write_rgb_png(const std::filesystem::path& path,
                           const image::Image<image::Rgb8>& picture) {
  return write_picture(path, ".png", bgr(picture), {cv::IMWRITE_PNG_COMPRESSION, 3});
}

base::Status write_jpeg(const std::filesystem::path& path, const image::Image<image::Rgb8>& picture,
                        int quality) {
  return write_picture(path, ".jpg", bgr(picture), {cv::IMWRITE_JPEG_QUALITY, quality});
}

base::Status write_ply(const std::filesystem::path& path, const geometry::Mesh& mesh) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(mesh.vertices.size()) +
                      "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
                      std::to_string(mesh.triangles.size()) +
                      "\nproperty list uchar int vertex_indices\nend_header\n";
  const auto add = [&](const void* from, std::size_t size) {
    bytes.append(static_cast<const char*>(from), size);
  };
  for (const Eigen::Vector3f& v : mesh.vertices) add(v.data(), 12);
  for (const auto& triangle : mesh.triangles) {
    bytes.push_back(3);
    add(triangle.data(), 12);
  }
  return write_bytes(path, bytes.data(), bytes.size());
}

}  // namespace touchline::sim::output
