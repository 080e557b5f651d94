// Sessions that a kill, a full disk or a bad disk has left behind.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>

#include "tests/unit/hub/session/session_fixture.h"

namespace touchline::session {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

void write_session(const fs::path& folder, std::uint64_t frames) {
  auto writer = SessionWriter::create(folder, samples::info());
  ASSERT_TRUE(writer) << to_string(writer.error());
  for (std::uint64_t i = 0; i < frames; ++i) ASSERT_TRUE(writer->append(samples::view("m1", i)));
  ASSERT_TRUE(writer->finish());
}

TEST(SessionDamage, ASegmentCutAnywhereCostsItsLastRecordsOnly) {
  const support::TempFolder temp;
  write_session(temp / "s", 3);
  const fs::path segment = temp / "s" / "segment-000000.bin";
  for (std::uintmax_t size = fs::file_size(segment); size > 0; size = size > 40 ? size - 37 : 0) {
    fs::resize_file(segment, size);
    const auto reader = SessionReader::open(temp / "s");
    ASSERT_TRUE(reader);
    ASSERT_EQ(reader->instants().size(), 3u);
    bool cut = false;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto set = reader->frame_set(i);
      ASSERT_TRUE(set);
      const auto* absent = std::get_if<scene::Absent>(&set->entries[0].view);
      if (absent != nullptr) {
        EXPECT_EQ(absent->reason, scene::AbsentReason::kUndecodable);
      }
      EXPECT_FALSE(cut && absent == nullptr);
      cut = absent != nullptr;
    }
    EXPECT_EQ(reader->verify()->sound(), !cut);
  }
  fs::remove(segment);
  const auto reader = SessionReader::open(temp / "s");
  ASSERT_TRUE(reader);
  EXPECT_THAT(reader->report().missing_segments, testing::ElementsAre("segment-000000.bin"));
}

TEST(SessionDamage, BytesThatNoRowNamesAreReported) {
  const support::TempFolder temp;
  write_session(temp / "s", 2);
  std::ofstream(temp / "s" / "segment-000000.bin", std::ios::app | std::ios::binary) << "torn";
  const auto reader = SessionReader::open(temp / "s");
  ASSERT_TRUE(reader);
  EXPECT_EQ(reader->report().unindexed_bytes, 4u);
  EXPECT_TRUE(reader->verify()->sound());
}

TEST(SessionDamage, VerifyFindsEveryChangedByte) {
  const support::TempFolder temp;
  write_session(temp / "s", 1);
  const fs::path segment = temp / "s" / "segment-000000.bin";
  const std::string good = support::read_text(segment);
  for (std::size_t at = 16; at < good.size(); at += 13) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x40);
    support::write_text(segment, bad);
    const auto report = SessionReader::open(temp / "s")->verify();
    ASSERT_TRUE(report);
    ASSERT_EQ(report->fault_count, 1u) << "byte " << at;
    EXPECT_THAT(report->faults[0].where, HasSubstr("m1 epoch 1 sequence 0"));
  }
}

// Runs `body` in a process of its own and gives its wait status.
template <typename Body>
int in_child(const Body& body) {
  const pid_t child = fork();
  if (child == 0) {
    body();
    _exit(0);
  }
  int status = -1;
  waitpid(child, &status, 0);
  return status;
}

TEST(SessionDamage, AKilledWriterLeavesAReadableSession) {
  const support::TempFolder temp;
  for (const std::uint64_t frames : {0, 1, 5}) {
    const fs::path folder = temp / std::to_string(frames);
    const int status = in_child([&] {
      auto writer = SessionWriter::create(folder, samples::info());
      for (std::uint64_t i = 0; writer && i < frames; ++i) {
        if (!writer->append(samples::view("m1", i))) _exit(3);
      }
      // Half a record, as a kill inside write(2) leaves it.
      if (frames > 0) {
        std::ofstream(folder / "segment-000000.bin", std::ios::app | std::ios::binary) << "TLRC12";
      }
      raise(SIGKILL);
    });
    ASSERT_TRUE(WIFSIGNALED(status));
    const auto reader = SessionReader::open(folder);
    ASSERT_TRUE(reader) << to_string(reader.error());
    EXPECT_FALSE(reader->report().finished);
    EXPECT_EQ(reader->instants().size(), frames);
    EXPECT_EQ(reader->report().unindexed_bytes, frames > 0 ? 6u : 0u);
    EXPECT_TRUE(reader->verify()->sound());
  }
}

TEST(SessionDamage, AFullDiskIsSaidClearlyAndCostsNothingWritten) {
  const support::TempFolder temp;
  const fs::path folder = temp / "s";
  const int status = in_child([&] {
    // Files end at 64 KiB, as if the disk were full there.
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{65536, 65536};
    setrlimit(RLIMIT_FSIZE, &limit);
    auto writer = SessionWriter::create(folder, samples::info());
    if (!writer) _exit(3);
    for (std::uint64_t i = 0; i < 1000; ++i) {
      const base::Status done = writer->append(samples::view("m1", i));
      if (done) continue;
      const bool clear = done.error().kind == base::ErrorKind::kIo && !done.error().where.empty() &&
                         !done.error().cure.empty();
      _exit(clear ? 42 : 4);
    }
    _exit(5);
  });
  ASSERT_TRUE(WIFEXITED(status));
  ASSERT_EQ(WEXITSTATUS(status), 42);
  const auto reader = SessionReader::open(folder);
  ASSERT_TRUE(reader) << to_string(reader.error());
  EXPECT_GT(reader->instants().size(), 3u);
  EXPECT_EQ(reader->report().unindexed_bytes, 0u);
  EXPECT_TRUE(reader->verify({.decode = true, .limits = {}})->sound());
}

TEST(SessionDamage, ADamagedIndexIsAnErrorNotACrash) {
  const support::TempFolder temp;
  write_session(temp / "s", 3);
  const fs::path index = temp / "s" / "index.sqlite";
  const std::string good = support::read_text(index);
  touchline::samples::Numbers numbers(5);
  for (int round = 0; round < 60; ++round) {
    std::string bad = good;
    for (int k = 0; k < 8; ++k) {
      bad[static_cast<std::size_t>(numbers.below(static_cast<int>(bad.size())))] =
          static_cast<char>(numbers.below(256));
    }
    support::write_text(index, bad);
    const auto reader = SessionReader::open(temp / "s");
    if (reader) static_cast<void>(reader->verify());
  }
}

}  // namespace
}  // namespace touchline::session
