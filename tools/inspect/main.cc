// touchline-inspect: pictures of what the stages found, to look at.
#include <CLI/CLI.hpp>
#include <array>
#include <charconv>
#include <cstdio>
#include <string>
#include <vector>

#include "tools/inspect/key_training.h"
#include "tools/inspect/pictures.h"

namespace {

using namespace touchline;  // NOLINT: this file is the program

int failed(const base::Error& error) {
  std::fprintf(stderr, "touchline-inspect: %s\n", base::to_string(error).c_str());
  return base::exit_code(error);
}

// "x,y" as two numbers; false when it is none.
bool pixel(const std::string& text, std::array<int, 2>& at) {
  const char* end = text.data() + text.size();
  const auto x = std::from_chars(text.data(), end, at[0]);
  if (x.ec != std::errc() || x.ptr == end || *x.ptr != ',') return false;
  const auto y = std::from_chars(x.ptr + 1, end, at[1]);
  return y.ec == std::errc() && y.ptr == end;
}

int train(const recording::Recording& recording, inspect::TrainingSteps steps,
          const std::vector<std::string>& clicks) {
  for (const std::string& click : clicks) {
    if (!pixel(click, steps.clicks.emplace_back())) {
      return failed({base::ErrorKind::kArgument, "--click", "'" + click + "' is no pixel",
                     "write it as 640,360"});
    }
  }
  const auto result = inspect::train_key(recording, steps);
  if (!result) return failed(result.error());
  std::printf("%zu colours in %s; %.1f %% of the picture is background, %.1f %% between; %s\n",
              result->colours, steps.colours.c_str(), 100 * result->background_share,
              100 * result->between_share, steps.out.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Pictures of what edge and hub found in a recording, as PNG files."};
  app.require_subcommand(1);
  std::string recording_path, session, out;
  std::vector<std::string> cameras;
  inspect::PictureOptions options;
  double length = 0, width = 0;
  const auto flags = [&](CLI::App* verb, bool of_session) {
    verb->add_option("--recording", recording_path, "a folder with recording.toml")->required();
    verb->add_option("--out", out, "folder for the pictures")->required();
    verb->add_option("--camera", cameras, "only this camera; may be given several times");
    verb->add_option("--width", options.width, "pictures are made smaller to this, pixels")
        ->check(CLI::Range(160, 8192));
    verb->add_option("--pitch-length", length, "metres, in place of what the recording states")
        ->check(CLI::Range(50.0, 200.0));
    verb->add_option("--pitch-width", width, "the same")->check(CLI::Range(30.0, 120.0));
    if (!of_session) return;
    verb->add_option("--session", session, "a session of that recording")->required();
    verb->add_option("--frames", options.frames, "frame numbers, by commas")->delimiter(',');
    verb->add_option("--every", options.every, "each how many frames")
        ->check(CLI::Range(1, 100000));
  };
  CLI::App* lines = app.add_subcommand("lines", "the pitch's markings where each camera puts them");
  flags(lines, true);
  lines->footer(
      "example: touchline-inspect lines --recording match --session out/s --frames 0,25 --out "
      "out/p");
  CLI::App* key = app.add_subcommand(
      "key", "mattes: people in colour, unknown in blue, posts and nets in yellow");
  flags(key, true);
  key->footer(
      "example: touchline-inspect key --recording match --session out/s --camera m1 --out out/p");
  CLI::App* survey = app.add_subcommand(
      "survey", "the markings over each survey still, and a plan of where the heads stand");
  flags(survey, false);
  survey->footer("example: touchline-inspect survey --recording match --out out/p");
  CLI::App* trainer = app.add_subcommand(
      "train", "click on background in a still or a frame: its colours are no people any more");
  inspect::TrainingSteps steps;
  std::vector<std::string> clicks;
  trainer->add_option("--recording", recording_path, "a folder with recording.toml")->required();
  trainer->add_option("--camera", steps.camera.value, "whose picture")->required();
  auto* still = trainer->add_option("--still", steps.still, "the survey still clicked on, from 0");
  trainer->add_option("--frame", steps.frame, "a frame of the video in its place")->excludes(still);
  trainer->add_option("--click", clicks, "a background pixel, as x,y; may be given several times");
  trainer->add_option("--undo", steps.undo, "takes this many clicks back first")
      ->check(CLI::Range(0, 256));
  trainer->add_option("--r1", steps.r1, "R'G'B' distance (of 255) within which all is background");
  trainer->add_option("--r2", steps.r2, "and beyond which nothing is");
  trainer->add_option("--colours", steps.colours, "the file of the camera's colours")->required();
  trainer->add_option("--out", steps.out, "the preview, a PNG file")->required();
  trainer->add_option("--width", steps.width, "it is made smaller to this, pixels")
      ->check(CLI::Range(160, 8192));
  trainer->footer(
      "example: touchline-inspect train --recording match --camera m1 --click 640,500 --colours "
      "m1-colours.toml --out marked.png\nThe unit takes the file as `colours` of its [key].");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const auto recording = recording::load_recording(recording_path);
  if (!recording) return failed(recording.error());
  if (*trainer) return train(*recording, steps, clicks);
  for (const std::string& camera : cameras) {
    if (recording->find(base::CameraId{camera}) == nullptr) {
      return failed({base::ErrorKind::kArgument, "--camera",
                     "the recording has no camera '" + camera + "'",
                     "touchline-edge list --recording shows them"});
    }
    options.cameras.push_back(base::CameraId{camera});
  }
  if (length > 0) options.length_m = length;
  if (width > 0) options.width_m = width;
  const auto progress = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  const auto count =
      *survey ? inspect::survey_pictures(*recording, out, options, progress)
              : inspect::session_pictures(*recording, session,
                                          *key ? inspect::Layer::kKey : inspect::Layer::kLines, out,
                                          options, progress);
  if (!count) return failed(count.error());
  std::printf("%d pictures in %s\n", *count, out.c_str());
  return *count > 0 ? 0 : 1;
}
