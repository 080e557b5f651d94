#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <system_error>

#include "hub/output/file_internal.h"

namespace touchline::output {

base::Status write_whole(const std::filesystem::path& path, const void* bytes, std::size_t size) {
  const std::filesystem::path partial = path.string() + ".part";
  const auto failed = [&](const char* what) {
    const std::string reason = std::strerror(errno);
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    return base::fail(base::ErrorKind::kIo, path.string(), std::string(what) + ": " + reason,
                      "check that the folder exists, may be written to and has room");
  };
  std::FILE* file = std::fopen(partial.c_str(), "wb");
  if (file == nullptr) return failed("cannot be written");
  bool whole = std::fwrite(bytes, 1, size, file) == size;
  whole = std::fflush(file) == 0 && whole;
  if (!whole) {
    const int reason = errno;
    std::fclose(file);
    errno = reason;
    return failed("was not written whole");
  }
  if (std::fclose(file) != 0) return failed("was not written whole");
  std::error_code error;
  std::filesystem::rename(partial, path, error);
  if (error) {
    errno = error.value();
    return failed("cannot be put in place");
  }
  return {};
}

}  // namespace touchline::output
