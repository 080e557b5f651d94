// Scripted timelines: frames of some cameras at some media times, pushed in some order; what comes
// out is written as text, one set a line: "instant: camera@time camera@time ...", "-reason" for an
// absent camera.
#include "hub/synchronise/synchroniser.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace touchline::synchronise {
namespace {

using testing::ElementsAre;

constexpr std::int64_t kMs = 1'000'000;

codec::EncodedView view(const std::string& camera, std::int64_t ms, std::uint64_t sequence,
                        std::uint32_t epoch = 1) {
  codec::EncodedView view;
  view.id = {{camera}, epoch, sequence};
  view.stamp.media_time.ns = ms * kMs;
  return view;
}

std::string describe(const scene::FrameSet& set) {
  std::string line = fmt::format("{}:", set.instant.ns / kMs);
  for (const scene::FrameSetEntry& entry : set.entries) {
    if (const auto* absent = std::get_if<scene::Absent>(&entry.view)) {
      line += fmt::format(" -{}", scene::name(absent->reason));
    } else {
      const auto& present = std::get<codec::EncodedView>(entry.view);
      EXPECT_EQ(present.id.camera, entry.camera);
      line += fmt::format(" {}@{}", entry.camera.value, present.stamp.media_time.ns / kMs);
    }
  }
  return line;
}

class Timeline {
 public:
  explicit Timeline(std::vector<std::string> cameras, SyncMode mode = SyncMode::kReplay,
                    base::FrameRate rate = {25, 1})
      : synchroniser_(ids(cameras), options(mode, rate)) {}

  static SyncOptions options(SyncMode mode, base::FrameRate rate) {
    SyncOptions options;
    options.mode = mode;
    options.rate = rate;
    options.deadline_ns = 100 * kMs;
    return options;
  }
  static std::vector<base::CameraId> ids(const std::vector<std::string>& cameras) {
    std::vector<base::CameraId> ids;
    for (const std::string& camera : cameras) ids.push_back({camera});
    return ids;
  }

  Timeline& push(const std::string& camera, std::int64_t ms, std::uint64_t sequence,
                 std::uint32_t epoch = 1) {
    return take(synchroniser_.push(view(camera, ms, sequence, epoch)));
  }
  // Frames at these times, with sequences from 0.
  Timeline& run(const std::string& camera, const std::vector<std::int64_t>& times) {
    for (std::size_t i = 0; i < times.size(); ++i) push(camera, times[i], i);
    return *this;
  }
  Timeline& advance(std::int64_t ms) { return take(synchroniser_.advance({ms * kMs})); }
  Timeline& end(const std::string& camera) { return take(synchroniser_.end({camera})); }
  Timeline& finish() { return take(synchroniser_.finish()); }
  std::vector<std::string> sets() { return std::exchange(lines_, {}); }
  const CameraSyncReport& report(std::size_t camera) const {
    return synchroniser_.report().cameras[camera];
  }
  const Synchroniser& synchroniser() const { return synchroniser_; }

