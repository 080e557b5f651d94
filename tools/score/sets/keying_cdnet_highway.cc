#include "tools/score/sets/keying_cdnet_highway.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/background_segm.hpp>
#include <string>
#include <utility>
#include <vector>

#include "shared/image/colour.h"
#include "shared/recording/still_reader.h"
#include "tools/score/sets/fixed_view.h"
#include "tools/score/sets/set_pictures.h"

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

constexpr int kFirst = 560;
constexpr int kLast = 719;
constexpr int kHoldBack = 50;  // frames that every method sees before its answers count

struct Shot {
  int number = 0;
  image::Frame frame;
  image::Image<image::Rgb8> rgb;
  image::Image<std::uint8_t> truth;
};

double share(double part, double whole) {
  return whole > 0 ? part / whole : std::numeric_limits<double>::quiet_NaN();
}

base::Result<std::vector<Shot>> read_shots(const fs::path& folder) {
  std::vector<Shot> shots;
  for (int number = kFirst; number <= kLast; ++number) {
    const fs::path input = folder / "input" / fmt::format("in{:06}.jpg", number);
    if (!fs::exists(input)) break;
    auto frame = recording::read_still(input);
    if (!frame) return base::fail(frame.error());
    auto truth = read_grey(folder / "groundtruth" / fmt::format("gt{:06}.png", number));
    if (!truth) return base::fail(truth.error());
    if (truth->width() != frame->width() || truth->height() != frame->height()) {
      return base::fail(base::ErrorKind::kFormat, input.string(), "has another size than its mask");
    }
    Shot shot;
    shot.number = number;
    shot.rgb = image::to_rgb(*frame);
    shot.frame = std::move(*frame);
    shot.truth = std::move(*truth);
    shots.push_back(std::move(shot));
  }
  return shots;
}

// A method: learns from a frame, and says where motion is.
struct Method {
  std::string name;
  std::function<image::Image<std::uint8_t>(const Shot&)> see;  // takes the frame in as well
  // Against what is known, without taking it in.
  std::function<image::Image<std::uint8_t>(const Shot&)> ask;
};

Method ours(const std::string& name, int width, int height, const key::KeyOptions& options) {
  auto view = std::make_shared<FixedView>(width, height);
  Method method;
  method.name = name;
  method.ask = [view, options](const Shot& shot) { return view->key(shot.frame, options); };
  method.see = [view, options](const Shot& shot) {
    view->learn(shot.frame);
    return view->key(shot.frame, options);
  };
  return method;
}

Method opencv(const std::string& name, cv::Ptr<cv::BackgroundSubtractor> subtractor) {
  const auto apply = [subtractor](const Shot& shot, double rate) {
    cv::Mat bgr(shot.rgb.height(), shot.rgb.width(), CV_8UC3);
    for (int y = 0; y < bgr.rows; ++y) {
      for (int x = 0; x < bgr.cols; ++x) {
        const image::Rgb8 p = shot.rgb(x, y);
        bgr.at<cv::Vec3b>(y, x) = {p.b, p.g, p.r};
      }
    }
    cv::Mat mask;
    subtractor->apply(bgr, mask, rate);
    image::Image<std::uint8_t> out(mask.cols, mask.rows);
    for (int y = 0; y < mask.rows; ++y) {
      // Shadows are marked 127: background.
      for (int x = 0; x < mask.cols; ++x) out(x, y) = mask.at<std::uint8_t>(y, x) == 255 ? 255 : 0;
    }
    return out;
  };
  return {name, [apply](const Shot& shot) { return apply(shot, -1); },
          [apply](const Shot& shot) { return apply(shot, 0); }};
}

SetRow row_of(const std::string& label, const ChangeCounts& counts, std::size_t frames) {
  return {label,
          {{"F-score", counts.f_score(), "", frames},
           {"precision", 100 * counts.precision(), "%", frames},
           {"recall", 100 * counts.recall(), "%", frames},
           {"wrong", 100 * counts.wrong(), "%", frames},
           {"shadow as motion", 100 * counts.shadow_as_motion(), "%", frames}}};
}

}  // namespace

void ChangeCounts::add(const image::Image<std::uint8_t>& truth,
                       const image::Image<std::uint8_t>& region,
                       const image::Image<std::uint8_t>& found) {
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const std::uint8_t t = truth.data()[i];
    if (t == 85 || t == 170 || region.data()[i] == 0) continue;
    const bool motion = found.data()[i] >= 128;
    if (t == 255) {
      (motion ? true_positive : false_negative) += 1;
    } else {
      (motion ? false_positive : true_negative) += 1;
    }
    if (t == 50) {
      shadow += 1;
      shadow_found += motion;
    }
  }
}

