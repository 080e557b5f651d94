// The hub's ear for operators on its own machine: a Unix-domain socket that takes lines and answers
// each with one line. Clients are served one after another.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <stop_token>
#include <string>

#include "shared/base/result.h"

namespace touchline::command {

inline constexpr std::size_t kLongestLine = 4096;  // bytes; longer ones end the connection

class ControlSocket {
 public:
  // Listens at `path`, for its owner and group. A socket that nobody listens at is replaced.
  // Errors: kConfiguration a path too long for a socket or one that is no socket, kUnavailable
  // another program listens there, kIo.
  static base::Result<ControlSocket> open(const std::filesystem::path& path);
  ControlSocket(ControlSocket&& other) noexcept;
  ControlSocket& operator=(ControlSocket&& other) noexcept;
  ~ControlSocket();  // takes the socket away

  // Until a stop is requested. `answer` is given each line without its end, and returns the reply,
  // one line.
  void serve(const std::function<std::string(const std::string&)>& answer, std::stop_token stop);

 private:
  ControlSocket(int socket, std::filesystem::path path) : socket_(socket), path_(std::move(path)) {}
  int socket_ = -1;
  std::filesystem::path path_;
};

// Sends one line to a hub's socket and returns its reply. Errors: kUnavailable nobody listens,
// kTimeout no reply in time, kIo.
base::Result<std::string> ask(const std::filesystem::path& path, const std::string& line,
                              std::chrono::milliseconds timeout);

}  // namespace touchline::command