 private:
  Timeline& take(const std::vector<scene::FrameSet>& sets) {
    for (const scene::FrameSet& set : sets) lines_.push_back(describe(set));
    return *this;
  }
  Synchroniser synchroniser_;
  std::vector<std::string> lines_;
};

TEST(Synchroniser, ReplayWaitsForEveryCameraThatHasNotEnded) {
  Timeline timeline({"a", "b"});
  timeline.run("a", {0, 40, 80});
  EXPECT_THAT(timeline.sets(), ElementsAre());
  timeline.push("b", 0, 0);
  timeline.push("b", 40, 1);
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 b@0", "40: a@40 b@40"));
  EXPECT_EQ(timeline.synchroniser().waiting({"a"}), 1u);
  timeline.end("b");
  EXPECT_THAT(timeline.sets(), ElementsAre("80: a@80 -ended"));
  timeline.finish();
  EXPECT_THAT(timeline.sets(), ElementsAre());
}

TEST(Synchroniser, ReplayDoesNotDependOnArrival) {
  std::mt19937 random(3);
  const std::vector<std::pair<std::string, std::vector<std::int64_t>>> cameras = {
      {"a", {0, 40, 80, 120, 160}}, {"b", {12, 52, 132, 172}}, {"c", {0, 40, 80, 120, 160}}};
  std::vector<std::string> first;
  for (int run = 0; run < 50; ++run) {
    Timeline timeline({"a", "b", "c"});
    std::vector<std::size_t> next(3);
    while (true) {
      std::vector<std::size_t> left;
      for (std::size_t i = 0; i < 3; ++i) {
        if (next[i] < cameras[i].second.size()) left.push_back(i);
      }
      if (left.empty()) break;
      const std::size_t i = left[random() % left.size()];
      timeline.push(cameras[i].first, cameras[i].second[next[i]], next[i]);
      ++next[i];
    }
    timeline.finish();
    const std::vector<std::string> sets = timeline.sets();
    if (run == 0) first = sets;
    EXPECT_EQ(sets, first);
  }
  EXPECT_THAT(first, ElementsAre("0: a@0 b@12 c@0", "40: a@40 b@52 c@40", "80: a@80 -not-yet c@80",
                                 "120: a@120 b@132 c@120", "160: a@160 b@172 c@160"));
}

TEST(Synchroniser, ShuttersThatAreNotLockedTogetherStillMeet) {
  // b runs 15 ms behind, c 15 ms ahead of a.
  Timeline timeline({"a", "b", "c"});
  timeline.run("a", {0, 40, 80}).run("b", {15, 55, 95}).run("c", {25, 65, 105}).finish();
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 b@15 -not-yet", "40: a@40 b@55 c@25",
                                           "80: a@80 b@95 c@65", "105: -ended -ended c@105"));
}

TEST(Synchroniser, TheFastestCameraGivesTheInstants) {
  Timeline timeline({"slow", "fast"}, SyncMode::kReplay, {50, 1});
  timeline.run("slow", {0, 40, 80}).run("fast", {0, 20, 40, 60, 80}).finish();
  EXPECT_THAT(timeline.sets(),
              ElementsAre("0: slow@0 fast@0", "20: -not-yet fast@20", "40: slow@40 fast@40",
                          "60: -not-yet fast@60", "80: slow@80 fast@80"));
}

TEST(Synchroniser, RatesThatDoNotDivideGiveTheNearestFrame) {
  // 30 against 25 frames a second: each 25 Hz frame goes to the nearest 30 Hz instant.
  Timeline timeline({"p", "q"}, SyncMode::kReplay, {30, 1});
  timeline.run("p", {0, 33, 67, 100, 133, 167, 200}).run("q", {0, 40, 80, 120, 160, 200}).finish();
  EXPECT_THAT(timeline.sets(),
              ElementsAre("0: p@0 q@0", "33: p@33 q@40", "67: p@67 q@80", "100: p@100 -not-yet",
                          "133: p@133 q@120", "167: p@167 q@160", "200: p@200 q@200"));
}

TEST(Synchroniser, AMissingFrameIsLostAndTheNextInRankLeads) {
  Timeline timeline({"a", "b"});
  timeline.push("a", 0, 0).push("a", 40, 1).push("a", 120, 3).push("a", 160, 4);
  timeline.run("b", {2, 42, 82, 122, 162}).finish();
  EXPECT_THAT(timeline.sets(),
              ElementsAre("0: a@0 b@2", "40: a@40 b@42", "82: -lost-in-transit b@82",
                          "120: a@120 b@122", "160: a@160 b@162"));
  EXPECT_EQ(timeline.report(0).missing_sequence, 1u);
  EXPECT_EQ(timeline.report(0).gaps, 1u);
  EXPECT_EQ(timeline.report(1).gaps, 0u);
}