double ChangeCounts::precision() const {
  return share(true_positive, true_positive + false_positive);
}
double ChangeCounts::recall() const { return share(true_positive, true_positive + false_negative); }
double ChangeCounts::f_score() const {
  return share(2 * true_positive, 2 * true_positive + false_positive + false_negative);
}
double ChangeCounts::wrong() const {
  return share(false_positive + false_negative,
               true_positive + false_positive + false_negative + true_negative);
}
double ChangeCounts::shadow_as_motion() const { return share(shadow_found, shadow); }

base::Result<SetReport> run_keying_cdnet_highway(const SetOptions& options) {
  const fs::path folder = options.data / "keying-cdnet-highway";
  if (!fs::is_directory(folder)) {
    return base::fail(base::ErrorKind::kNotFound, folder.string(), "is not there",
                      "set TOUCHLINE_DATA or give --data");
  }
  const auto region = read_grey(folder / "ROI.bmp");
  if (!region) return base::fail(region.error());
  const auto shots = read_shots(folder);
  if (!shots) return base::fail(shots.error());
  if (shots->empty()) {
    return base::fail(base::ErrorKind::kNotFound, (folder / "input").string(), "has no frames");
  }
  const int width = shots->front().rgb.width();
  const int height = shots->front().rgb.height();
  if (region->width() != width || region->height() != height) {
    return base::fail(base::ErrorKind::kFormat, (folder / "ROI.bmp").string(),
                      "has another size than the frames");
  }
  const auto methods = [&] {
    key::KeyOptions still;
    still.calibration_px = 0;
    std::vector<Method> out;
    out.push_back(ours("ours, as in the product", width, height, {}));
    out.push_back(ours("ours, told that the camera stands still", width, height, still));
    out.push_back(opencv("OpenCV MOG2", cv::createBackgroundSubtractorMOG2()));
    out.push_back(opencv("OpenCV KNN", cv::createBackgroundSubtractorKNN()));
    return out;
  };

  SetReport report;
  report.name = "keying-cdnet-highway";
  report.what = fmt::format(
      "{} consecutive frames, {} x {}, of a static camera over a road (changedetection.net 2014), "
      "every pixel labelled; shadows count as background, unknown borders are left out.",
      shots->size(), width, height);
  const std::size_t hold_back = std::min<std::size_t>(kHoldBack, shots->size() / 3);
  const std::size_t middle = hold_back + (shots->size() - hold_back) / 2;
  for (Method& method : methods()) {
    ChangeCounts counts;
    for (std::size_t i = 0; i < shots->size(); ++i) {
      const Shot& shot = (*shots)[i];
      const auto found = method.see(shot);
      if (i < hold_back) continue;
      counts.add(shot.truth, *region, found);
      if (i == middle && !options.pictures.empty()) {
        image::Image<std::uint8_t> motion = shot.truth;
        for (std::size_t k = 0; k < motion.size(); ++k) {
          if (motion.data()[k] == 170) motion.data()[k] = found.data()[k];  // unknown
          if (motion.data()[k] == 85) motion.data()[k] = 0;
        }
        const auto written = write_mask_picture(
            options.pictures / fmt::format("{}-{}.png", report.name, report.rows.size()), shot.rgb,
            motion, found);
        if (!written) return base::fail(written.error());
      }
    }
    report.rows.push_back(
        row_of("as frames come: " + method.name, counts, shots->size() - hold_back));
  }
  for (Method& method : methods()) {
    ChangeCounts counts;
    for (const Shot& shot : *shots) method.see(shot);
    for (const Shot& shot : *shots) counts.add(shot.truth, *region, method.ask(shot));
    report.rows.push_back(row_of("all frames known: " + method.name, counts, shots->size()));
  }
  report.notes = {
      fmt::format("As frames come: each method sees {} frames first, the next count. All frames "
                  "known: a first pass over all of them, then each is asked about all.",
                  hold_back),
      "MOG2 and KNN: OpenCV's defaults, shadow detection on, what they call shadow is background.",
      "Ours: edge/plate and edge/key with a made-up camera over open ground, for the set tells no "
      "geometry; the median instead of turf rules, alpha 0.5. Vehicles are not what the key's "
      "sizes "
      "(people, a ball) are made for; trees that move in the wind it takes for people.",
  };
  return report;
}

}  // namespace touchline::score
