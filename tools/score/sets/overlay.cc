#include "tools/score/sets/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace touchline::score {
namespace {

constexpr int kMostWidth = 1600;
constexpr int kShift = 4;  // fractional bits of drawn coordinates
constexpr double kPieceM = 0.5;

cv::Scalar scalar(Colour colour) {
  return {double(colour[2]), double(colour[1]), double(colour[0])};
}

cv::Point fixed(const Eigen::Vector2d& p) {
  const auto coordinate = [](double v) {
    return static_cast<int>(std::lround(std::clamp(v, -1e6, 1e6) * (1 << kShift)));
  };
  return {coordinate(p.x()), coordinate(p.y())};
}

std::uint8_t byte(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

struct Overlay::Picture {
  cv::Mat bgr;
};

Overlay::Overlay(int width, int height) : picture_(std::make_unique<Picture>()) {
  picture_->bgr = cv::Mat(height, width, CV_8UC3, cv::Scalar(40, 60, 40));
}

Overlay::Overlay(const image::Frame& frame) : Overlay(frame.width(), frame.height()) {
  const image::ChromaShift shift = image::chroma_shift(frame.format);
  for (int y = 0; y < frame.height(); ++y) {
    auto* row = picture_->bgr.ptr<cv::Vec3b>(y);
    const std::uint16_t* luma = frame.planes[0].row(y);
    const std::uint16_t* cb = frame.planes[1].row(y >> shift.y);
    const std::uint16_t* cr = frame.planes[2].row(y >> shift.y);
    for (int x = 0; x < frame.width(); ++x) {
      const double l = (luma[x] - 64) * 255.0 / 876;
      const double b = (cb[x >> shift.x] - 512) * 255.0 / 896;
      const double r = (cr[x >> shift.x] - 512) * 255.0 / 896;
      row[x] = {byte(l + 1.8556 * b), byte(l - 0.1873 * b - 0.4681 * r), byte(l + 1.5748 * r)};
    }
  }
}

Overlay::Overlay(Overlay&&) noexcept = default;
Overlay& Overlay::operator=(Overlay&&) noexcept = default;
Overlay::~Overlay() = default;

void Overlay::draw_pitch(const geometry::CameraEstimate& camera, const pitch::PitchModel& pitch,
                         Colour colour) {
  const auto piece = [&](const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    const auto a = project(camera, from);
    const auto b = project(camera, to);
    if (a && b) draw_line(*a, *b, colour, 1);
  };
  for (const pitch::Marking& marking : pitch.markings) {
    if (marking.shape == pitch::MarkingShape::kSpot) {
      if (const auto at = project(camera, pitch.on_turf(marking.centre))) draw_dot(*at, colour, 2);
      continue;
    }
    const double length = marking.length();
    const int pieces = std::max(1, static_cast<int>(std::ceil(length / kPieceM)));
    for (int i = 0; i < pieces; ++i)
      piece(pitch.on_turf(marking.at(length * i / pieces)),
            pitch.on_turf(marking.at(length * (i + 1) / pieces)));
  }
  for (const pitch::Bar& bar : pitch.bars) piece(bar.start, bar.end);
}

void Overlay::draw_line(const Eigen::Vector2d& from, const Eigen::Vector2d& to, Colour colour,
                        int width) {
  if (!from.allFinite() || !to.allFinite()) return;
  cv::line(picture_->bgr, fixed(from), fixed(to), scalar(colour), width, cv::LINE_AA, kShift);
}

void Overlay::draw_box(const Eigen::Vector2d& low, const Eigen::Vector2d& high, Colour colour) {
  cv::rectangle(picture_->bgr, fixed(low), fixed(high), scalar(colour), 1, cv::LINE_AA, kShift);
}

void Overlay::draw_dot(const Eigen::Vector2d& at, Colour colour, int radius) {
  if (!at.allFinite()) return;
  cv::circle(picture_->bgr, fixed(at), radius << kShift, scalar(colour), cv::FILLED, cv::LINE_AA,
             kShift);
}

void Overlay::draw_text(const Eigen::Vector2d& at, const std::string& text, Colour colour) {
  const cv::Point place(static_cast<int>(at.x()), static_cast<int>(at.y()));
  const double size = std::max(0.4, picture_->bgr.cols / 1920.0 * 0.8);
  cv::putText(picture_->bgr, text, place, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3,
              cv::LINE_AA);
  cv::putText(picture_->bgr, text, place, cv::FONT_HERSHEY_SIMPLEX, size, scalar(colour), 1,
              cv::LINE_AA);
}

void Overlay::draw_matte(image::ImageView<const std::uint8_t> matte, Colour colour) {
  const int height = std::min(matte.height, picture_->bgr.rows);
  const int width = std::min(matte.width, picture_->bgr.cols);
  for (int y = 0; y < height; ++y) {
    auto* row = picture_->bgr.ptr<cv::Vec3b>(y);
    for (int x = 0; x < width; ++x) {
      const double share = 0.6 * matte.row(y)[x] / 255.0;
      for (int c = 0; c < 3; ++c)
        row[x][c] = byte((1 - share) * row[x][c] + share * colour[static_cast<std::size_t>(2 - c)]);
    }
  }
}

base::Status Overlay::write(const std::filesystem::path& path) const {
  std::error_code code;
  std::filesystem::create_directories(path.parent_path(), code);
  cv::Mat picture = picture_->bgr;
  if (picture.cols > kMostWidth) {
    const double share = static_cast<double>(kMostWidth) / picture.cols;
    cv::resize(picture_->bgr, picture, {}, share, share, cv::INTER_AREA);
  }
  std::vector<unsigned char> bytes;
  if (code || !cv::imencode(".png", picture, bytes)) {
    return base::fail(base::ErrorKind::kIo, path.string(), "the picture cannot be written",
                      "give a folder that can be written as --pictures");
  }
  std::FILE* file = std::fopen(path.c_str(), "wb");
  const bool whole =
      file != nullptr && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  if (file != nullptr) std::fclose(file);
  if (whole) return {};
  return base::fail(base::ErrorKind::kIo, path.string(), "the picture cannot be written",
                    "give a folder that can be written as --pictures");
}

}  // namespace touchline::score
