#include "tools/score/sets/keying_lemur.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_filter.hpp>
#include <string>
#include <utility>
// clang-format off
#include <opencv2/core.hpp>  // which alphamat.hpp forgets
#include <opencv2/alphamat.hpp>
// clang-format on

#include "shared/image/colour.h"
#include "tools/score/sets/fixed_view.h"
#include "tools/score/sets/set_pictures.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

using Grey = image::Image<std::uint8_t>;
using Rgb = image::Image<image::Rgb8>;

constexpr int kPlateFrames = 8;

cv::Mat bgr_of(const Rgb& picture) {
  cv::Mat out(picture.height(), picture.width(), CV_8UC3);
  for (int y = 0; y < out.rows; ++y) {
    for (int x = 0; x < out.cols; ++x) {
      const image::Rgb8 p = picture(x, y);
      out.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
    }
  }
  return out;
}

cv::Mat mat_of(const Grey& grey) {
  cv::Mat out(grey.height(), grey.width(), CV_8UC1);
  for (int y = 0; y < out.rows; ++y) std::copy_n(grey.row(y), grey.width(), out.ptr(y));
  return out;
}

Grey grey_of(const cv::Mat& mat) {
  Grey out(mat.cols, mat.rows);
  for (int y = 0; y < mat.rows; ++y) std::copy_n(mat.ptr(y), mat.cols, out.row(y));
  return out;
}

bool is_sure(std::uint8_t trimap) { return trimap == 0 || trimap == 255; }

Grey told_by_trimap(Grey alpha, const Grey& trimap) {
  for (std::size_t i = 0; i < alpha.size(); ++i) {
    if (is_sure(trimap.data()[i])) alpha.data()[i] = trimap.data()[i];
  }
  return alpha;
}

Grey grab_cut(const Rgb& picture, const Grey& trimap) {
  cv::Mat labels(trimap.height(), trimap.width(), CV_8UC1);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      const std::uint8_t t = trimap(x, y);
      labels.at<std::uint8_t>(y, x) =
          static_cast<std::uint8_t>(t == 255 ? cv::GC_FGD : (t == 0 ? cv::GC_BGD : cv::GC_PR_FGD));
    }
  }
  cv::Mat background, foreground;
  cv::grabCut(bgr_of(picture), labels, {}, background, foreground, 5, cv::GC_INIT_WITH_MASK);
  Grey out(labels.cols, labels.rows);
  for (int y = 0; y < labels.rows; ++y) {
    for (int x = 0; x < labels.cols; ++x) {
      out(x, y) = (labels.at<std::uint8_t>(y, x) & 1) ? 255 : 0;  // GC_FGD, GC_PR_FGD
    }
  }
  return out;
}

Grey guided(const Rgb& picture, const Grey& rough, int radius, double epsilon) {
  cv::Mat out;
  cv::ximgproc::guidedFilter(bgr_of(picture), mat_of(rough), out, radius, epsilon * 255 * 255);
  return grey_of(out);
}

// The share of the foreground that explains a pixel best, both colours known: what remains of
// compression and rounding.
Grey projected(const Rgb& picture, const Rgb& foreground, const Rgb& background) {
  Grey out(picture.width(), picture.height());
  const auto vector = [](image::Rgb8 p) { return Eigen::Vector3d(p.r, p.g, p.b); };
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const Eigen::Vector3d b = vector(background.data()[i]);
    const Eigen::Vector3d line = vector(foreground.data()[i]) - b;
    const double length = std::max(1.0, line.squaredNorm());
    const double share = std::clamp(line.dot(vector(picture.data()[i]) - b) / length, 0.0, 1.0);
    out.data()[i] = static_cast<std::uint8_t>(std::lround(255 * share));
  }
  return out;
}

}  // namespace

AlphaError alpha_error(const Grey& truth, const Grey& found, const Grey& trimap) {
  AlphaError error;
  double both = 0;
  double either = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool t = truth.data()[i] >= 128;
    const bool f = found.data()[i] >= 128;
    both += t && f;
    either += t || f;
    if (!trimap.empty() && is_sure(trimap.data()[i])) continue;
    const double d = std::abs(int{truth.data()[i]} - int{found.data()[i]}) / 255.0;
    error.sum += d;
    error.square += d * d;
    ++error.pixels;
  }
  const double n = static_cast<double>(error.pixels);
  error.mean = n > 0 ? error.sum / n : std::numeric_limits<double>::quiet_NaN();
  error.square = n > 0 ? error.square / n : std::numeric_limits<double>::quiet_NaN();
  error.iou = either > 0 ? both / either : std::numeric_limits<double>::quiet_NaN();
  return error;
}

