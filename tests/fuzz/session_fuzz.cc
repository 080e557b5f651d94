// A session's folder from bytes: the index, then the first segment. The first two bytes say how
// many of the rest are the index.
#include <unistd.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

#include "hub/session/session_reader.h"

namespace {

// In memory where there is such a folder; one for each process, gone with it.
class Folder {
 public:
  Folder() {
    const std::filesystem::path base = std::filesystem::exists("/dev/shm")
                                           ? std::filesystem::path("/dev/shm")
                                           : std::filesystem::temp_directory_path();
    path_ = base / ("touchline-fuzz-" + std::to_string(getpid()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() { std::filesystem::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  void write(const char* name, const std::uint8_t* data, std::size_t size) const {
    std::ofstream out(path_ / name, std::ios::binary);
    for (std::size_t i = 0; i < size; ++i) out.put(static_cast<char>(data[i]));
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  static const Folder folder;
  const std::size_t index = std::min<std::size_t>(size - 2, std::size_t{data[0]} * 256 + data[1]);
  folder.write("index.sqlite", data + 2, index);
  folder.write("segment-000000.bin", data + 2 + index, size - 2 - index);
  const auto reader = touchline::session::SessionReader::open(folder.path());
  if (!reader) return 0;
  for (std::size_t i = 0; i < reader->instants().size() && i < 8; ++i) {
    static_cast<void>(reader->frame_set(i));
  }
  static_cast<void>(reader->plates());
  static_cast<void>(reader->verify());
  return 0;
}
