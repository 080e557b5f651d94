#include "shared/recording/csv_internal.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>

namespace touchline::recording {
namespace {

namespace fs = std::filesystem;

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

template <typename T>
std::optional<T> parse(std::string_view field) {
  T value{};
  const auto [end, code] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (code != std::errc{} || end != field.data() + field.size()) return std::nullopt;
  return value;
}

}  // namespace

base::Result<std::string> read_file(const fs::path& path, std::uintmax_t most_bytes) {
  std::error_code code;
  if (!fs::is_regular_file(path, code)) {
    return base::fail(base::ErrorKind::kNotFound, path.string(), "there is no such file");
  }
  const std::uintmax_t size = fs::file_size(path, code);
  if (!code && size > most_bytes) {
    return base::fail(base::ErrorKind::kLimit, path.string(),
                      "has " + std::to_string(size) + " bytes",
                      "at most " + std::to_string(most_bytes) + " are read");
  }
  std::ifstream in(path, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) {
    return base::fail(base::ErrorKind::kIo, path.string(), "cannot be read",
                      "check its permissions");
  }
  return text;
}

base::Status write_file(const fs::path& path, std::string_view text) {
  fs::path part = path;
  part += ".part";
  std::error_code code;
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out.write(text.data(), static_cast<std::streamsize>(text.size()));
    out.flush();
    if (!out) {
      fs::remove(part, code);
      return base::fail(base::ErrorKind::kIo, path.string(), "cannot be written",
                        "check the folder, its permissions and the space on the disk");
    }
  }
  fs::rename(part, path, code);
  if (code) {
    const std::string why = code.message();
    fs::remove(part, code);
    return base::fail(base::ErrorKind::kIo, path.string(), "cannot be written: " + why);
  }
  return {};
}

std::vector<CsvLine> csv_lines(std::string_view text) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
    text.remove_prefix(kByteOrderMark.size());
  }
  std::vector<CsvLine> lines;
  for (int number = 1; !text.empty(); ++number) {
    const auto end = text.find('\n');
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty()) continue;
    CsvLine& entry = lines.emplace_back();
    entry.number = number;
    for (;;) {
      const auto comma = line.find(',');
      entry.fields.push_back(trimmed(line.substr(0, comma)));
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
  }
  return lines;
}

std::optional<double> parse_real(std::string_view field) {
  const auto value = parse<double>(field);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> parse_whole(std::string_view field) {
  return parse<std::int64_t>(field);
}

}  // namespace touchline::recording
