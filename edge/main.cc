// touchline-edge: the unit on a camera head.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "edge/edge_config.h"
#include "edge/edge_pipeline.h"
#include "edge/survey_report.h"
#include "edge/take_pictures.h"
#include "shared/base/log.h"
#include "shared/runtime/clock.h"
#include "shared/runtime/service.h"
#include "shared/wire/edge_link.h"

namespace {

using namespace touchline;  // NOLINT: this file is the program

constexpr const char* kVersion = "0.1.0";

// What the command line says; shared by the verbs that need a camera.
struct Arguments {
  std::string config;
  std::string recording;
  std::string camera;
  std::string pace;
  std::string profile;
  int domain = -1;
  std::string tag;
  std::string plate;
  std::string save_plate;
  std::vector<std::string> free_d;
  std::vector<std::string> open_track_io;
  bool json = false;
  bool ids = false;
  bool measure = false;
};

int failed(const base::Error& error) {
  std::fprintf(stderr, "touchline-edge: %s\n", base::to_string(error).c_str());
  return base::exit_code(error);
}

base::Result<edge::EdgeConfig> config_of(const Arguments& arguments) {
  edge::EdgeConfig config;
  if (!arguments.config.empty()) {
    auto loaded = edge::load_edge_config(arguments.config);
    if (!loaded) return base::fail(loaded.error());
    config = std::move(*loaded);
  }
  if (!arguments.recording.empty()) config.recording = arguments.recording;
  if (!arguments.camera.empty()) config.camera.value = arguments.camera;
  if (!arguments.pace.empty())
    config.pace = arguments.pace == "real" ? capture::Pace::kReal : capture::Pace::kFast;
  if (!arguments.profile.empty()) {
    config.link.mode = arguments.profile == "replay" ? wire::Mode::kReplay : wire::Mode::kLive;
  }
  if (arguments.domain >= 0) config.link.domain = arguments.domain;
  if (!arguments.tag.empty()) config.link.tag = arguments.tag;
  if (!arguments.plate.empty()) config.chain.plate_file.load = arguments.plate;
  if (!arguments.save_plate.empty()) config.chain.plate_file.save = arguments.save_plate;
  if (!arguments.free_d.empty()) config.tracking.free_d_to = arguments.free_d;
  if (!arguments.open_track_io.empty()) config.tracking.open_track_io_to = arguments.open_track_io;
  config.tracking.system = config.link.tag;
  if (config.recording.empty()) {
    return base::fail(base::ErrorKind::kArgument, "source", "no source of frames is named",
                      "give --recording, or [source] recording in the unit's TOML");
  }
  if (base::Status status = config.validate(); !status) return base::fail(status.error());
  return config;
}

int run(const Arguments& arguments) {
  auto config = config_of(arguments);
  if (!config) return failed(config.error());
  base::start_log("edge " + config->camera.value, base::LogLevel::kInfo);
  auto service = runtime::Service::start();
  if (!service) return failed(service.error());
  auto recording = recording::load_recording(config->recording);
  if (!recording) return failed(recording.error());
  auto setup = edge::chain_setup(*recording, config->camera);
  if (!setup) return failed(setup.error());
  edge::SurveyStills stills = edge::load_stills(*recording->find(config->camera));
  // The epoch grows each time the unit starts.
  const auto epoch =
      static_cast<std::uint32_t>(std::chrono::duration_cast<std::chrono::seconds>(
                                     std::chrono::system_clock::now().time_since_epoch())
                                     .count());
  runtime::SteadyClock clock;
  auto head = edge::open_head(*config, *recording->find(config->camera), clock);
  if (!head) return failed(head.error());
  capture::RecordingSourceOptions source_options;
  const bool live = config->link.mode == wire::Mode::kLive;
  source_options.pace = config->pace.value_or(live ? capture::Pace::kReal : capture::Pace::kFast);
  auto source =
      capture::RecordingSource::open(*recording, config->camera, epoch, clock, source_options);
  if (!source) return failed(source.error());
  if (!live && setup->kind == edge::HeadKind::kHead && stills.frames.empty()) {
    // A recorded take may be looked through before it is played.
    capture::RecordingSourceOptions fast;
    auto look = capture::RecordingSource::open(*recording, config->camera, epoch, clock, fast);
    if (!look) return failed(look.error());
    stills.take = edge::take_pictures(**look, setup->rate, {}, (*service)->stop_token());
  }
  (*service)->ready("running from a recording");
  auto report = edge::run_edge(*config, *setup, config->recording.string(), **source,
                               std::move(stills), head->get(), epoch, (*service)->stop_token());
  (*service)->stopping("");
  if (!report) return failed(report.error());
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["camera"] = config->camera.value;
    out["frames_read"] = report->frames_read;
    out["frames_sent"] = report->frames_sent;
    out["frames_lost_track"] = report->chain.frames_lost;
    out["frames_by_head"] = report->chain.frames_by_head;
    out["frames_dropped"] = report->frames_dropped;
    out["bytes_sent"] = report->bytes_sent;
    if (config->tracking.any()) {
      out["tracking"] = {{"free_d", report->tracking.free_d},
                         {"open_track_io", report->tracking.open_track_io},
                         {"lost_frames", report->tracking.lost_frames},
                         {"drops", report->tracking.drops}};
    }
    out["survey_rms_px"] = report->chain.survey_rms_px;
    out["detail"] = {{"horizontal", report->chain.detail.horizontal},
                     {"vertical", report->chain.detail.vertical}};
    for (const edge::StageTime& stage : report->chain.stages) {
      if (stage.frames > 0)
        out["stage_ms"][stage.stage] = 1e3 * stage.seconds / static_cast<double>(stage.frames);
    }
    out["trouble"] = report->trouble ? base::to_string(*report->trouble) : "";
    std::printf("%s\n", out.dump().c_str());
  } else {
    std::string stages;
    for (const edge::StageTime& stage : report->chain.stages) {
      if (stage.frames == 0) continue;
      stages += fmt::format(" {} {:.1f}", stage.stage,
                            1e3 * stage.seconds / static_cast<double>(stage.frames));
    }
    base::log_info(
        fmt::format("{} frames read, {} sent, {} without calibration, {:.1f} MB; ms a frame:{}",
                    report->frames_read, report->frames_sent, report->chain.frames_lost,
                    static_cast<double>(report->bytes_sent) / 1e6, stages));
    if (config->tracking.any()) {
      base::log_info(fmt::format("tracking out: {} free-d messages, {} OpenTrackIO samples",
                                 report->tracking.free_d, report->tracking.open_track_io));
    }
  }
  return report->trouble ? 1 : 0;
}