TEST(Synchroniser, AFrameBeyondTheToleranceStandsAlone) {
  SyncOptions options = Timeline::options(SyncMode::kReplay, {25, 1});
  options.tolerance_ns = 5 * kMs;
  Synchroniser synchroniser(Timeline::ids({"a", "b"}), options);
  std::vector<std::string> lines;
  const auto take = [&](const std::vector<scene::FrameSet>& sets) {
    for (const scene::FrameSet& set : sets) lines.push_back(describe(set));
  };
  for (int i = 0; i < 2; ++i) {
    take(synchroniser.push(view("a", 40 * i, static_cast<std::uint64_t>(i))));
    take(synchroniser.push(view("b", 40 * i + 6, static_cast<std::uint64_t>(i))));
  }
  take(synchroniser.finish());
  EXPECT_THAT(lines, ElementsAre("0: a@0 -not-yet", "6: -not-yet b@6", "40: a@40 -not-yet",
                                 "46: -ended b@46"));
}

TEST(Synchroniser, ACameraThatNeverStartsIsEndedByTheCaller) {
  Timeline timeline({"a", "b"});
  timeline.run("a", {0, 40}).end("b");
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 -ended", "40: a@40 -ended"));
}

TEST(Synchroniser, TimeThatGoesBackIsCountedAndNotEmitted) {
  Timeline timeline({"a"});
  timeline.push("a", 0, 0).push("a", 40, 1).push("a", 40, 2).push("a", 20, 3).push("a", 80, 2);
  timeline.push("x", 0, 0).finish();
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0", "40: a@40", "80: a@80"));
  EXPECT_EQ(timeline.report(0).disorder, 2u);
  EXPECT_EQ(timeline.synchroniser().report().unknown_camera, 1u);
}

TEST(Synchroniser, LiveEmitsAtTheDeadlineWhetherComplete) {
  Timeline timeline({"a", "b"}, SyncMode::kLive);
  timeline.push("a", 0, 0).push("b", 0, 0).push("a", 40, 1);
  EXPECT_THAT(timeline.sets(), ElementsAre());
  timeline.advance(99);
  EXPECT_THAT(timeline.sets(), ElementsAre());
  timeline.advance(100);
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 b@0"));
  timeline.advance(140);
  EXPECT_THAT(timeline.sets(), ElementsAre("40: a@40 -not-yet"));
  EXPECT_EQ(timeline.report(1).gaps, 1u);
}

TEST(Synchroniser, LiveLateFramesBecomeGapsAndAreCounted) {
  Timeline timeline({"a", "b"}, SyncMode::kLive);
  timeline.push("a", 0, 0).push("b", 0, 0).push("a", 40, 1).push("b", 40, 1).push("a", 80, 2);
  timeline.advance(180);
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 b@0", "40: a@40 b@40", "80: a@80 -late"));
  timeline.push("b", 80, 2).push("b", 120, 3).push("a", 120, 3).advance(220);
  EXPECT_THAT(timeline.sets(), ElementsAre("120: a@120 b@120"));
  EXPECT_EQ(timeline.report(1).late, 1u);
  EXPECT_EQ(timeline.report(1).gaps, 1u);
}

TEST(Synchroniser, LiveAUnitThatRestartsComesBack) {
  Timeline timeline({"a", "b"}, SyncMode::kLive);
  timeline.push("a", 0, 0).push("b", 0, 0).end("b").push("a", 40, 1).advance(140);
  EXPECT_THAT(timeline.sets(), ElementsAre("0: a@0 b@0", "40: a@40 -ended"));
  timeline.push("b", 80, 0, 2).push("a", 80, 2).advance(180);
  EXPECT_THAT(timeline.sets(), ElementsAre("80: a@80 b@80"));
}

