// touchline-hub: takes in what the edge units send and renders views that no camera shot.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hub/command/control_socket.h"
#include "hub/hub_config.h"
#include "hub/ingest_pipeline.h"
#include "hub/session_export.h"
#include "hub/shot_pipeline.h"
#include "hub/side_findings.h"
#include "shared/base/log.h"
#include "shared/recording/camera_table.h"
#include "shared/runtime/service.h"

namespace {

using namespace touchline;  // NOLINT: this file is the program

constexpr const char* kVersion = "0.1.0";

struct Arguments {
  std::string config;
  std::string recording;
  std::vector<std::string> cameras;
  std::string session;
  std::string profile;
  int domain = -1;
  std::string tag;
  std::string control;
  std::vector<std::string> order;
  std::string out;
  std::string path;
  std::string size;
  std::string mode = "refined";
  std::string mp4;
  double voxel_m = 0;
  bool foreground = false;
  bool force = false;
  bool each_start = false;
  bool decode = false;
  bool json = false;
};

int failed(const base::Error& error) {
  std::fprintf(stderr, "touchline-hub: %s\n", base::to_string(error).c_str());
  return base::exit_code(error);
}

// A counter that rewrites its line on a terminal, and is silent elsewhere.
hub::Progress progress(const char* what) {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [what](std::size_t done, std::size_t all) {
    std::fprintf(stderr, "\r%s %zu of %zu%s", what, done, all, done == all ? "\n" : "");
  };
}

// "20261122-143005", UTC: a name for a session that sorts by time.
std::string time_of_start() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  return std::strftime(text, sizeof text, "%Y%m%d-%H%M%S", &utc) > 0 ? text : "session";
}

// Cameras whose side was stated wrongly; none where that cannot be looked at.
std::vector<hub::SideTrouble> turned_cameras(const std::filesystem::path& session) {
  auto shot = hub::Shot::open(session, {});
  if (!shot) return {};
  auto findings = hub::check_sides(*shot);
  return findings ? std::move(findings->troubles) : std::vector<hub::SideTrouble>();
}

nlohmann::ordered_json to_json(const std::vector<hub::SideTrouble>& troubles) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const hub::SideTrouble& trouble : troubles)
    out.push_back({{"id", trouble.camera.value}, {"trouble", trouble.text}});
  return out;
}

int run(const Arguments& arguments) {
  base::Result<hub::HubConfig> config;
  if (!arguments.recording.empty()) {
    auto recording = recording::load_recording(arguments.recording);
    if (!recording) return failed(recording.error());
    config = hub::config_for_recording(*recording, arguments.cameras);
  } else if (!arguments.config.empty()) {
    config = hub::load_hub_config(arguments.config);
  } else {
    return failed({base::ErrorKind::kArgument, "run", "nothing says which cameras there are",
                   "give --config hub.toml, or --recording"});
  }
  if (!config) return failed(config.error());
  if (!arguments.profile.empty()) {
    config->link.mode = arguments.profile == "replay" ? wire::Mode::kReplay : wire::Mode::kLive;
  }
  if (arguments.domain >= 0) config->link.domain = arguments.domain;
  if (!arguments.tag.empty()) config->link.tag = arguments.tag;
  base::start_log("hub", base::LogLevel::kInfo);
  auto service = runtime::Service::start();
  if (!service) return failed(service.error());
  (*service)->ready("waiting for units");
  hub::IngestOptions options;
  options.overwrite = arguments.force;
  options.control = arguments.control;
  std::uint64_t told = 0;
  options.progress = [&](const hub::IngestReport& report) {
    (*service)->alive();
    std::uint64_t frames = 0;
    for (const hub::IngestCamera& camera : report.cameras) frames += camera.frames;
    if (frames >= told + 100) {
      told = frames;
      base::log_info(fmt::format("{} frames of {} cameras, {} instants", frames,
                                 report.cameras.size(), report.instants));
    }
  };
  const std::filesystem::path session = arguments.session;
  const std::filesystem::path folder = arguments.each_start ? session / time_of_start() : session;
  const auto report = hub::ingest(*config, folder, options, (*service)->stop_token());
  (*service)->stopping("");
  if (!report) return failed(report.error());
  const std::vector<hub::SideTrouble> turned = turned_cameras(folder);
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["session"] = folder.string();
    out["complete"] = report->complete();
    out["instants"] = report->instants;
    out["whole_instants"] = report->whole_instants;
    for (const hub::IngestCamera& camera : report->cameras) {
      out["cameras"].push_back({{"id", camera.camera.value},
                                {"ended", camera.ended},
                                {"frames", camera.frames},
                                {"frames_without_calibration", camera.frames_lost_track},
                                {"plate_tiles", camera.plate_tiles},
                                {"bytes", camera.bytes},
                                {"trouble", camera.trouble}});
    }
    out["turned"] = to_json(turned);
    std::printf("%s\n", out.dump().c_str());
  } else {
    for (const hub::IngestCamera& camera : report->cameras) {
      base::log_info(
          fmt::format("{}: {} frames, {} without calibration, {} plate tiles, {:.1f} MB{}{}",
                      camera.camera.value, camera.frames, camera.frames_lost_track,
                      camera.plate_tiles, static_cast<double>(camera.bytes) / 1e6,
                      camera.trouble.empty() ? "" : " TROUBLE: ", camera.trouble));
    }
    for (const hub::SideTrouble& trouble : turned)
      base::log_error(fmt::format("{}: TROUBLE: {}", trouble.camera.value, trouble.text));
    base::log_info(
        fmt::format("{} instants, {} with every camera", report->instants, report->whole_instants));
  }
  return report->complete() ? 0 : 1;
}