int list(const Arguments& arguments) {
  auto recording = recording::load_recording(arguments.recording);
  if (!recording) return failed(recording.error());
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const recording::CameraEntry& camera : recording->cameras) {
    if (arguments.ids) {
      std::printf("%s\n", camera.id.value.c_str());
    } else if (arguments.json) {
      out.push_back({{"id", camera.id.value},
                     {"role", recording::name(camera.role)},
                     {"side", recording::name(camera.side)},
                     {"width", camera.width},
                     {"height", camera.height},
                     {"frame_rate", base::to_string(camera.rate)},
                     {"survey", !camera.survey.empty()}});
    } else {
      std::printf("%-12s %-8s %-8s %dx%d %s%s\n", camera.id.value.c_str(),
                  std::string(recording::name(camera.role)).c_str(),
                  std::string(recording::name(camera.side)).c_str(), camera.width, camera.height,
                  base::to_string(camera.rate).c_str(), camera.survey.empty() ? "" : " survey");
    }
  }
  if (arguments.json && !arguments.ids) std::printf("%s\n", out.dump().c_str());
  return 0;
}

// One line a check, with what to do where it fails.
class Checks {
 public:
  explicit Checks(bool json) : json_(json) {}
  bool report(const std::string& name, const base::Status& status, const std::string& detail = {}) {
    all_ = all_ && status.has_value();
    if (json_) {
      out_.push_back({{"check", name},
                      {"ok", status.has_value()},
                      {"detail", status ? detail : base::to_string(status.error())}});
    } else {
      std::printf("%-5s %-10s %s\n", status ? "pass" : "FAIL", name.c_str(),
                  (status ? detail : base::to_string(status.error())).c_str());
    }
    return status.has_value();
  }
  int finish() {
    if (json_) std::printf("%s\n", out_.dump().c_str());
    return all_ ? 0 : 1;
  }

 private:
  bool json_;
  bool all_ = true;
  nlohmann::ordered_json out_ = nlohmann::ordered_json::array();
};

template <typename T>
base::Status status_of(const base::Result<T>& result) {
  if (!result) return base::fail(result.error());
  return {};
}

int check(const Arguments& arguments) {
  Checks checks(arguments.json);
  const auto config = config_of(arguments);
  if (!checks.report("config", status_of(config))) return checks.finish();
  const auto recording = recording::load_recording(config->recording);
  if (!checks.report("source", status_of(recording), config->recording.string()))
    return checks.finish();
  const auto setup = edge::chain_setup(*recording, config->camera);
  if (!checks.report("camera", status_of(setup), config->camera.value)) return checks.finish();
  const recording::CameraEntry& entry = *recording->find(config->camera);
  auto reader = recording::VideoReader::open(entry, *recording, 0);
  base::Status video = status_of(reader);
  if (reader) {
    const auto frame = reader->next();
    video = status_of(frame);
    if (frame && !*frame)
      video = base::fail(base::ErrorKind::kFormat, entry.video.string(), "holds no frame",
                         "record it again");
  }
  checks.report("video", video,
                fmt::format("{}x{} {}", entry.width, entry.height, base::to_string(entry.rate)));
  edge::SurveyStills stills = edge::load_stills(entry);
  checks.report(
      "stills",
      stills.troubles.empty() ? base::Status() : base::Status(base::fail(stills.troubles.front())),
      fmt::format("{}", stills.frames.size()));
  if (!stills.frames.empty()) {
    const std::size_t count = stills.frames.size();
    const auto survey = edge::survey_mount(*setup, config->chain, stills.frames);
    checks.report("survey", status_of(survey),
                  survey ? fmt::format("{} of {} stills solved, rms {:.2f} px", survey->solved,
                                       count, survey->rms_px)
                         : "");
  }
  const auto link = wire::EdgeLink::open(config->link, config->camera, 0);
  checks.report("network", status_of(link), fmt::format("DDS domain {}", config->link.domain));
  return checks.finish();
}

