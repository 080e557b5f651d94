// Hub and units in processes of their own over UDP on loopback.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "shared/wire/edge_link.h"
#include "shared/wire/hub_link.h"
#include "tests/integration/wire/test_content.h"

extern char** environ;

namespace touchline::wire {
namespace {

// A wire_test_unit whose standard error is read.
class UnitProcess {
 public:
  explicit UnitProcess(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), TOUCHLINE_WIRE_TEST_UNIT);
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe2(ends.data(), O_CLOEXEC), 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDERR_FILENO);
    posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    EXPECT_EQ(posix_spawn(&pid_, words[0], &actions, nullptr, words.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
    close(ends[1]);
    errors_ = ends[0];
  }
  ~UnitProcess() {
    if (pid_ > 0) {
      kill();
      (void)wait();
    }
  }
  UnitProcess(const UnitProcess&) = delete;
  UnitProcess& operator=(const UnitProcess&) = delete;

  void kill() { ::kill(pid_, SIGKILL); }
  // Exit status, or minus the signal; what it wrote to standard error is then in errors().
  int wait() {
    std::array<char, 4096> buffer{};
    ssize_t got = 0;
    while ((got = read(errors_, buffer.data(), buffer.size())) > 0) {
      text_.append(buffer.data(), static_cast<std::size_t>(got));
    }
    close(errors_);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  const std::string& errors() const { return text_; }

 private:
  pid_t pid_ = -1;
  int errors_ = -1;
  std::string text_;
};

class WireTest : public testing::Test {
 protected:
  // Tests that run at once meet neither in domain nor in tag.
  WireTest()
      : domain_(100 + static_cast<int>(getpid() % 100)),
        tag_(fmt::format("test-{}", getpid())),
        options_(test_options(domain_, tag_)) {}

  void open_hub(const std::vector<std::string>& cameras) {
    std::vector<base::CameraId> ids;
    for (const std::string& camera : cameras) ids.push_back({camera});
    auto hub = HubLink::open(options_, ids);
    ASSERT_TRUE(hub) << base::to_string(hub.error());
    hub_ = *std::move(hub);
  }
  std::unique_ptr<UnitProcess> start(const std::string& camera,
                                     std::vector<std::string> arguments) const {
    arguments.push_back("camera=" + camera);
    arguments.push_back(fmt::format("domain={}", domain_));
    arguments.push_back("tag=" + tag_);
    return std::make_unique<UnitProcess>(std::move(arguments));
  }
  // Takes events until `enough` says so; the content of frames and plate tiles is compared.
  void take(const std::function<bool(const Event&)>& enough) {
    while (true) {
      const std::optional<Event> event = hub_->next();
      ASSERT_TRUE(event);
      if (const auto* frame = std::get_if<FrameMessage>(&*event)) {
        const std::size_t bytes = frame->parts.at(0).bytes.size() + frame->parts.at(1).bytes.size();
        ASSERT_EQ(*frame, test_frame(frame->camera, frame->epoch,
                                     static_cast<std::int64_t>(frames_[frame->camera]),
                                     frame->stamp.media_time_ns, bytes));
        ++frames_[frame->camera];
      } else if (const auto* plate = std::get_if<PlateMessage>(&*event)) {
        ASSERT_EQ(*plate, test_plate(plate->camera, plate->epoch, plate->column, 100'000));
        ++plates_[plate->camera];
      } else if (const auto* end = std::get_if<EndOfStream>(&*event)) {
        EXPECT_EQ(frames_[end->camera], end->frames_sent);
        EXPECT_EQ(plates_[end->camera], end->plates_sent);
        ++ended_;
      } else if (const auto* gone = std::get_if<UnitGone>(&*event)) {
        gone_.push_back(*gone);
      } else if (const auto* refused = std::get_if<UnitRefused>(&*event)) {
        refused_.push_back(*refused);
      }
      if (enough(*event)) return;
    }
  }

  const int domain_;
  const std::string tag_;
  LinkOptions options_;
  std::unique_ptr<HubLink> hub_;
  std::map<std::string, std::uint64_t> frames_;
  std::map<std::string, std::uint64_t> plates_;
  std::vector<UnitGone> gone_;
  std::vector<UnitRefused> refused_;
  int ended_ = 0;
};

TEST_F(WireTest, ThreeUnitsAsFastAsTheyGoLoseNothing) {
  open_hub({"m1", "m2", "m3"});
  std::vector<std::unique_ptr<UnitProcess>> units;
  for (const char* camera : {"m1", "m2", "m3"}) {
    units.push_back(start(camera, {"frames=200", "bytes=60000", "plates=40"}));
  }
  take([&](const Event&) { return ended_ == 3; });
  for (const auto& unit : units) EXPECT_EQ(unit->wait(), 0) << unit->errors();
  for (const char* camera : {"m1", "m2", "m3"}) {
    EXPECT_EQ(frames_[camera], 200u);
    EXPECT_EQ(plates_[camera], 40u);
  }
  EXPECT_EQ(hub_->report().samples_refused, 0u);
}

TEST_F(WireTest, UnitsMayStartBeforeTheHubAndLittleCreditIsEnough) {
  std::vector<std::unique_ptr<UnitProcess>> units;
  for (const char* camera : {"m1", "m2"}) {
    units.push_back(start(camera, {"frames=100", "bytes=200000", "credit=65536"}));
  }
  options_.credit_bytes = 65536;
  open_hub({"m1", "m2"});
  take([&](const Event&) { return ended_ == 2; });
  for (const auto& unit : units) EXPECT_EQ(unit->wait(), 0) << unit->errors();
}

TEST_F(WireTest, TheSecondUnitOfACameraIsRefusedOnBothSidesAndTheFirstGoesOn) {
  open_hub({"m1"});
  const auto first = start("m1", {"frames=1000000", "rate=100"});
  take([&](const Event&) { return frames_["m1"] > 0; });
  const auto second = start("m1", {"frames=5"});
  take([&](const Event&) { return !refused_.empty(); });
  EXPECT_EQ(refused_[0].camera, "m1");
  const std::uint64_t before = frames_["m1"];
  take([&](const Event&) { return frames_["m1"] >= before + 20; });
  EXPECT_EQ(second->wait(), 1);
  EXPECT_NE(second->errors().find("camera \"m1\" is taken"), std::string::npos) << second->errors();
  EXPECT_TRUE(gone_.empty());
}

TEST_F(WireTest, AKilledUnitIsNamedAndTheOthersFinish) {
  open_hub({"m1", "m2"});
  const auto killed = start("m1", {"frames=1000000", "rate=100"});
  // Five seconds: well past the lease of the killed one, so that the hub goes on without it.
  const auto other = start("m2", {"frames=500", "rate=100"});
  take([&](const Event&) { return frames_["m1"] >= 20; });
  killed->kill();
  std::optional<UnitGone> gone;
  take([&](const Event&) {
    for (const UnitGone& each : gone_) {
      if (each.camera == "m1") gone = each;
    }
    return ended_ == 1 && gone.has_value();
  });
  ASSERT_TRUE(gone);
  EXPECT_FALSE(gone->finished);
  EXPECT_EQ(gone->frames_received, frames_["m1"]);
  EXPECT_NE(gone->what.find("\"m1\""), std::string::npos);
  EXPECT_EQ(frames_["m2"], 500u);
  EXPECT_EQ(other->wait(), 0) << other->errors();
  EXPECT_EQ(killed->wait(), -SIGKILL);
}

TEST_F(WireTest, AHubThatGoesEndsItsUnitsWithAnError) {
  open_hub({"m1"});
  const auto unit = start("m1", {"frames=1000000"});
  take([&](const Event&) { return frames_["m1"] >= 10; });
  hub_.reset();
  EXPECT_EQ(unit->wait(), 1);
  EXPECT_NE(unit->errors().find("the hub has gone"), std::string::npos) << unit->errors();
}

TEST_F(WireTest, PeopleOfOneCameraReachTheOthersAndNotItself) {
  open_hub({"m1", "m2"});
  auto first = EdgeLink::open(options_, {"m1"}, 1);
  auto second = EdgeLink::open(options_, {"m2"}, 1);
  ASSERT_TRUE(first && second);
  const PeopleMessage of_first{"m1", 40'000'000, 2, {{10, -20, 0.2F}, {-3, 4, 0.5F}}};
  const PeopleMessage of_second{"m2", 80'000'000, 2, {{7, 8, 0.1F}}};
  // Nothing is sent again: said until both have heard it.
  std::optional<PeopleMessage> at_first, at_second;
  while (!at_first || !at_second) {
    ASSERT_TRUE(hub_->send(of_first));
    ASSERT_TRUE(hub_->send(of_second));
    std::this_thread::yield();
    if (!at_first) at_first = (*first)->take_people();
    if (!at_second) at_second = (*second)->take_people();
  }
  EXPECT_EQ(*at_first, of_second);
  EXPECT_EQ(*at_second, of_first);
  EXPECT_FALSE(hub_->send(PeopleMessage{"m1", 0, 0, {{0, 0, -1}}}));
}

TEST_F(WireTest, AUnitUnderAnotherTagFindsNoHub) {
  open_hub({"m1"});
  LinkOptions other = options_;
  other.tag = "elsewhere";
  auto unit = EdgeLink::open(other, {"m1"}, 1);
  ASSERT_TRUE(unit);
  const base::Status found = (*unit)->wait_for_hub(std::chrono::milliseconds(300));
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().kind, base::ErrorKind::kTimeout);
  const base::Status sent = (*unit)->send(test_frame("m1", 1, 0, 0, 100));
  ASSERT_FALSE(sent);
  EXPECT_EQ(sent.error().kind, base::ErrorKind::kUnavailable);
}

TEST_F(WireTest, AnInterfaceThatIsNotThereIsNamed) {
  options_.interfaces = {"192.0.2.77"};  // of the block for documentation (RFC 5737)
  const auto unit = EdgeLink::open(options_, {"m1"}, 1);
  ASSERT_FALSE(unit);
  EXPECT_EQ(unit.error().kind, base::ErrorKind::kConfiguration);
  EXPECT_NE(unit.error().what.find("192.0.2.77"), std::string::npos);
}

TEST_F(WireTest, CommandsReachTheirUnit) {
  open_hub({"m1", "m2"});
  auto unit = EdgeLink::open(options_, {"m2"}, 1);
  ASSERT_TRUE(unit);
  take([](const Event& event) { return std::holds_alternative<UnitAppeared>(event); });
  ASSERT_TRUE((*unit)->wait_for_hub(std::chrono::seconds(30)));
  EXPECT_EQ(hub_->send({"m1", CommandKind::kTally, "on"}).error().kind, base::ErrorKind::kNotFound);
  ASSERT_TRUE(hub_->send({"m2", CommandKind::kTally, "on"}));
  // The stream's completion comes after the command on the same topic.
  std::jthread hub_side([&] { take([&](const Event&) { return ended_ == 1; }); });
  ASSERT_TRUE((*unit)->finish());
  const std::optional<CommandMessage> command = (*unit)->take_command();
  ASSERT_TRUE(command);
  EXPECT_EQ(*command, (CommandMessage{"m2", CommandKind::kTally, "on"}));
  EXPECT_FALSE((*unit)->take_command());
}

TEST_F(WireTest, LiveAHubThatComesLateGetsThePlatesAndTheNewFrames) {
  options_.mode = Mode::kLive;
  auto unit = EdgeLink::open(options_, {"m1"}, 1);
  ASSERT_TRUE(unit);
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE((*unit)->send(test_plate("m1", 1, i, 100'000)));
    ASSERT_TRUE((*unit)->send(test_frame("m1", 1, i, 0, 30'000)));
  }
  EXPECT_EQ((*unit)->report().frames_alone, 5u);
  open_hub({"m1"});
  take([&](const Event&) { return plates_["m1"] == 5; });
  ASSERT_TRUE((*unit)->wait_for_hub(std::chrono::seconds(30)));
  ASSERT_TRUE((*unit)->send(test_frame("m1", 1, 0, 0, 30'000)));
  take([&](const Event&) { return frames_["m1"] == 1; });
  ASSERT_TRUE((*unit)->finish());
  take(
      [&](const Event& event) { return std::holds_alternative<EndOfStream>(event) || ended_ > 0; });
}

}  // namespace
}  // namespace touchline::wire