base::Result<SetReport> run_keying_lemur(const SetOptions& options) {
  const fs::path folder = options.data / "keying-lemur";
  if (!fs::is_directory(folder)) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(), "is not there",
                      "set TOUCHLINE_DATA or give --data");
  }
  const auto picture = read_rgb(folder / "lemur.png");
  const auto foreground = read_rgb(folder / "lemur_foreground.png");
  const auto background = read_rgb(folder / "lemur_background.png");
  for (const auto* read : {&picture, &foreground, &background}) {
    if (!*read) return base::fail(read->error());
  }
  const auto truth = read_grey(folder / "lemur_alpha.png");
  const auto trimap = read_grey(folder / "lemur_trimap.png");
  for (const auto* read : {&truth, &trimap}) {
    if (!*read) return base::fail(read->error());
  }
  const int width = picture->width();
  const int height = picture->height();
  const auto fits = [&](const auto& image) {
    return image.width() == width && image.height() == height;
  };
  if (!fits(*foreground) || !fits(*background) || !fits(*truth) || !fits(*trimap)) {
    return base::fail(base::ErrorKind::kFormat, folder.string(), "holds pictures of several sizes");
  }

  FixedView view(width, height);
  const auto format = image::PixelFormat::kYuv422p10;
  const image::Frame empty = image::from_rgb(*background, format, {});
  for (int i = 0; i < kPlateFrames; ++i) view.learn(empty);
  const Grey ours = view.key(image::from_rgb(*picture, format, {}));

  SetReport report;
  report.name = "keying-lemur";
  report.what = fmt::format(
      "One picture, {} x {}, of a furry animal before leaves, with its coverage, foreground and "
      "background as another method's careful estimate gives them; a trimap with {:.0f} % unknown.",
      width, height,
      100.0 * static_cast<double>(alpha_error(*truth, *truth, *trimap).pixels) /
          static_cast<double>(truth->size()));
  base::Status picture_error;
  const auto add = [&](const std::string& label, const Grey& found) {
    const AlphaError border = alpha_error(*truth, found, *trimap);
    const AlphaError all = alpha_error(*truth, found, {});
    report.rows.push_back({label,
                           {{"alpha error", 100 * border.mean, "%", border.pixels},
                            {"MSE x1000", 1000 * border.square, "", border.pixels},
                            {"SAD/1000", border.sum / 1000, "", border.pixels},
                            {"error all over", 100 * all.mean, "%", all.pixels},
                            {"IoU at 0.5", 100 * all.iou, "%", all.pixels}}});
    if (options.pictures.empty() || !picture_error) return;
    picture_error = write_mask_picture(
        options.pictures / fmt::format("{}-{}.png", report.name, report.rows.size() - 1), *picture,
        *truth, found);
  };
  add("ours: difference key, true background as plate", ours);
  add("ours, sure pixels of the trimap put in", told_by_trimap(ours, *trimap));
  cv::Mat flow;
  try {
    cv::alphamat::infoFlow(bgr_of(*picture), mat_of(*trimap), flow);
  } catch (const cv::Exception&) {
    flow.release();
  }
  if (!flow.empty() && flow.depth() == CV_8U && flow.channels() == 1) {
    add("OpenCV alphamat infoFlow, trimap", told_by_trimap(grey_of(flow), *trimap));
  } else {
    report.notes.push_back("OpenCV's alphamat gave no answer on this machine.");
  }
  const Grey cut = grab_cut(*picture, *trimap);
  add("OpenCV grabCut, trimap", cut);
  add("OpenCV grabCut and guidedFilter (r 10), trimap",
      told_by_trimap(guided(*picture, cut, 10, 1e-4), *trimap));
  add("both colours known: projection (floor)", projected(*picture, *foreground, *background));
  if (!picture_error) return base::fail(picture_error.error());
  report.notes.push_back(
      "Alpha error, MSE and SAD over the trimap's unknown pixels; error all over and IoU over the "
      "whole picture.");
  report.notes.push_back(
      "Ours and the others are told different things: ours the background (never a trimap; it has "
      "no way to take one), the others the trimap (never the background).");
  report.notes.push_back(
      "Under the animal the background is that estimate's guess and partly shows the animal's own "
      "colours, so that a difference key must fail there: read the unknown border first.");
  return report;
}

}  // namespace touchline::score