// What the installer measured of the pitch, or with --measure nothing.
recording::Recording stated(recording::Recording recording, bool measure) {
  if (measure) recording.sizes = {};
  return recording;
}

int survey(const Arguments& arguments) {
  edge::EdgeConfig config;
  if (!arguments.config.empty()) {
    auto loaded = edge::load_edge_config(arguments.config);
    if (!loaded) return failed(loaded.error());
    config = std::move(*loaded);
  }
  if (!arguments.recording.empty()) config.recording = arguments.recording;
  if (!arguments.camera.empty()) config.camera.value = arguments.camera;
  if (config.recording.empty()) {
    return failed({base::ErrorKind::kArgument, "survey", "no recording is named",
                   "give --recording, or [source] recording in the unit's TOML"});
  }
  auto recording = recording::load_recording(config.recording);
  if (!recording) return failed(recording.error());
  *recording = stated(std::move(*recording), arguments.measure);
  const auto text =
      config.camera.value.empty()
          ? edge::survey_site_report(
                *recording, config.chain, arguments.json,
                [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); })
          : edge::survey_camera_report(*recording, config.camera, config.chain, arguments.json);
  if (!text) return failed(text.error());
  std::fputs(text->c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The Touchline edge unit: calibrates one camera's frames from the pitch lines, keys the "
      "people, and sends "
      "mattes, poses, textures and partial geometry to the hub."};
  app.footer(
      "example: touchline-edge run --recording match --camera m1 --profile replay --domain 7");
  app.require_subcommand(1);
  Arguments arguments;
  const auto source_flags = [&](CLI::App* verb) {
    verb->add_option("--config", arguments.config, "the unit's TOML");
    verb->add_option("--recording", arguments.recording, "a folder with recording.toml");
    verb->add_option("--camera", arguments.camera, "which of its cameras this unit is");
    verb->add_flag("--json", arguments.json, "for machines");
  };
  const auto wire_flags = [&](CLI::App* verb) {
    verb->add_option("--profile", arguments.profile, "live drops the oldest, replay never loses")
        ->check(CLI::IsMember({"live", "replay"}));
    verb->add_option("--domain", arguments.domain, "DDS domain")->check(CLI::Range(0, 230));
    verb->add_option("--tag", arguments.tag, "units and hub meet only under the same tag");
  };
  CLI::App* run_verb = app.add_subcommand("run", "work: take frames in, send what they show");
  source_flags(run_verb);
  wire_flags(run_verb);
  run_verb
      ->add_option("--pace", arguments.pace, "of a recording: wall-clock, or as fast as possible")
      ->check(CLI::IsMember({"real", "max"}));
  run_verb->add_option("--plate", arguments.plate,
                       "go on from the plate that an earlier run saved here, if it is there");
  run_verb->add_option("--save-plate", arguments.save_plate,
                       "save the plate here, now and then and at the end");
  run_verb->add_option("--free-d", arguments.free_d,
                       "address:port that gets free-d D1 messages; may be given again");
  run_verb->add_option("--open-track-io", arguments.open_track_io,
                       "address:port that gets OpenTrackIO samples (239.135.1.N:55555 is usual)");
  run_verb->footer("example: touchline-edge run --config /etc/touchline/unit.toml");
  CLI::App* list_verb = app.add_subcommand("list", "the sources there are");
  list_verb->add_option("--recording", arguments.recording, "a folder with recording.toml")
      ->required();
  list_verb->add_flag("--ids", arguments.ids, "camera ids alone, one a line");
  list_verb->add_flag("--json", arguments.json, "for machines");
  list_verb->footer("example: touchline-edge list --recording match");
  CLI::App* check_verb =
      app.add_subcommand("check", "can this unit work here? one line a check, with a cure");
  source_flags(check_verb);
  wire_flags(check_verb);
  check_verb->footer("example: touchline-edge check --recording match --camera m1");
  CLI::App* survey_verb = app.add_subcommand(
      "survey",
      "mount and lens from survey stills: of one camera, or of all with the size of their pitch");
  source_flags(survey_verb);
  survey_verb->add_flag("--measure", arguments.measure,
                        "find the pitch's size from the stills, whatever the recording states");
  survey_verb->footer("example: touchline-edge survey --recording match --measure");
  CLI::App* version_verb = app.add_subcommand("version", "print the version");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (*run_verb) return run(arguments);
  if (*list_verb) return list(arguments);
  if (*check_verb) return check(arguments);
  if (*survey_verb) return survey(arguments);
  if (*version_verb) std::printf("touchline-edge %s\n", kVersion);
  return 0;
}
