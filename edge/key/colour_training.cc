#include "edge/key/colour_training.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <system_error>

#include "shared/base/bounds.h"
#include "shared/config/toml_document.h"
#include "shared/image/colour.h"

namespace touchline::key {
namespace {

constexpr std::string_view kFormat = "touchline-key-colours";
constexpr int kVersion = 1;

base::Result<ColourTraining> read(base::Result<config::Document> document) {
  if (!document) return base::fail(document.error());
  config::Table root = document->root();
  ColourTraining out;
  const std::string format = root.required_text("format");
  if (format != kFormat)
    root.reject("format", fmt::format("'{}' is not '{}'", format, kFormat),
                "give the file of a key's colours");
  const auto version = root.required_integer("version");
  if (version != kVersion)
    root.reject("version", fmt::format("{} is not known", version),
                fmt::format("this release reads version {}", kVersion));
  out.r1 = root.number("r1", out.r1, {1, 200});
  out.r2 = root.number("r2", out.r2, {1, 400});
  const std::vector<std::string> words = root.texts("background", {});
  if (words.size() > ColourTraining::kMost)
    root.reject("background", fmt::format("{} colours", words.size()),
                fmt::format("at most {}", ColourTraining::kMost));
  for (const std::string& word : words) {
    const auto colour = colour_of(word);
    if (!colour) {
      root.reject("background", fmt::format("'{}' is no colour", word), "write it as \"#3a7d2c\"");
      break;
    }
    out.background.push_back(*colour);
  }
  if (auto status = document->finish(); !status) return base::fail(status.error());
  if (auto status = out.validate(); !status) return base::fail(status.error());
  return out;
}

}  // namespace

std::optional<image::Rgb8> colour_of(std::string_view text) {
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  unsigned value = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data() + 1, end, value, 16);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return image::Rgb8{static_cast<std::uint8_t>(value >> 16U),
                     static_cast<std::uint8_t>(value >> 8U & 255U),
                     static_cast<std::uint8_t>(value & 255U)};
}

std::string colour_text(image::Rgb8 colour) {
  return fmt::format("#{:02x}{:02x}{:02x}", colour.r, colour.g, colour.b);
}

bool ColourTraining::click(image::Rgb8 colour) {
  if (background.size() >= kMost) return false;
  background.push_back(colour);
  return true;
}

bool ColourTraining::undo() {
  if (background.empty()) return false;
  background.pop_back();
  return true;
}

base::Status ColourTraining::validate() const {
  if (auto s = base::in_bounds("r1", r1, 1, 200); !s) return s;
  if (!(r2 > r1)) return base::out_of_bounds("r2", r2, "above r1");
  if (auto s = base::in_bounds("r2", r2, 1, 400); !s) return s;
  return base::in_bounds("background", static_cast<double>(background.size()), 0, kMost);
}

std::string to_text(const ColourTraining& training) {
  std::string colours;
  for (const image::Rgb8& c : training.background)
    colours += fmt::format("{}\"{}\"", colours.empty() ? "" : ", ", colour_text(c));
  return fmt::format("format = \"{}\"\nversion = {}\nr1 = {}\nr2 = {}\nbackground = [{}]\n",
                     kFormat, kVersion, training.r1, training.r2, colours);
}

base::Result<ColourTraining> parse_colour_training(std::string_view text, const std::string& file) {
  return read(config::Document::parse(text, file));
}

base::Result<ColourTraining> load_colour_training(const std::filesystem::path& path) {
  return read(config::Document::load(path));
}

base::Status save_colour_training(const std::filesystem::path& path,
                                  const ColourTraining& training) {
  std::filesystem::path part = path;
  part += ".part";
  const auto failed = [&](const std::string& what) {
    std::error_code ignored;
    std::filesystem::remove(part, ignored);
    return base::fail(base::ErrorKind::kIo, path.string(), what,
                      "choose a folder that can be written");
  };
  {
    std::ofstream out(part, std::ios::binary | std::ios::trunc);
    out << to_text(training);
    out.close();
    if (!out) return failed("cannot be written");
  }
  std::error_code error;
  std::filesystem::rename(part, path, error);
  if (error) return failed(error.message());
  return {};
}

base::Result<image::Rgb8> colour_at(const image::Frame& frame, int x, int y) {
  if (x < 0 || y < 0 || x >= frame.width() || y >= frame.height()) {
    return base::fail(
        base::ErrorKind::kArgument, "click",
        fmt::format("{},{} is outside the {}x{} picture", x, y, frame.width(), frame.height()),
        "click inside the picture");
  }
  const image::Rect window{std::max(0, x - 1), std::max(0, y - 1),
                           std::min(frame.width() - 1, x + 1) - std::max(0, x - 1) + 1,
                           std::min(frame.height() - 1, y + 1) - std::max(0, y - 1) + 1};
  const image::Image<image::Rgb8> part = image::to_rgb(frame, window);
  int r = 0, g = 0, b = 0;
  for (int j = 0; j < part.height(); ++j) {
    for (int i = 0; i < part.width(); ++i) {
      r += part(i, j).r;
      g += part(i, j).g;
      b += part(i, j).b;
    }
  }
  const int n = part.width() * part.height();
  const auto mean = [&](int sum) { return static_cast<std::uint8_t>((sum + n / 2) / n); };
  return image::Rgb8{mean(r), mean(g), mean(b)};
}

}  // namespace touchline::key
