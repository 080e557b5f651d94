#include "tools/inspect/key_training.h"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include "edge/edge_config.h"
#include "edge/key/colour_classifier.h"
#include "shared/image/colour.h"
#include "shared/recording/video_reader.h"

namespace touchline::inspect {
namespace {

constexpr image::Rgb8 kMarked{235, 40, 220};
constexpr image::Rgb8 kBetween{245, 180, 240};
constexpr double kTint = 0.6;

base::Result<image::Frame> frame_of(const recording::Recording& recording,
                                    const recording::CameraEntry& entry, std::int64_t wanted) {
  auto video = recording::VideoReader::open(entry, recording, 0);
  if (!video) return base::fail(video.error());
  for (std::int64_t i = 0;; ++i) {
    auto frame = video->next();
    if (!frame) return base::fail(frame.error());
    if (!*frame) {
      return base::fail(base::ErrorKind::kArgument, "--frame",
                        fmt::format("{}: the video has {} frames", wanted, i),
                        "give a frame from 0 on");
    }
    if (i == wanted) return **frame;
  }
}

base::Result<image::Frame> picture_of(const recording::Recording& recording,
                                      const TrainingSteps& steps) {
  const recording::CameraEntry* entry = recording.find(steps.camera);
  if (entry == nullptr) {
    return base::fail(base::ErrorKind::kArgument, "--camera",
                      fmt::format("the recording has no camera '{}'", steps.camera.value),
                      "touchline-edge list --recording shows them");
  }
  if (steps.frame) return frame_of(recording, *entry, *steps.frame);
  edge::SurveyStills stills = edge::load_stills(*entry);
  if (steps.still < 0 || static_cast<std::size_t>(steps.still) >= stills.frames.size()) {
    if (!stills.troubles.empty()) return base::fail(stills.troubles.front());
    return base::fail(base::ErrorKind::kArgument, "--still",
                      fmt::format("{}: camera '{}' has {} survey stills", steps.still,
                                  steps.camera.value, stills.frames.size()),
                      stills.frames.empty() ? "give --frame in its place" : "count them from 0");
  }
  return std::move(stills.frames[static_cast<std::size_t>(steps.still)]);
}

base::Result<key::ColourTraining> training_before(const TrainingSteps& steps) {
  std::error_code error;
  if (!std::filesystem::exists(steps.colours, error)) return key::ColourTraining{};
  return key::load_colour_training(steps.colours);
}

}  // namespace

base::Result<TrainingResult> train_key(const recording::Recording& recording,
                                       const TrainingSteps& steps) {
  const auto frame = picture_of(recording, steps);
  if (!frame) return base::fail(frame.error());
  auto training = training_before(steps);
  if (!training) return base::fail(training.error());
  for (int i = 0; i < steps.undo; ++i) {
    if (!training->undo()) {
      return base::fail(base::ErrorKind::kArgument, "--undo",
                        fmt::format("{}: there were {} clicks", steps.undo, i),
                        "take back at most as many");
    }
  }
  for (const auto& [x, y] : steps.clicks) {
    const auto colour = key::colour_at(*frame, x, y);
    if (!colour) return base::fail(colour.error());
    if (!training->click(*colour)) {
      return base::fail(
          base::ErrorKind::kConfiguration, steps.colours.string(),
          fmt::format("there are {} colours, no more fit", key::ColourTraining::kMost),
          "take some back with --undo, or make r1 larger");
    }
  }
  training->r1 = steps.r1.value_or(training->r1);
  training->r2 = steps.r2.value_or(training->r2);
  if (auto status = training->validate(); !status) return base::fail(status.error());

  const image::Image<std::uint8_t> marked =
      key::classify(*frame, key::ColourTable(*training, frame->colour));
  TrainingResult result;
  result.colours = training->background.size();
  result.preview = draw::subdued(image::to_rgb(*frame), 0.7, 0.9);
  std::size_t background = 0, between = 0;
  for (int y = 0; y < marked.height(); ++y) {
    for (int x = 0; x < marked.width(); ++x) {
      if (marked(x, y) == 255) continue;
      const bool inside = marked(x, y) == 0;
      ++(inside ? background : between);
      result.preview(x, y) = draw::mix(result.preview(x, y), inside ? kMarked : kBetween, kTint);
    }
  }
  const double all = static_cast<double>(marked.width()) * marked.height();
  result.background_share = static_cast<double>(background) / all;
  result.between_share = static_cast<double>(between) / all;
  for (const auto& [x, y] : steps.clicks) draw::draw_dot(result.preview, {x, y}, 4, draw::kExtra);
  result.preview = draw::at_most(result.preview, steps.width);
  if (auto status = draw::write_picture(steps.out, result.preview); !status)
    return base::fail(status.error());
  if (auto status = key::save_colour_training(steps.colours, *training); !status)
    return base::fail(status.error());
  return result;
}

}  // namespace touchline::inspect
