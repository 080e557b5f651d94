#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/unit/hub/session/session_fixture.h"

namespace touchline::session {
namespace {

using samples::everything;
using testing::HasSubstr;
namespace fs = std::filesystem;

SessionWriter create(const fs::path& folder, const SessionInfo& info = samples::info(),
                     const WriterOptions& options = {}) {
  auto writer = SessionWriter::create(folder, info, options);
  EXPECT_TRUE(writer) << to_string(writer.error());
  return std::move(*writer);
}

SessionReader open(const fs::path& folder) {
  auto reader = SessionReader::open(folder);
  EXPECT_TRUE(reader) << to_string(reader.error());
  return std::move(*reader);
}

TEST(Session, GivesBackWhatWasWritten) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  const codec::EncodedView view = samples::view("m1", 2);
  ASSERT_TRUE(writer.append(view));
  ASSERT_TRUE(writer.append(Event{{5}, {"m1"}, "status", "{\"fps\":25}"}));
  ASSERT_TRUE(writer.finish());

  const SessionReader reader = open(temp / "s");
  EXPECT_TRUE(reader.report().finished);
  EXPECT_EQ(reader.report().unindexed_bytes, 0u);
  EXPECT_EQ(reader.info().name, "friendly");
  EXPECT_EQ(reader.info().sizes.length_m, 104.5);
  EXPECT_FALSE(reader.info().sizes.width_m);
  EXPECT_EQ(reader.info().cameras, samples::info().cameras);
  EXPECT_EQ(reader.info().start_timecode, samples::info().start_timecode);
  ASSERT_EQ(reader.instants().size(), 1u);
  EXPECT_EQ(reader.instants()[0].ns, 80'000'000);
  EXPECT_EQ(reader.frame_number(0), 2);
  const auto set = reader.frame_set(0);
  ASSERT_TRUE(set);
  const auto& back = std::get<codec::EncodedView>(set->entries[0].view);
  EXPECT_EQ(back.id, view.id);
  EXPECT_EQ(back.stamp, view.stamp);
  EXPECT_EQ(back.parts, view.parts);
  EXPECT_EQ(back.estimate.model, view.estimate.model);
  EXPECT_EQ(back.estimate.covariance, view.estimate.covariance);
  EXPECT_EQ(back.estimate.evidence, view.estimate.evidence);
  EXPECT_EQ(back.estimate.cam_from_world.translation, view.estimate.cam_from_world.translation);
  EXPECT_EQ((*reader.events())[0].text, "{\"fps\":25}");
  EXPECT_FALSE(reader.frame_set(1));
}

TEST(Session, DoesNotDependOnTheOrderOfArrival) {
  const support::TempFolder temp;
  SessionWriter one = create(temp / "one");
  SessionWriter two = create(temp / "two");
  std::vector<codec::EncodedView> views;
  for (std::uint64_t i = 0; i < 6; ++i) {
    views.push_back(samples::view("m1", i));
    if (i % 4 != 3) views.push_back(samples::view("f1", i));
  }
  for (const auto& view : views) ASSERT_TRUE(one.append(view));
  ASSERT_TRUE(one.append(Event{{1}, {"m1"}, "mark", "a"}));
  ASSERT_TRUE(one.append(Event{{1}, {"f1"}, "mark", "b"}));
  ASSERT_TRUE(two.append(Event{{1}, {"f1"}, "mark", "b"}));
  ASSERT_TRUE(two.append(Event{{1}, {"m1"}, "mark", "a"}));
  for (auto it = views.rbegin(); it != views.rend(); ++it) ASSERT_TRUE(two.append(*it));
  ASSERT_TRUE(one.finish());
  ASSERT_TRUE(two.finish());
  EXPECT_EQ(everything(open(temp / "one")), everything(open(temp / "two")));
}

TEST(Session, SaysWhyACameraIsAbsent) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  for (const std::uint64_t i : {0, 1, 2, 3, 4, 5}) {
    ASSERT_TRUE(writer.append(samples::view("m1", i)));
  }
  for (const std::uint64_t i : {1, 3}) ASSERT_TRUE(writer.append(samples::view("f1", i)));
  ASSERT_TRUE(writer.finish());
  const SessionReader reader = open(temp / "s");
  const auto reason = [&](std::size_t i) {
    return std::get<scene::Absent>(reader.frame_set(i)->entries[1].view).reason;
  };
  EXPECT_EQ(reason(0), scene::AbsentReason::kNotYet);
  EXPECT_EQ(reason(2), scene::AbsentReason::kLostInTransit);
  EXPECT_EQ(reason(4), scene::AbsentReason::kEnded);
}

