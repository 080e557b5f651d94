// Log lines for people and for the journal: standard error, with systemd's priority prefix when the
// journal reads it.
#pragma once

#include <string_view>

namespace touchline::base {

enum class LogLevel { kDebug, kInfo, kWarning, kError };

// `program` is put before each line. Call once in main; without it lines go out at kInfo without a
// name.
void start_log(std::string_view program, LogLevel least);
void log(LogLevel level, std::string_view line);
inline void log_info(std::string_view line) { log(LogLevel::kInfo, line); }
inline void log_warning(std::string_view line) { log(LogLevel::kWarning, line); }
inline void log_error(std::string_view line) { log(LogLevel::kError, line); }

}  // namespace touchline::base
