#include "hub/command/control_socket.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

namespace touchline::command {
namespace {

constexpr int kWaiting = 8;      // clients that may wait for their turn
constexpr int kIdleMs = 10'000;  // a client that says nothing for so long makes room
constexpr mode_t kOwnerAndGroup = 0660;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }

 private:
  int fd_;
};

base::Error io_error(const std::filesystem::path& path, const char* what) {
  return {base::ErrorKind::kIo, path.string(), fmt::format("{}: {}", what, std::strerror(errno)),
          "check the folder and its rights"};
}

base::Result<sockaddr_un> address_of(const std::filesystem::path& path) {
  sockaddr_un out{};
  out.sun_family = AF_UNIX;
  const std::string text = path.string();
  if (text.empty() || text.size() >= sizeof out.sun_path) {
    return base::fail(base::ErrorKind::kConfiguration, text,
                      fmt::format("a socket's path has 1 to {} bytes, this {}",
                                  sizeof out.sun_path - 1, text.size()),
                      "choose a shorter one, such as /run/touchline/hub.sock");
  }
  std::memcpy(out.sun_path, text.c_str(), text.size() + 1);
  return out;
}

int connected(const sockaddr_un& address) {
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  const int reason = errno;
  ::close(fd);
  errno = reason;
  return -1;
}

bool send_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

// Waits for bytes or the end of the other side; false after the time, or once `wake` is readable.
bool readable(int fd, int wake, int timeout_ms) {
  pollfd both[] = {{fd, POLLIN, 0}, {wake, POLLIN, 0}};
  while (true) {
    const int ready = ::poll(both, wake >= 0 ? 2 : 1, timeout_ms);
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0 && both[1].revents == 0;
  }
}

// The next line, without its end; nothing when the client is done, silent or too long.
std::optional<std::string> read_line(int fd, int wake, int timeout_ms, std::string& pending) {
  while (true) {
    if (const std::size_t end = pending.find('\n'); end != std::string::npos) {
      std::string line = pending.substr(0, end);
      pending.erase(0, end + 1);
      return line;
    }
    if (pending.size() > kLongestLine || !readable(fd, wake, timeout_ms)) return std::nullopt;
    char bytes[512];
    const ssize_t got = ::recv(fd, bytes, sizeof bytes, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return std::nullopt;
    pending.append(bytes, static_cast<std::size_t>(got));
  }
}

}  // namespace

base::Result<ControlSocket> ControlSocket::open(const std::filesystem::path& path) {
  const auto address = address_of(path);
  if (!address) return base::fail(address.error());
  struct stat there {};
  if (::lstat(path.c_str(), &there) == 0) {
    if (!S_ISSOCK(there.st_mode)) {
      return base::fail(base::ErrorKind::kConfiguration, path.string(), "is no socket",
                        "choose a path where nothing is");
    }
    if (const Descriptor other(connected(*address)); other.get() >= 0) {
      return base::fail(base::ErrorKind::kUnavailable, path.string(),
                        "another program listens there", "stop the other hub, or choose another");
    }
    ::unlink(path.c_str());
  }
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return base::fail(io_error(path, "no socket"));
  Descriptor listening(fd);
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&*address), sizeof *address) != 0)
    return base::fail(io_error(path, "cannot be made"));
  ControlSocket out(::fcntl(fd, F_DUPFD_CLOEXEC, 0), path);
  if (::chmod(path.c_str(), kOwnerAndGroup) != 0 || out.socket_ < 0 ||
      ::listen(out.socket_, kWaiting) != 0)
    return base::fail(io_error(path, "cannot be listened at"));
  return out;
}

ControlSocket::ControlSocket(ControlSocket&& other) noexcept
    : socket_(std::exchange(other.socket_, -1)), path_(std::move(other.path_)) {}

ControlSocket& ControlSocket::operator=(ControlSocket&& other) noexcept {
  std::swap(socket_, other.socket_);
  std::swap(path_, other.path_);
  return *this;
}

ControlSocket::~ControlSocket() {
  if (socket_ < 0) return;
  ::close(socket_);
  ::unlink(path_.c_str());
}

void ControlSocket::serve(const std::function<std::string(const std::string&)>& answer,
                          std::stop_token stop) {
  const Descriptor wake(::eventfd(0, EFD_CLOEXEC));
  if (wake.get() < 0) return;
  const std::stop_callback waker(stop, [&] { ::eventfd_write(wake.get(), 1); });
  while (!stop.stop_requested()) {
    if (!readable(socket_, wake.get(), -1)) continue;
    const Descriptor client(::accept4(socket_, nullptr, nullptr, SOCK_CLOEXEC));
    if (client.get() < 0) continue;
    std::string pending;
    while (const auto line = read_line(client.get(), wake.get(), kIdleMs, pending)) {
      if (!send_all(client.get(), answer(*line) + "\n")) break;
    }
  }
}

base::Result<std::string> ask(const std::filesystem::path& path, const std::string& line,
                              std::chrono::milliseconds timeout) {
  const auto address = address_of(path);
  if (!address) return base::fail(address.error());
  const Descriptor hub(connected(*address));
  if (hub.get() < 0) {
    return base::fail(base::ErrorKind::kUnavailable, path.string(),
                      fmt::format("no hub listens there: {}", std::strerror(errno)),
                      "start it with --control and this path");
  }
  if (!send_all(hub.get(), line + "\n")) return base::fail(io_error(path, "cannot be written to"));
  std::string pending;
  auto reply = read_line(hub.get(), -1, static_cast<int>(timeout.count()), pending);
  if (!reply) {
    return base::fail(base::ErrorKind::kTimeout, path.string(), "the hub did not answer",
                      "look at its log");
  }
  return std::move(*reply);
}

}  // namespace touchline::command
