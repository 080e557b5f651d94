// touchline-score: what a session exported, against what is true.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <opencv2/core.hpp>
#include <string>
#include <system_error>

#include "shared/recording/recording.h"
#include "tools/score/page/page.h"
#include "tools/score/report.h"
#include "tools/score/session_exports.h"
#include "tools/score/sets/set_report.h"
#include "tools/score/truth.h"

namespace {

using namespace touchline;  // NOLINT: this file is the program

// The real sets are looked for in $TOUCHLINE_DATA, else ../shared/data.
std::filesystem::path data_folder() {
  const char* stated = std::getenv("TOUCHLINE_DATA");
  return stated != nullptr && *stated != 0 ? stated : "../shared/data";
}

std::string list_of_sets() {
  std::string text;
  for (const score::SetEntry& entry : score::sets()) {
    text += "  " + entry.name + ": " + entry.what + "\n";
  }
  return text.empty() ? "  none\n" : text;
}

int failed(const base::Error& error) {
  std::fprintf(stderr, "touchline-score: %s\n", base::to_string(error).c_str());
  return base::exit_code(error);
}

// A folder for exports that nobody asked to keep; gone at the end.
class ScratchFolder {
 public:
  ScratchFolder() = default;
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder() {
    std::error_code error;
    if (!path_.empty()) std::filesystem::remove_all(path_, error);
  }
  // Empty where none can be made.
  std::filesystem::path make() {
    std::error_code error;
    std::string name = (std::filesystem::temp_directory_path(error) / "touchline-score-XXXXXX");
    if (mkdtemp(name.data()) != nullptr) path_ = name;
    return path_;
  }

 private:
  std::filesystem::path path_;
};

int score_set(const std::string& name, const score::SetOptions& options, bool json) {
  for (const score::SetEntry& entry : score::sets()) {
    if (entry.name != name) continue;
    const auto report = entry.run(options);
    if (!report) return failed(report.error());
    std::printf("%s\n", (json ? score::json_text(*report) : score::table_text(*report)).c_str());
    return 0;
  }
  return failed({base::ErrorKind::kArgument, "set", "there is no set '" + name + "'",
                 "one of these:\n" + list_of_sets()});
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Scores what a session exported against the truth of its recording"};
  app.footer(
      "Exports lie as touchline-hub writes them: DIR/cameras/<id>.csv, DIR/mattes/<id>/%06d.png,\n"
      "DIR/hull/%06d.ply, DIR/people/people.csv, DIR/renders/virtual01/%06d.png, and\n"
      "DIR/foreground/virtual01/%06d.png (render --foreground). With --session they are made "
      "first.\n"
      "What the figures mean: tools/README.md.\n\n"
      "Example:\n"
      "  touchline-score --recording recordings/dev-attack --session out/s\n\n"
      "Exit codes: 0 scored; 1 something could not be read; 2 arguments.");
  std::string recording_folder;
  score::ScoreOptions options;
  score::ExportOptions session;
  bool json = false;
  bool each_person = false;
  app.add_option("--recording", recording_folder, "recording with its truth/");
  app.add_option("--session", session.session, "session to export and score");
  app.add_option("--exports", options.exports,
                 "folder of exports; with --session they are written there and kept");
  app.add_option("--hub", session.hub, "touchline-hub; default: the one beside this program");
  app.add_option("--mode", session.mode, "of renders made from --session: refined, hull, billboard")
      ->check(CLI::IsMember({"refined", "hull", "billboard"}))
      ->capture_default_str();
  app.add_option("--voxel", options.voxel_m, "metres outside the hull that count as inside")
      ->check(CLI::Range(0.0, 0.1))
      ->capture_default_str();
  app.add_option("--mattes", options.most_mattes, "frames of mattes a camera; 0 = all")
      ->capture_default_str();
  app.add_option("--hulls", options.most_hulls, "frames of hulls; 0 = all")->capture_default_str();
  app.add_option("--views", options.most_views, "frames a virtual camera; 0 = all")
      ->capture_default_str();
  app.add_flag("--oracle,!--no-oracle", options.oracle,
               "also score views rendered from true cameras and mattes (default on)");
  app.add_flag("--each-person", each_person, "a row for every person in the table");
  app.add_flag("--json", json, "print JSON");
  score::PageOptions page;
  app.add_option("--html", page.folder,
                 "also write a page with plots and pictures of the worst frames into this folder");
  CLI::App* set = app.add_subcommand("set", "scores a set of real frames");
  std::string set_name;
  score::SetOptions set_options;
  set_options.data = data_folder();
  set->add_option("NAME", set_name, "which set")->required();
  set->add_option("--data", set_options.data, "folder of all sets; default $TOUCHLINE_DATA")
      ->capture_default_str();
  set->add_option("--pictures", set_options.pictures, "folder for pictures of what was found");
  set->add_flag("--json", json, "print JSON");
  set->footer("Sets:\n" + list_of_sets());
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  cv::setNumThreads(1);
  if (*set) return score_set(set_name, set_options, json);
  const bool from_session = !session.session.empty();
  if (recording_folder.empty() || (options.exports.empty() && !from_session)) {
    return failed({base::ErrorKind::kArgument, "touchline-score",
                   "--recording and --session or --exports are missing",
                   "give both, or `set NAME`"});
  }
  const auto recording = recording::load_recording(recording_folder);
  if (!recording) return failed(recording.error());
  const auto truth = score::Truth::open(*recording);
  if (!truth) return failed(truth.error());
  ScratchFolder scratch;
  if (from_session) {
    if (options.exports.empty()) options.exports = scratch.make();
    if (session.hub.empty()) session.hub = score::hub_beside_this_program();
    if (session.hub.empty()) {
      return failed({base::ErrorKind::kArgument, "--hub", "no touchline-hub beside this program",
                     "build it, or name it with --hub"});
    }
    session.out = options.exports;
    session.voxel_m = std::max(options.voxel_m, 0.005);
    const base::Status exported = score::export_session(*truth, session);
    if (!exported) return failed(exported.error());
  }
  if (!std::filesystem::is_directory(options.exports)) {
    return failed({base::ErrorKind::kArgument, options.exports.string(), "is no folder",
                   "give the folder of exports"});
  }
  const auto report = score::score_exports(*recording, *truth, options);
  if (!report) return failed(report.error());
  std::printf("%s\n", (json ? score::json_text(*report)
                            : score::table_text(*report, {.each_person = each_person}))
                          .c_str());
  if (page.folder.empty()) return 0;
  page.exports = options.exports;
  page.voxel_m = options.voxel_m;
  const auto written = score::write_page(*report, *recording, *truth, page);
  return written ? 0 : failed(written.error());
}
