// Folders that tests use: one to write in, one to read recordings from.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace touchline::support {

// A fresh folder, gone with all that is in it at destruction.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

// Recordings and clips outside the repository: TOUCHLINE_DATA, else ../shared/data beside the
// working directory of the tests. Nothing where there is none; tests then skip.
std::optional<std::filesystem::path> data_folder();

std::string read_text(const std::filesystem::path& path);
void write_text(const std::filesystem::path& path, std::string_view text);

}  // namespace touchline::support