base::Result<hub::Shot> open_shot(const Arguments& arguments) {
  hub::ShotOptions options;
  if (arguments.voxel_m > 0) options.hull.voxel_m = arguments.voxel_m;
  return hub::Shot::open(arguments.session, options);
}

int render_pictures(const Arguments& arguments) {
  auto mode = render::parse_mode(arguments.mode);
  if (!mode) return failed(mode.error());
  hub::PathOptions options;
  options.mode = *mode;
  options.foreground = arguments.foreground;
  options.mp4 = arguments.mp4;
  if (!arguments.size.empty()) {
    int width = 0, height = 0;
    char rest = 0;
    if (std::sscanf(arguments.size.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 16 ||
        height < 16 || width > 8192 || height > 8192) {
      return failed({base::ErrorKind::kArgument, "--size",
                     "'" + arguments.size + "' is not a picture size",
                     "write WIDTHxHEIGHT, 16 to 8192 each, e.g. 1280x720"});
    }
    options.size = {width, height};
  }
  const auto path = recording::read_camera_table(arguments.path);
  if (!path) return failed(path.error());
  auto shot = open_shot(arguments);
  if (!shot) return failed(shot.error());
  const auto report = hub::render_path(*shot, *path, arguments.out, options, progress("rendered"));
  if (!report) return failed(report.error());
  for (const std::string& warning : report->warnings)
    std::fprintf(stderr, "touchline-hub: warning: %s\n", warning.c_str());
  const hub::ShotTimes times = shot->times();
  const double n = std::max(1, times.pictures);
  if (arguments.json) {
    nlohmann::ordered_json out = {
        {"pictures", report->pictures},    {"unseen_share", report->unseen_share},
        {"open_s", times.open_s},          {"decode_s_mean", times.decode_s / n},
        {"hull_s_mean", times.hull_s / n}, {"render_s_mean", times.render_s / n},
        {"warnings", report->warnings}};
    std::printf("%s\n", out.dump().c_str());
  } else {
    std::printf(
        "%zu pictures in %s; opening %.2f s, then a picture: decode %.3f s, hull %.3f s, render "
        "%.3f s; %.1f %% unseen\n",
        report->pictures, arguments.out.c_str(), times.open_s, times.decode_s / n, times.hull_s / n,
        times.render_s / n, 100 * report->unseen_share);
  }
  return 0;
}

enum class What { kCameras, kMattes, kHull, kPeople };

int export_session(const Arguments& arguments, What what) {
  auto shot = open_shot(arguments);
  if (!shot) return failed(shot.error());
  const std::filesystem::path out = arguments.out;
  base::Status status;
  switch (what) {
    case What::kCameras:
      status = hub::export_cameras(*shot, out, progress("cameras"));
      break;
    case What::kMattes:
      status = hub::export_mattes(*shot, out, progress("mattes"));
      break;
    case What::kHull:
      status = hub::export_hull(*shot, out, progress("hulls"));
      break;
    case What::kPeople:
      status = hub::export_people(*shot, out, progress("people"));
      break;
  }
  return status ? 0 : failed(status.error());
}

int tell(const Arguments& arguments) {
  std::string line;
  for (const std::string& word : arguments.order) line += (line.empty() ? "" : " ") + word;
  const auto reply = command::ask(arguments.control, line, std::chrono::seconds(10));
  if (!reply) return failed(reply.error());
  std::printf("%s\n", reply->c_str());
  return reply->starts_with("sent") ? 0 : 1;
}

int info(const Arguments& arguments) {
  auto session = session::SessionReader::open(arguments.session);
  if (!session) return failed(session.error());
  auto events = session->events();
  if (!events) return failed(events.error());
  struct Count {
    std::size_t frames = 0, lost = 0, mattes = 0, tiles = 0;
    std::size_t bytes = 0;
  };
  std::map<base::CameraId, Count> counts;
  for (std::size_t i = 0; i < session->instants().size(); ++i) {
    auto set = session->frame_set(i);
    if (!set) return failed(set.error());
    for (const scene::FrameSetEntry& entry : set->entries) {
      const auto* view = std::get_if<codec::EncodedView>(&entry.view);
      if (view == nullptr) continue;
      Count& count = counts[entry.camera];
      ++count.frames;
      if (view->estimate.lost()) ++count.lost;
      if (view->find(codec::PartKind::kMatte) != nullptr) ++count.mattes;
      if (view->find(codec::PartKind::kTiles) != nullptr) ++count.tiles;
      for (const codec::EncodedPart& part : view->parts) count.bytes += part.bytes.size();
    }
  }
  const session::SessionInfo& about = session->info();
  const session::OpenReport& report = session->report();
  if (arguments.json) {
    nlohmann::ordered_json out;
    out["name"] = about.name;
    out["frame_rate"] = base::to_string(about.rate);
    out["instants"] = session->instants().size();
    out["finished"] = report.finished;
    out["unindexed_bytes"] = report.unindexed_bytes;
    out["missing_segments"] = report.missing_segments;
    out["plate_tiles"] = report.plate_tiles;
    for (const session::SessionCamera& camera : about.cameras) {
      const Count& c = counts[camera.id];
      out["cameras"].push_back({{"id", camera.id.value},
                                {"role", recording::name(camera.role)},
                                {"side", recording::name(camera.side)},
                                {"frames", c.frames},
                                {"without_calibration", c.lost},
                                {"mattes", c.mattes},
                                {"tiles", c.tiles},
                                {"bytes", c.bytes}});
    }
    for (const session::Event& event : *events) {
      out["events"].push_back({{"time_ns", event.time.ns},
                               {"camera", event.camera.value},
                               {"kind", event.kind},
                               {"text", event.text}});
    }
    std::printf("%s\n", out.dump().c_str());
    return 0;
  }
  std::printf("session    %s (%s), %zu instants at %s, start %s%s\n", about.name.c_str(),
              arguments.session.c_str(), session->instants().size(),
              base::to_string(about.rate).c_str(), base::to_string(about.start_timecode).c_str(),
              report.finished ? "" : ", NOT FINISHED: its hub was stopped");
  if (report.unindexed_bytes > 0)
    std::printf("           %zu bytes of an append that was cut short\n",
                static_cast<std::size_t>(report.unindexed_bytes));
  for (const std::string& segment : report.missing_segments)
    std::printf("MISSING    %s\n", segment.c_str());
  std::printf("%-10s %-8s %-8s %7s %7s %7s %7s %9s\n", "camera", "role", "side", "frames", "lost",
              "mattes", "tiles", "KB/frame");
  for (const session::SessionCamera& camera : about.cameras) {
    const Count& c = counts[camera.id];
    std::printf(
        "%-10s %-8s %-8s %7zu %7zu %7zu %7zu %9.1f\n", camera.id.value.c_str(),
        std::string(recording::name(camera.role)).c_str(),
        std::string(recording::name(camera.side)).c_str(), c.frames, c.lost, c.mattes, c.tiles,
        c.frames == 0 ? 0 : static_cast<double>(c.bytes) / 1e3 / static_cast<double>(c.frames));
  }
  std::printf("plates     %zu tiles\n", report.plate_tiles);
  for (const session::Event& event : *events) {
    if (event.kind == "trouble")
      std::printf("TROUBLE    %s: %s\n", event.camera.value.c_str(), event.text.c_str());
  }
  return 0;
}

int verify(const Arguments& arguments) {
  auto session = session::SessionReader::open(arguments.session);
  if (!session) return failed(session.error());
  session::VerifyOptions options;
  options.decode = arguments.decode;
  const auto report = session->verify(options);
  if (!report) return failed(report.error());
  const std::vector<hub::SideTrouble> turned = turned_cameras(arguments.session);
  if (arguments.json) {
    nlohmann::ordered_json out = {
        {"sound", report->sound()},      {"finished", report->open.finished},
        {"payloads", report->payloads},  {"bytes", report->bytes},
        {"faults", report->fault_count}, {"missing_segments", report->open.missing_segments}};
    for (const session::VerifyFault& fault : report->faults)
      out["fault_list"].push_back({{"where", fault.where}, {"what", fault.what}});
    out["turned"] = to_json(turned);
    std::printf("%s\n", out.dump().c_str());
  } else {
    for (const session::VerifyFault& fault : report->faults)
      std::printf("FAULT %s: %s\n", fault.where.c_str(), fault.what.c_str());
    for (const std::string& segment : report->open.missing_segments)
      std::printf("MISSING %s\n", segment.c_str());
    for (const hub::SideTrouble& trouble : turned)
      std::printf("TROUBLE %s: %s\n", trouble.camera.value.c_str(), trouble.text.c_str());
    std::printf("%s: %zu payloads, %.1f MB, %zu faults%s\n",
                report->sound() ? "sound" : "NOT SOUND", report->payloads,
                static_cast<double>(report->bytes) / 1e6, report->fault_count,
                report->open.finished ? "" : ", not finished");
  }
  return report->sound() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The Touchline hub: takes in what the edge units send, builds the people's hulls and renders "
      "views that no "
      "camera shot."};
  app.footer(
      "example: touchline-hub render --session out/s --path path.csv --mode hull --out "
      "out/pictures --mp4 out/shot.mp4");
  app.require_subcommand(1);
  Arguments arguments;
  const auto session_flag = [&](CLI::App* verb) {
    verb->add_option("--session", arguments.session, "the session's folder")->required();
  };
  const auto json_flag = [&](CLI::App* verb) {
    verb->add_flag("--json", arguments.json, "for machines");
  };
  const auto out_flags = [&](CLI::App* verb) {
    verb->add_option("--out", arguments.out, "folder for the result")->required();
    verb->add_option("--voxel", arguments.voxel_m, "of the hull, metres (default 0.02)")
        ->check(CLI::Range(0.005, 0.2));
  };

  CLI::App* run_verb =
      app.add_subcommand("run", "take in what the units send and keep it as a session");
  session_flag(run_verb);
  json_flag(run_verb);
  run_verb->add_option("--config", arguments.config, "the hub's TOML");
  run_verb->add_option("--recording", arguments.recording,
                       "take cameras and pitch from a recording instead");
  run_verb->add_option("--camera", arguments.cameras,
                       "only this camera of the recording; may be repeated");
  run_verb->add_flag(
      "--each-start", arguments.each_start,
      "a fresh session in a folder inside --session, named by the time of the start");
  run_verb->add_flag("--force", arguments.force, "replace a session that is there");
  run_verb->add_option("--profile", arguments.profile, "live drops the oldest, replay never loses")
      ->check(CLI::IsMember({"live", "replay"}));
  run_verb->add_option("--domain", arguments.domain, "DDS domain")->check(CLI::Range(0, 230));
  run_verb->add_option("--tag", arguments.tag, "units and hub meet only under the same tag");
  run_verb->add_option("--control", arguments.control,
                       "a socket to make, at which `command` reaches this hub");
  run_verb->footer(
      "example: touchline-hub run --config /etc/touchline/hub.toml --session "
      "/var/lib/touchline/session");

  CLI::App* render_verb = app.add_subcommand("render", "pictures of a virtual camera along a path");
  session_flag(render_verb);
  json_flag(render_verb);
  out_flags(render_verb);
  render_verb
      ->add_option("--path", arguments.path,
                   "CSV: frame,fx,fy,cx,cy,k1,k2,qw,qx,qy,qz,tx,ty,tz; a row a picture")
      ->required();
  render_verb->add_option(
      "--size", arguments.size,
      "of the pictures, e.g. 1280x720 (default: as the path's principal points say)");
  render_verb->add_option("--mode", arguments.mode, "refined, hull or billboard");
  render_verb->add_option("--mp4", arguments.mp4, "also write a film");
  render_verb->add_flag("--foreground", arguments.foreground,
                        "people and ball alone, with their coverage");
  render_verb->footer(
      "example: touchline-hub render --session out/s --path path.csv --out out/pictures");

  CLI::App* export_verb =
      app.add_subcommand("export", "cameras, mattes, hulls or people in open formats");
  export_verb->require_subcommand(1);
  export_verb->footer("example: touchline-hub export hull --session out/s --out out/hull");
  std::vector<std::pair<CLI::App*, What>> exports = {
      {export_verb->add_subcommand("cameras", "a CSV for each camera"), What::kCameras},
      {export_verb->add_subcommand("mattes", "a PNG for each camera and frame"), What::kMattes},
      {export_verb->add_subcommand("hull", "a PLY for each frame"), What::kHull},
      {export_verb->add_subcommand("people", "people.csv"), What::kPeople}};
  for (auto& [verb, what] : exports) {
    session_flag(verb);
    out_flags(verb);
  }

  CLI::App* info_verb = app.add_subcommand("info", "what a session holds");
  session_flag(info_verb);
  json_flag(info_verb);
  info_verb->footer("example: touchline-hub info --session out/s");
  CLI::App* verify_verb = app.add_subcommand(
      "verify", "check every payload of a session, and that its cameras agree about people");
  session_flag(verify_verb);
  json_flag(verify_verb);
  verify_verb->add_flag("--decode", arguments.decode, "decode every payload as well");
  verify_verb->footer("example: touchline-hub verify --session out/s --decode");
  CLI::App* command_verb =
      app.add_subcommand("command", "tell a unit something, through a hub that runs");
  command_verb->add_option("--control", arguments.control, "that hub's socket")->required();
  command_verb
      ->add_option("order", arguments.order,
                   "a camera, what of it, and the order: m1 key click 640 360")
      ->required();
  command_verb->footer(
      "orders to a key: click X Y, colour #3a7d2c, undo, radii R1 R2, clear, save, load\n"
      "example: touchline-hub command --control /run/touchline/hub.sock m1 key click 640 360");
  CLI::App* version_verb = app.add_subcommand("version", "print the version");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (*run_verb) return run(arguments);
  if (*render_verb) return render_pictures(arguments);
  if (*info_verb) return info(arguments);
  if (*verify_verb) return verify(arguments);
  if (*command_verb) return tell(arguments);
  if (*version_verb) std::printf("touchline-hub %s\n", kVersion);
  for (const auto& [verb, what] : exports) {
    if (*export_verb && *verb) return export_session(arguments, what);
  }
  return 0;
}
