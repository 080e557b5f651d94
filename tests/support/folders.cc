#include "tests/support/folders.h"

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <system_error>

namespace touchline::support {

namespace fs = std::filesystem;

TempFolder::TempFolder() {
  std::string name = (fs::temp_directory_path() / "touchline-XXXXXX").string();
  if (mkdtemp(name.data())) path_ = name;
}

TempFolder::~TempFolder() {
  std::error_code code;
  if (!path_.empty()) fs::remove_all(path_, code);
}

std::optional<fs::path> data_folder() {
  const char* set = std::getenv("TOUCHLINE_DATA");
  const fs::path folder = set ? fs::path(set) : fs::path("../shared/data");
  std::error_code code;
  if (!fs::is_directory(folder, code)) return std::nullopt;
  return folder;
}

std::string read_text(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void write_text(const fs::path& path, std::string_view text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary)
      .write(text.data(), static_cast<std::streamsize>(text.size()));
}

}  // namespace touchline::support
