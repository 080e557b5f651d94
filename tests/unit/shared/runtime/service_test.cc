#include "shared/runtime/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <future>
#include <string>

#include "tests/support/folders.h"

namespace touchline::runtime {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

// A service manager's socket.
class Manager {
 public:
  Manager() {
    const std::string path = (folder_ / "notify").string();
    fd_ = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Manager() {
    close(fd_);
    for (const char* name : {"NOTIFY_SOCKET", "WATCHDOG_USEC", "WATCHDOG_PID"}) unsetenv(name);
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;

  void watch(std::chrono::microseconds period) {
    setenv("WATCHDOG_USEC", std::to_string(period.count()).c_str(), 1);
    setenv("WATCHDOG_PID", std::to_string(getpid()).c_str(), 1);
  }
  // The next message; empty when there is none.
  std::string heard() const {
    std::array<char, 4096> bytes{};
    const ssize_t size = recv(fd_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    return size > 0 ? std::string(bytes.data(), static_cast<std::size_t>(size)) : std::string();
  }

 private:
  support::TempFolder folder_;
  int fd_ = -1;
};

void wait_for(std::stop_token stop) {
  std::promise<void> asked;
  const std::stop_callback callback(stop, [&] { asked.set_value(); });
  asked.get_future().wait();
}

TEST(Service, TellsTheManager) {
  const Manager manager;
  const auto service = Service::start();
  ASSERT_TRUE(service);
  (*service)->ready("6 cameras");
  EXPECT_EQ(manager.heard(), "READY=1\nSTATUS=6 cameras\n");
  (*service)->status("frame 5\nREADY=0");
  EXPECT_EQ(manager.heard(), "STATUS=frame 5 READY=0\n");
  (*service)->stopping("");
  EXPECT_EQ(manager.heard(), "STOPPING=1\n");
}

TEST(Service, IsSilentWithoutAManager) {
  const auto service = Service::start();
  ASSERT_TRUE(service);
  (*service)->ready("nobody listens");
  (*service)->alive();
  EXPECT_EQ((*service)->watchdog_period(), 0us);
}

TEST(Service, PingsTheWatchdogAtTwiceItsRateAtMost) {
  Manager manager;
  manager.watch(24h);
  const auto service = Service::start();
  ASSERT_TRUE(service);
  EXPECT_EQ((*service)->watchdog_period(), 24h);
  for (int i = 0; i < 10; ++i) (*service)->alive();
  EXPECT_EQ(manager.heard(), "WATCHDOG=1\n");
  EXPECT_EQ(manager.heard(), "");
}

TEST(Service, DoesNotPingByItself) {
  Manager manager;
  manager.watch(1us);
  const auto service = Service::start();
  ASSERT_TRUE(service);
  (*service)->ready("");
  EXPECT_EQ(manager.heard(), "READY=1\n");
  EXPECT_EQ(manager.heard(), "");
}

TEST(Service, SignalsRequestTheStop) {
  for (const int signal : {SIGTERM, SIGINT}) {
    const auto service = Service::start();
    ASSERT_TRUE(service);
    EXPECT_FALSE((*service)->stop_token().stop_requested());
    kill(getpid(), signal);
    wait_for((*service)->stop_token());
  }
}

TEST(Service, ProgramCanRequestTheStopItself) {
  const auto service = Service::start();
  ASSERT_TRUE(service);
  (*service)->request_stop();
  EXPECT_TRUE((*service)->stop_token().stop_requested());
}

TEST(ServiceDeathTest, SecondSignalEndsTheProgram) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  const auto hang = [] {
    const auto service = Service::start();
    kill(getpid(), SIGTERM);
    wait_for((*service)->stop_token());
    kill(getpid(), SIGTERM);
    for (;;) pause();
  };
  EXPECT_EXIT(hang(), testing::KilledBySignal(SIGTERM), "");
}

TEST(ServiceDeathTest, SignalsAreTheSystemsAgainAfterwards) {
  testing::GTEST_FLAG(death_test_style) = "threadsafe";
  const auto end = [] {
    Service::start();
    kill(getpid(), SIGINT);
    for (;;) pause();
  };
  EXPECT_EXIT(end(), testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace touchline::runtime
