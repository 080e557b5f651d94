#include "tools/score/session_exports.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

#include "shared/recording/camera_table.h"

extern "C" char** environ;

namespace touchline::score {

namespace fs = std::filesystem;

namespace {

// Runs a program to its end; what it prints to standard output is dropped, errors are shown.
base::Status run(const std::vector<std::string>& command) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t pid = 0;
  const int spawned = posix_spawn(&pid, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  const std::string line = fmt::format("{}", fmt::join(command, " "));
  if (spawned != 0) {
    return base::fail(base::ErrorKind::kArgument, command.front(),
                      std::generic_category().message(spawned),
                      "build touchline-hub, or name it with --hub");
  }
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno == EINTR) continue;
    return base::fail(base::ErrorKind::kIo, line, std::generic_category().message(errno));
  }
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return {};
  return base::fail(base::ErrorKind::kIo, line,
                    WIFEXITED(status) ? fmt::format("exit code {}", WEXITSTATUS(status))
                                      : fmt::format("ended by signal {}", WTERMSIG(status)),
                    "its message is above");
}

base::Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return {};
  return base::fail(base::ErrorKind::kIo, folder.string(), "cannot be made: " + error.message(),
                    "choose a folder that can be written");
}

// The rows of a virtual camera that have a clean picture, as a path for `render`.
base::Status write_path(const Truth& truth, const base::CameraId& id, const fs::path& path) {
  const auto rows = recording::read_camera_table(truth.root() / id.value / "cameras.csv");
  if (!rows) return base::fail(rows.error());
  const std::vector<std::int64_t> clean = truth.clean_frames(id);
  std::vector<recording::CameraRow> wanted;
  for (const recording::CameraRow& row : *rows) {
    if (std::binary_search(clean.begin(), clean.end(), row.frame)) wanted.push_back(row);
  }
  return recording::write_camera_table(path, wanted);
}

}  // namespace

base::Status export_session(const Truth& truth, const ExportOptions& options) {
  std::error_code error;
  if (!fs::is_directory(options.session, error)) {
    return base::fail(base::ErrorKind::kArgument, options.session.string(), "is no folder",
                      "give a session as tools/replay leaves it");
  }
  const std::string session = options.session.string();
  const std::string voxel = fmt::format("{}", options.voxel_m);
  std::vector<std::string> kinds = {"cameras", "mattes"};
  if (!truth.mesh_frames().empty()) kinds.emplace_back("hull");
  if (truth.has_people()) kinds.emplace_back("people");
  for (const std::string& kind : kinds) {
    const fs::path out = options.out / kind;
    if (base::Status status = make_folder(out); !status) return status;
    std::vector<std::string> command = {
        options.hub.string(), "export", kind, "--session", session, "--out", out.string()};
    if (kind == "hull" || kind == "people") command.insert(command.end(), {"--voxel", voxel});
    if (base::Status status = run(command); !status) return status;
  }
  for (const base::CameraId& id : truth.virtual_cameras()) {
    if (truth.clean_frames(id).empty()) continue;
    if (base::Status status = make_folder(options.out / "paths"); !status) return status;
    const fs::path path = options.out / "paths" / (id.value + ".csv");
    if (base::Status status = write_path(truth, id, path); !status) return status;
    for (const char* folder : {"renders", "foreground"}) {
      const fs::path out = options.out / folder / id.value;
      if (base::Status status = make_folder(out); !status) return status;
      std::vector<std::string> command = {options.hub.string(),
                                          "render",
                                          "--session",
                                          session,
                                          "--path",
                                          path.string(),
                                          "--mode",
                                          options.mode,
                                          "--out",
                                          out.string(),
                                          "--voxel",
                                          voxel};
      if (std::string_view(folder) == "foreground") command.emplace_back("--foreground");
      if (base::Status status = run(command); !status) return status;
    }
  }
  return {};
}

fs::path hub_beside_this_program() {
  std::error_code error;
  const fs::path own = fs::read_symlink("/proc/self/exe", error);
  if (error) return {};
  const fs::path hub = own.parent_path() / "touchline-hub";
  return fs::exists(hub, error) ? hub : fs::path();
}

}  // namespace touchline::score