// Any number of cameras, rates, phases, jitter, losses and orders of arrival: each pushed frame
// comes out exactly once, each camera's in order, the sets in rising order, every frame within the
// tolerance of its set's instant.
TEST(Synchroniser, ReplayEmitsEveryFrameExactlyOnceInOrder) {
  std::mt19937 random(11);
  const auto below = [&](std::int64_t bound) {
    return std::uniform_int_distribution<std::int64_t>(0, bound - 1)(random);
  };
  for (int run = 0; run < 300; ++run) {
    const std::size_t count = 1 + static_cast<std::size_t>(below(5));
    std::vector<base::CameraId> ids;
    std::vector<std::vector<codec::EncodedView>> frames(count);
    for (std::size_t i = 0; i < count; ++i) {
      ids.push_back({fmt::format("c{}", i)});
      const std::int64_t period =
          std::vector<std::int64_t>{20, 40, 33, 17}[static_cast<std::size_t>(below(4))];
      const std::int64_t phase = below(60);
      const std::int64_t jitter = 1 + below(period);
      std::int64_t last = -1;
      for (std::int64_t k = 0; k < below(40); ++k) {
        if (below(10) == 0) continue;
        const std::int64_t time = std::max(last + 1, phase + period * k + below(jitter));
        last = time;
        frames[i].push_back(view(ids[i].value, time, static_cast<std::uint64_t>(k)));
      }
    }
    const SyncOptions options = Timeline::options(SyncMode::kReplay, {25, 1});
    Synchroniser synchroniser(ids, options);
    std::vector<scene::FrameSet> sets;
    const auto take = [&](std::vector<scene::FrameSet> more) {
      for (scene::FrameSet& set : more) sets.push_back(std::move(set));
    };
    std::vector<std::size_t> next(count);
    std::vector<bool> ended(count);
    while (true) {
      std::vector<std::size_t> left;
      for (std::size_t i = 0; i < count; ++i) {
        if (!ended[i]) left.push_back(i);
      }
      if (left.empty()) break;
      const std::size_t i =
          left[static_cast<std::size_t>(below(static_cast<std::int64_t>(left.size())))];
      if (next[i] < frames[i].size()) {
        take(synchroniser.push(frames[i][next[i]++]));
      } else {
        take(synchroniser.end(ids[i]));
        ended[i] = true;
      }
    }
    take(synchroniser.finish());
    std::vector<std::vector<std::int64_t>> emitted(count);
    for (std::size_t s = 0; s < sets.size(); ++s) {
      ASSERT_TRUE(s == 0 || sets[s - 1].instant < sets[s].instant) << "run " << run;
      ASSERT_EQ(sets[s].entries.size(), count);
      std::size_t present = 0;
      for (std::size_t i = 0; i < count; ++i) {
        const auto* found = std::get_if<codec::EncodedView>(&sets[s].entries[i].view);
        if (found == nullptr) continue;
        ++present;
        EXPECT_LE(std::abs(found->stamp.media_time.ns - sets[s].instant.ns), 20 * kMs);
        emitted[i].push_back(found->stamp.media_time.ns);
      }
      EXPECT_GT(present, 0u);
    }
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<std::int64_t> pushed;
      for (const codec::EncodedView& frame : frames[i]) {
        pushed.push_back(frame.stamp.media_time.ns);
      }
      ASSERT_EQ(emitted[i], pushed) << "run " << run << " camera " << i;
    }
  }
}

TEST(SyncOptions, AnErrorNamesFieldValueAndBound) {
  SyncOptions options;
  EXPECT_TRUE(options.validate());
  options.tolerance_ns = 21 * kMs;
  EXPECT_EQ(options.validate().error().where, "synchronise.tolerance_ns");
  options = {};
  options.deadline_ns = 0;
  EXPECT_EQ(options.validate().error().where, "synchronise.deadline_ns");
  options = {};
  options.rate = {0, 1};
  EXPECT_EQ(options.validate().error().where, "synchronise.rate");
}

}  // namespace
}  // namespace touchline::synchronise
