#include "shared/runtime/service.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <string>
#include <thread>

namespace touchline::runtime {
namespace {

using std::chrono::microseconds;
using std::chrono::steady_clock;

class Descriptor {
 public:
  Descriptor() = default;
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void reset(int fd) { fd_ = fd; }
  int get() const { return fd_; }

 private:
  int fd_ = -1;
};

base::Status system_failure(const char* call) {
  return base::fail(base::ErrorKind::kIo, call, std::strerror(errno));
}

// A status line may not hold a newline: the next line would be another variable.
std::string one_line(std::string_view text) {
  std::string line(text);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

void notify(const std::string& message) { sd_notify(0, message.c_str()); }

void notify_with_status(std::string message, std::string_view status) {
  if (!status.empty()) message += "STATUS=" + one_line(status) + "\n";
  if (!message.empty()) notify(message);
}

}  // namespace

class Service::Impl {
 public:
  Impl() = default;
  ~Impl();
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  base::Status start();
  void alive();

  std::stop_source stop;
  microseconds watchdog{};

 private:
  void watch();

  sigset_t signals_{};
  sigset_t mask_before_{};
  bool mask_changed_ = false;
  Descriptor signal_fd_;
  Descriptor end_fd_;
  std::thread watcher_;
  std::atomic<steady_clock::rep> last_ping_ = 0;
};

base::Status Service::Impl::start() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  end_fd_.reset(eventfd(0, EFD_CLOEXEC));
  if (end_fd_.get() < 0) return system_failure("eventfd");
  signal_fd_.reset(signalfd(-1, &signals_, SFD_CLOEXEC | SFD_NONBLOCK));
  if (signal_fd_.get() < 0) return system_failure("signalfd");
  errno = pthread_sigmask(SIG_BLOCK, &signals_, &mask_before_);
  if (errno != 0) return system_failure("pthread_sigmask");
  mask_changed_ = true;
  std::uint64_t period_us = 0;
  if (sd_watchdog_enabled(0, &period_us) > 0) {
    watchdog = microseconds(static_cast<microseconds::rep>(period_us));
  }
  watcher_ = std::thread([this] { watch(); });
  return {};
}

Service::Impl::~Impl() {
  if (watcher_.joinable()) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(end_fd_.get(), &one, sizeof one);
    watcher_.join();
  }
  if (mask_changed_) pthread_sigmask(SIG_SETMASK, &mask_before_, nullptr);
}

void Service::Impl::watch() {
  std::array<pollfd, 2> events{pollfd{signal_fd_.get(), POLLIN, 0},
                               pollfd{end_fd_.get(), POLLIN, 0}};
  for (;;) {
    if (poll(events.data(), events.size(), -1) < 0 && errno != EINTR) return;
    if ((events[1].revents & POLLIN) != 0) return;
    signalfd_siginfo info{};
    if (read(signal_fd_.get(), &info, sizeof info) != static_cast<ssize_t>(sizeof info)) continue;
    // From here on this thread takes the signals as the system means them: the second one ends the
    // program.
    events[0].fd = -1;
    pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);
    stop.request_stop();
  }
}

void Service::Impl::alive() {
  if (watchdog.count() == 0) return;
  const auto now = steady_clock::now().time_since_epoch();
  auto last = last_ping_.load();
  if (last != 0 && now - steady_clock::duration(last) < watchdog / 2) return;
  if (last_ping_.compare_exchange_strong(last, now.count())) notify("WATCHDOG=1\n");
}

Service::Service(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Service::~Service() = default;

base::Result<std::unique_ptr<Service>> Service::start() {
  auto impl = std::make_unique<Impl>();
  if (auto status = impl->start(); !status) return base::fail(status.error());
  return std::unique_ptr<Service>(new Service(std::move(impl)));
}

std::stop_token Service::stop_token() const { return impl_->stop.get_token(); }
void Service::request_stop() { impl_->stop.request_stop(); }
void Service::ready(std::string_view status) { notify_with_status("READY=1\n", status); }
void Service::status(std::string_view status) { notify_with_status("", status); }
void Service::stopping(std::string_view status) { notify_with_status("STOPPING=1\n", status); }
void Service::alive() { impl_->alive(); }
microseconds Service::watchdog_period() const { return impl_->watchdog; }

}  // namespace touchline::runtime
