#include "hub/command/control_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <thread>
#include <vector>

#include "hub/command/order.h"
#include "tests/support/folders.h"

namespace touchline::command {
namespace {

constexpr std::chrono::seconds kPatience{60};

class Served {
 public:
  explicit Served(const std::filesystem::path& path) {
    auto opened = ControlSocket::open(path);
    EXPECT_TRUE(opened) << base::to_string(opened.error());
    if (!opened) return;
    thread_ = std::jthread([this, socket = std::move(*opened)](std::stop_token stop) mutable {
      socket.serve(
          [this](const std::string& line) {
            lines.push_back(line);
            return "heard " + line;
          },
          stop);
    });
  }
  void stop() { thread_ = {}; }
  std::vector<std::string> lines;  // to be read after stop()

 private:
  std::jthread thread_;
};

TEST(ControlSocket, AnswersEveryClientInTurn) {
  const support::TempFolder folder;
  Served hub(folder / "hub.sock");
  std::vector<std::string> expected;
  for (int i = 0; i < 20; ++i) {
    const std::string line = "m1 key click " + std::to_string(i) + " 3";
    expected.push_back(line);
    const auto reply = ask(folder / "hub.sock", line, kPatience);
    ASSERT_TRUE(reply) << base::to_string(reply.error());
    EXPECT_EQ(*reply, "heard " + line);
  }
  hub.stop();
  EXPECT_EQ(hub.lines, expected);
  EXPECT_FALSE(std::filesystem::exists(folder / "hub.sock"));
}

TEST(ControlSocket, ALineWithoutEndIsCutOffAndTheNextClientServed) {
  const support::TempFolder folder;
  Served hub(folder / "hub.sock");
  EXPECT_FALSE(ask(folder / "hub.sock", std::string(100'000, 'x'), kPatience));
  const auto reply = ask(folder / "hub.sock", "again", kPatience);
  ASSERT_TRUE(reply);
  EXPECT_EQ(*reply, "heard again");
}

TEST(ControlSocket, TellsWhatIsThere) {
  const support::TempFolder folder;
  std::ofstream(folder / "file") << "precious";
  const auto file = ControlSocket::open(folder / "file");
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_EQ(std::filesystem::file_size(folder / "file"), 8u);
  const Served hub(folder / "hub.sock");
  const auto second = ControlSocket::open(folder / "hub.sock");
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().kind, base::ErrorKind::kUnavailable);
  EXPECT_TRUE(ask(folder / "hub.sock", "still there", kPatience));
  EXPECT_FALSE(ControlSocket::open(folder / std::string(200, 'x')));
  const auto nobody = ask(folder / "nobody.sock", "hello", kPatience);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().kind, base::ErrorKind::kUnavailable);
}

TEST(ParseOrder, TakesCameraKindAndText) {
  const auto order = parse_order("  m1   key  click 640 360 \n");
  ASSERT_TRUE(order) << base::to_string(order.error());
  EXPECT_EQ(*order, (wire::CommandMessage{"m1", wire::CommandKind::kKeyTraining, "click 640 360"}));
  for (const char* line : {"", "m1", "m1 key", "m1 lock click 3 4", "m/1 key undo", "key undo"})
    EXPECT_FALSE(parse_order(line)) << line;
}

}  // namespace
}  // namespace touchline::command
