#include "edge/key/training_order.h"

#include <fmt/format.h>

#include <charconv>
#include <optional>
#include <utility>
#include <vector>

namespace touchline::key {
namespace {

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const std::size_t begin = text.find_first_not_of(" \t\r\n");
    if (begin == std::string_view::npos) return words;
    text.remove_prefix(begin);
    const std::size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
    words.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
}

template <typename T>
std::optional<T> number(std::string_view word) {
  T value{};
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, value);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return value;
}

tl::unexpected<base::Error> refused(std::string_view text, std::string what) {
  return base::fail(base::ErrorKind::kArgument, "key", fmt::format("'{}' {}", text, what),
                    "say click X Y, colour #3a7d2c, undo, radii R1 R2, clear, save or load");
}

std::string counted(const ColourTraining& training) {
  return fmt::format("{} colours", training.background.size());
}

base::Result<std::string> add(image::Rgb8 colour, ColourTraining& training) {
  if (!training.click(colour)) {
    return base::fail(base::ErrorKind::kLimit, "key",
                      fmt::format("there are {} colours, no more fit", ColourTraining::kMost),
                      "take some back, or make r1 larger");
  }
  return fmt::format("key: {} is background, {}", colour_text(colour), counted(training));
}

struct Obey {
  const image::Frame* newest;
  const std::filesystem::path& file;
  ColourTraining& training;

  base::Result<std::string> operator()(const ClickOrder& order) const {
    if (newest == nullptr) {
      return base::fail(base::ErrorKind::kUnavailable, "key", "no frame has come yet",
                        "click when the picture runs");
    }
    const auto colour = colour_at(*newest, order.x, order.y);
    if (!colour) return base::fail(colour.error());
    return add(*colour, training);
  }
  base::Result<std::string> operator()(const ColourOrder& order) const {
    return add(order.colour, training);
  }
  base::Result<std::string> operator()(const RadiiOrder& order) const {
    ColourTraining changed = training;
    changed.r1 = order.r1;
    changed.r2 = order.r2;
    if (auto status = changed.validate(); !status) return base::fail(status.error());
    training = std::move(changed);
    return fmt::format("key: r1 {}, r2 {}", training.r1, training.r2);
  }
  base::Result<std::string> operator()(PlainOrder order) const {
    switch (order) {
      case PlainOrder::kUndo:
        if (!training.undo()) {
          return base::fail(base::ErrorKind::kArgument, "key", "there is no click to take back");
        }
        return fmt::format("key: one taken back, {}", counted(training));
      case PlainOrder::kClear:
        training.background.clear();
        return std::string("key: no colours");
      case PlainOrder::kSave:
      case PlainOrder::kLoad:
        break;
    }
    if (file.empty()) {
      return base::fail(base::ErrorKind::kConfiguration, "key.colours",
                        "this unit has no file for its colours",
                        "name one as `colours` in the [key] of the unit's configuration");
    }
    if (order == PlainOrder::kSave) {
      if (auto status = save_colour_training(file, training); !status)
        return base::fail(status.error());
      return fmt::format("key: {} saved in {}", counted(training), file.string());
    }
    auto loaded = load_colour_training(file);
    if (!loaded) return base::fail(loaded.error());
    training = std::move(*loaded);
    return fmt::format("key: {} from {}", counted(training), file.string());
  }
};

}  // namespace

base::Result<TrainingOrder> parse_training_order(std::string_view text) {
  const std::vector<std::string_view> words = words_of(text);
  if (words.empty()) return refused(text, "says nothing");
  const std::string_view verb = words[0];
  const auto wants = [&](std::size_t count) { return words.size() == count + 1; };
  if (verb == "click") {
    const auto x = wants(2) ? number<int>(words[1]) : std::nullopt;
    const auto y = wants(2) ? number<int>(words[2]) : std::nullopt;
    if (!x || !y) return refused(text, "has no pixel");
    return ClickOrder{*x, *y};
  }
  if (verb == "colour") {
    const auto colour = wants(1) ? colour_of(words[1]) : std::nullopt;
    if (!colour) return refused(text, "has no colour");
    return ColourOrder{*colour};
  }
  if (verb == "radii") {
    const auto r1 = wants(2) ? number<double>(words[1]) : std::nullopt;
    const auto r2 = wants(2) ? number<double>(words[2]) : std::nullopt;
    if (!r1 || !r2) return refused(text, "has no two numbers");
    return RadiiOrder{*r1, *r2};
  }
  constexpr std::pair<std::string_view, PlainOrder> kPlain[] = {{"undo", PlainOrder::kUndo},
                                                                {"clear", PlainOrder::kClear},
                                                                {"save", PlainOrder::kSave},
                                                                {"load", PlainOrder::kLoad}};
  for (const auto& [word, order] : kPlain)
    if (verb == word && wants(0)) return order;
  return refused(text, "is not known");
}

base::Result<std::string> obey(const TrainingOrder& order, const image::Frame* newest,
                               const std::filesystem::path& file, ColourTraining& training) {
  return std::visit(Obey{newest, file, training}, order);
}

}  // namespace touchline::key
