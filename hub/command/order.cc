#include "hub/command/order.h"

#include <fmt/format.h>

#include <string>

#include "shared/base/ids.h"

namespace touchline::command {
namespace {

// Takes the first word off `text`.
std::string_view take_word(std::string_view& text) {
  constexpr std::string_view kBlank = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  const std::string_view word = text.substr(0, text.find_first_of(kBlank));
  text.remove_prefix(word.size());
  text.remove_prefix(std::min(text.find_first_not_of(kBlank), text.size()));
  return word;
}

}  // namespace

base::Result<wire::CommandMessage> parse_order(std::string_view line) {
  std::string_view rest = line;
  wire::CommandMessage message;
  message.camera = std::string(take_word(rest));
  const std::string_view kind = take_word(rest);
  while (!rest.empty() && (rest.back() == ' ' || rest.back() == '\n' || rest.back() == '\r'))
    rest.remove_suffix(1);
  message.text = std::string(rest);
  const auto refused = [&](const std::string& what) {
    return base::fail(base::ErrorKind::kArgument, "command", what,
                      "say a camera, what of it, and an order: m1 key click 640 360");
  };
  if (!base::is_valid(base::CameraId{message.camera}))
    return refused(fmt::format("'{}' is no camera", message.camera));
  if (kind != "key") return refused(fmt::format("'{}' is not known", kind));
  if (message.text.empty()) return refused("the order is missing");
  message.kind = wire::CommandKind::kKeyTraining;
  return message;
}

}  // namespace touchline::command