TEST(Session, MatchesByMediaTimeWithinTheTolerance) {
  const support::TempFolder temp;
  SessionInfo info = samples::info();
  info.start.reset();
  info.tolerance_ns = 5'000'000;
  SessionWriter writer = create(temp / "s", info);
  codec::EncodedView view = samples::view("m1", 0);
  view.stamp.media_time.ns = 1'000'000'000;
  ASSERT_TRUE(writer.append(view));
  view = samples::view("f1", 0);
  view.stamp.media_time.ns = 1'004'000'000;
  ASSERT_TRUE(writer.append(view));
  view = samples::view("f1", 1);
  view.stamp.media_time.ns = 1'047'000'000;
  ASSERT_TRUE(writer.append(view));
  // A second epoch nearer to the instant takes it.
  view = samples::view("f1", 0);
  view.id.epoch = 2;
  view.stamp.media_time.ns = 999'000'000;
  ASSERT_TRUE(writer.append(view));
  ASSERT_TRUE(writer.finish());
  const SessionReader reader = open(temp / "s");
  ASSERT_EQ(reader.instants().size(), 1u);
  EXPECT_EQ(reader.instants()[0].ns, 1'000'000'000);
  const auto set = reader.frame_set(0);
  EXPECT_EQ(std::get<codec::EncodedView>(set->entries[1].view).id.epoch, 2u);
}

TEST(Session, FramesBetweenTheInstantsOfAFasterCameraMakeNoInstant) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  for (int frame = 0; frame < 4; ++frame) {
    codec::EncodedView view = samples::view("m1", static_cast<std::uint64_t>(frame));
    view.stamp.media_time.ns = frame * 40'000'000LL;
    ASSERT_TRUE(writer.append(view));
  }
  for (int frame = 0; frame < 8; ++frame) {
    codec::EncodedView view = samples::view("f1", static_cast<std::uint64_t>(frame));
    view.stamp.media_time.ns = frame * 20'000'000LL;
    ASSERT_TRUE(writer.append(view));
  }
  ASSERT_TRUE(writer.finish());
  const SessionReader reader = open(temp / "s");
  ASSERT_EQ(reader.instants().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto set = reader.frame_set(i);
    EXPECT_EQ(std::get<codec::EncodedView>(set->entries[1].view).id.sequence, 2 * i);
  }
}

TEST(Session, KeepsTheFirstOfTwoEqualFrames) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  ASSERT_TRUE(writer.append(samples::view("m1", 0)));
  const std::uint64_t bytes = writer.bytes_written();
  ASSERT_TRUE(writer.append(samples::view("m1", 0)));
  EXPECT_EQ(writer.bytes_written(), bytes);
}

TEST(Session, GivesTheNewestVersionOfEachPlateTile) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  ASSERT_TRUE(writer.append(samples::plate_tile("m1", 5, {0, 0})));
  ASSERT_TRUE(writer.append(samples::plate_tile("m1", 3, {1, -2})));
  ASSERT_TRUE(writer.append(samples::plate_tile("m1", 4, {0, 0})));
  ASSERT_TRUE(writer.finish());
  const auto plates = open(temp / "s").plates();
  ASSERT_TRUE(plates);
  ASSERT_EQ(plates->size(), 1u);
  const image::PlateSnapshot& plate = plates->at({"m1"});
  EXPECT_EQ(plate.version, 5u);
  ASSERT_EQ(plate.tiles.size(), 2u);
  EXPECT_EQ(plate.tiles.at({0, 0})->count, touchline::samples::plate_tile(5).count);
}

TEST(Session, AUnitThatStartedAgainReplacesItsPlate) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  codec::EncodedPlateTile tile = samples::plate_tile("m1", 9, {0, 0});
  tile.epoch = 1;
  ASSERT_TRUE(writer.append(tile));
  tile = samples::plate_tile("m1", 2, {0, 0});
  tile.epoch = 2;
  ASSERT_TRUE(writer.append(tile));
  ASSERT_TRUE(writer.finish());
  const SessionReader reader = open(temp / "s");
  const auto plates = reader.plates();
  ASSERT_TRUE(plates);
  EXPECT_EQ(plates->at({"m1"}).version, 2u);
  EXPECT_TRUE(reader.verify()->sound());
}

