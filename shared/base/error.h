// What went wrong, where, and what the reader can do about it.
#pragma once

#include <string>
#include <string_view>

namespace touchline::base {

enum class ErrorKind {
  kArgument,       // command line
  kConfiguration,  // a file the user wrote: TOML, calibration, recording.toml
  kNotFound,       // a file, a camera, a frame
  kIo,             // the operating system refused: disk full, permission
  kFormat,         // bytes that are not what they claim to be
  kTruncated,      // bytes that end too early
  kLimit,          // larger than a stated bound
  kUnsupported,    // understood, and not handled by this version
  kTimeout,
  kCancelled,
  kUnavailable,  // a peer or device that is not there at present
  kNumerical,    // an estimator without an answer
  kInternal,
};

// An error is made where it happens and handled once: logged or passed on.
struct Error {
  ErrorKind kind = ErrorKind::kInternal;
  std::string where;  // file, file:line, camera, field
  std::string what;   // what is wrong, with the values
  std::string cure;   // what to do; may be empty where there is nothing
};

// "where: what (cure)" in one line.
std::string to_string(const Error& error);
std::string_view name(ErrorKind kind);

// Exit status of a program that ends with this error: 2 for arguments and configuration (a service
// manager must not retry), else 1.
int exit_code(const Error& error);

}  // namespace touchline::base
