// touchline-sim: a match with exact truth, as a recording.
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tools/sim/output/match.h"
#include "tools/sim/output/recording_run.h"
#include "tools/sim/scene/scene.h"

namespace {

using namespace touchline;       // NOLINT: this file is the program
using namespace touchline::sim;  // NOLINT

volatile std::sig_atomic_t interrupted = 0;

void interrupt(int) { interrupted = 1; }

int failed(const base::Error& error) {
  std::fprintf(stderr, "touchline-sim: %s\n", base::to_string(error).c_str());
  return base::exit_code(error);
}

// "WxH"
bool parse_size(const std::string& text, int& width, int& height) {
  char rest = 0;
  return std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) == 2;
}

base::Status choose_cameras(scene::Scene& scene, const std::vector<std::string>& ids) {
  if (ids.empty()) return {};
  std::string known;
  for (const auto& camera : scene.cameras) known += (known.empty() ? "" : ", ") + camera.id.value;
  for (const std::string& id : ids) {
    if (std::none_of(scene.cameras.begin(), scene.cameras.end(),
                     [&](const auto& camera) { return camera.id.value == id; })) {
      return base::fail(base::ErrorKind::kArgument, "--cameras",
                        "the scene has no camera '" + id + "'", "it has: " + known);
    }
  }
  std::erase_if(scene.cameras, [&](const auto& camera) {
    return std::find(ids.begin(), ids.end(), camera.id.value) == ids.end();
  });
  return {};
}

void print_report(const output::RunReport& report, const std::string& out, bool json) {
  const double rate = static_cast<double>(report.pictures) / std::max(1e-9, report.seconds);
  if (json) {
    std::printf("%s\n", nlohmann::ordered_json{{"recording", out},
                                               {"frames", report.frames},
                                               {"video_frames", report.video_frames},
                                               {"pictures", report.pictures},
                                               {"bytes", report.bytes},
                                               {"seconds", report.seconds},
                                               {"pictures_per_s", rate}}
                            .dump(2)
                            .c_str());
    return;
  }
  std::printf("%s: %lld frames, %lld pictures, %.0f MB in %.0f s (%.1f pictures/s)\n", out.c_str(),
              static_cast<long long>(report.frames), static_cast<long long>(report.pictures),
              static_cast<double>(report.bytes) / 1e6, report.seconds, rate);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Simulates a match from a scene and writes it as a recording with its truth"};
  app.footer(
      "The same scene and seed give the same bytes at any number of threads. OUT appears when it "
      "is\n"
      "whole; an interrupted run leaves nothing. Keys of a scene: tools/README.md.\n\n"
      "Example:\n"
      "  touchline-sim tests/data/scenes/penalty.toml out/penalty\n"
      "  tools/replay out/penalty out/s\n"
      "  touchline-score --recording out/penalty --session out/s\n\n"
      "Exit codes: 0 recorded; 1 something failed or was interrupted; 2 arguments or scene.");
  std::string scene_file, out, size;
  std::vector<std::string> cameras;
  std::optional<std::uint64_t> seed;
  std::optional<std::int64_t> frames;
  std::string assets = TOUCHLINE_SIM_ASSETS;
  if (const char* set = std::getenv("TOUCHLINE_SIM_ASSETS")) assets = set;
  output::RunOptions options;
  options.threads = static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, 256U));
  bool json = false, check = false;
  app.add_option("scene", scene_file, "scene TOML")->required();
  app.add_option("out", out, "folder of the recording to make");
  app.add_option("--seed", seed, "another match of the same scene");
  app.add_option("--frames", frames, "so many frames instead of the scene's")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1000000}));
  app.add_option("--cameras", cameras, "these cameras only, e.g. m1,f1")->delimiter(',');
  app.add_option("--size", size, "WxH of every camera instead of the scene's");
  app.add_option("--threads", options.threads, "that render")
      ->check(CLI::Range(1, 256))
      ->capture_default_str();
  app.add_flag("--force", options.force, "replace a recording that is there");
  app.add_flag("--check", check, "only read the scene and say whether it is sound");
  app.add_flag("--json", json, "print the report as JSON");
  app.add_option("--assets", assets, "folder of bodies and motions")->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  auto scene = scene::load_scene(scene_file);
  if (!scene) return failed(scene.error());
  if (seed) scene->seed = *seed;
  if (frames) scene->frames = *frames;
  if (auto status = choose_cameras(*scene, cameras); !status) return failed(status.error());
  if (!size.empty()) {
    int width = 0, height = 0;
    if (!parse_size(size, width, height) || width < 64 || height < 64 || width > 8192 ||
        height > 8192) {
      return failed({base::ErrorKind::kArgument, "--size", "'" + size + "' is no picture size",
                     "give WIDTHxHEIGHT, such as 1280x720"});
    }
    for (auto& camera : scene->cameras) camera = camera::resized(camera, width, height);
  }
  if (auto status = scene::validate(*scene); !status) return failed(status.error());
  if (check) {
    std::printf("%s: %zu people and groups, %zu cameras, %lld frames\n", scene_file.c_str(),
                scene->cast.people.size() + scene->cast.groups.size(), scene->cameras.size(),
                static_cast<long long>(scene->frames));
    return 0;
  }
  if (out.empty()) {
    return failed({base::ErrorKind::kArgument, "OUT", "is missing",
                   "give the folder of the recording to make"});
  }
  const auto match = output::simulated_match(*scene, assets);
  if (!match) return failed(match.error());

  std::stop_source source;
  options.stop = source.get_token();
  std::signal(SIGINT, interrupt);
  std::signal(SIGTERM, interrupt);
  const bool terminal = ::isatty(STDERR_FILENO) == 1;
  const auto began = std::chrono::steady_clock::now();
  auto shown = began;
  options.progress = [&](std::int64_t done, std::int64_t total) {
    if (interrupted != 0) source.request_stop();
    const auto now = std::chrono::steady_clock::now();
    if (!terminal || (now - shown < std::chrono::milliseconds(500) && done < total)) return;
    shown = now;
    const double seconds = std::chrono::duration<double>(now - began).count();
    const double rate = static_cast<double>(done) / std::max(0.1, seconds);
    std::fprintf(stderr, "\r%lld of %lld pictures, %.1f/s, %.0f s to go   ",
                 static_cast<long long>(done), static_cast<long long>(total), rate,
                 static_cast<double>(total - done) / std::max(0.01, rate));
  };
  const auto report = output::record(*scene, **match, out, options);
  if (terminal) std::fprintf(stderr, "\n");
  if (!report) return failed(report.error());
  print_report(*report, out, json);
  return 0;
}