TEST(Session, RollsSegments) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s", samples::info(), {.segment_bytes = 4096});
  for (std::uint64_t i = 0; i < 20; ++i) ASSERT_TRUE(writer.append(samples::view("m1", i)));
  ASSERT_TRUE(writer.finish());
  EXPECT_TRUE(fs::exists(temp / "s" / "segment-000003.bin"));
  const SessionReader reader = open(temp / "s");
  const auto report = reader.verify({.decode = true, .limits = {}});
  ASSERT_TRUE(report);
  EXPECT_TRUE(report->sound());
  EXPECT_EQ(report->payloads, 20u);
}

TEST(Session, RefusesToOverwriteUnlessTold) {
  const support::TempFolder temp;
  {
    SessionWriter writer = create(temp / "s");
    ASSERT_TRUE(writer.append(samples::view("m1", 0)));
  }
  const auto again = SessionWriter::create(temp / "s", samples::info());
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().kind, base::ErrorKind::kArgument);
  EXPECT_EQ(open(temp / "s").report().views, 1u);
  EXPECT_TRUE(SessionWriter::create(temp / "s", samples::info(), {.overwrite = true}));
  EXPECT_EQ(open(temp / "s").report().views, 0u);
  // Not a session's file: never deleted.
  support::write_text(temp / "s" / "notes.txt", "keep");
  EXPECT_FALSE(SessionWriter::create(temp / "s", samples::info(), {.overwrite = true}));
  EXPECT_EQ(support::read_text(temp / "s" / "notes.txt"), "keep");
}

TEST(Session, RefusesWrongInformationAndForeignCameras) {
  const support::TempFolder temp;
  SessionInfo info = samples::info();
  info.cameras.push_back(info.cameras[0]);
  EXPECT_FALSE(SessionWriter::create(temp / "s", info));
  info = samples::info();
  info.rate.den = 0;
  EXPECT_FALSE(SessionWriter::create(temp / "s", info));
  SessionWriter writer = create(temp / "t");
  EXPECT_EQ(writer.append(samples::view("x9", 0)).error().where, "x9");
  ASSERT_TRUE(writer.finish());
  EXPECT_FALSE(writer.append(samples::view("m1", 0)));
}

TEST(Session, ReadsWhileItIsWritten) {
  const support::TempFolder temp;
  SessionWriter writer = create(temp / "s");
  ASSERT_TRUE(writer.append(samples::view("m1", 0)));
  const SessionReader early = open(temp / "s");
  EXPECT_FALSE(early.report().finished);
  ASSERT_TRUE(writer.append(samples::view("m1", 1)));
  EXPECT_EQ(early.instants().size(), 1u);
  EXPECT_TRUE(early.frame_set(0));
  EXPECT_EQ(open(temp / "s").instants().size(), 2u);
  EXPECT_TRUE(writer.finish());
  EXPECT_EQ(open(temp / "s").instants().size(), 2u);
}

TEST(Session, NamesMissingSessionsAndOtherFormats) {
  const support::TempFolder temp;
  EXPECT_EQ(SessionReader::open(temp / "none").error().kind, base::ErrorKind::kNotFound);
  { create(temp / "s"); }
  {
    // SQLite keeps the user version at byte 60, high byte first.
    std::fstream index(temp / "s" / "index.sqlite",
                       std::ios::in | std::ios::out | std::ios::binary);
    index.seekp(63);
    index.put(9);
  }
  const auto reader = SessionReader::open(temp / "s");
  ASSERT_FALSE(reader);
  EXPECT_EQ(reader.error().kind, base::ErrorKind::kUnsupported);
  EXPECT_THAT(reader.error().what, HasSubstr("session format 9"));
  support::write_text(temp / "s" / "index.sqlite", "not a database at all, but long enough");
  EXPECT_EQ(SessionReader::open(temp / "s").error().kind, base::ErrorKind::kFormat);
}

}  // namespace
}  // namespace touchline::session
