#include "shared/base/log.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <cstdlib>
#include <string>

namespace touchline::base {
namespace {

spdlog::level::level_enum spdlog_level(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return spdlog::level::debug;
    case LogLevel::kInfo:
      return spdlog::level::info;
    case LogLevel::kWarning:
      return spdlog::level::warn;
    case LogLevel::kError:
      return spdlog::level::err;
  }
  return spdlog::level::info;
}

// sd-daemon(3): a line that starts with <N> is stored with that priority.
std::string_view journal_prefix(LogLevel level) {
  switch (level) {
    case LogLevel::kDebug:
      return "<7>";
    case LogLevel::kInfo:
      return "<6>";
    case LogLevel::kWarning:
      return "<4>";
    case LogLevel::kError:
      return "<3>";
  }
  return "<6>";
}

bool to_journal() {
  static const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  return journal;
}

}  // namespace

void start_log(std::string_view program, LogLevel least) {
  auto logger = spdlog::stderr_color_mt(std::string(program));
  logger->set_level(spdlog_level(least));
  logger->flush_on(spdlog::level::info);
  logger->set_pattern(to_journal() ? "%v" : "%H:%M:%S.%e %n %^%l%$ %v");
  spdlog::set_default_logger(std::move(logger));
}

void log(LogLevel level, std::string_view line) {
  if (to_journal()) {
    spdlog::log(spdlog_level(level), "{}{}", journal_prefix(level), line);
  } else {
    spdlog::log(spdlog_level(level), "{}", line);
  }
}

}  // namespace touchline::base
