#include "shared/base/error.h"

namespace touchline::base {

std::string to_string(const Error& error) {
  std::string text = error.where.empty() ? error.what : error.where + ": " + error.what;
  if (!error.cure.empty()) text += " (" + error.cure + ")";
  return text;
}

std::string_view name(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::kArgument:
      return "argument";
    case ErrorKind::kConfiguration:
      return "configuration";
    case ErrorKind::kNotFound:
      return "not-found";
    case ErrorKind::kIo:
      return "io";
    case ErrorKind::kFormat:
      return "format";
    case ErrorKind::kTruncated:
      return "truncated";
    case ErrorKind::kLimit:
      return "limit";
    case ErrorKind::kUnsupported:
      return "unsupported";
    case ErrorKind::kTimeout:
      return "timeout";
    case ErrorKind::kCancelled:
      return "cancelled";
    case ErrorKind::kUnavailable:
      return "unavailable";
    case ErrorKind::kNumerical:
      return "numerical";
    case ErrorKind::kInternal:
      return "internal";
  }
  return "unknown";
}

int exit_code(const Error& error) {
  return error.kind == ErrorKind::kArgument || error.kind == ErrorKind::kConfiguration ? 2 : 1;
}

}  // namespace touchline::base
