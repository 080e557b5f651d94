#include "tools/score/session_exports.h"

#include <gtest/gtest.h>

#include "tests/unit/tools/score/true_exports.h"

namespace touchline::score {
namespace {

namespace fs = std::filesystem;

// A program in the hub's place that writes down how it was called.
fs::path fake_hub(const support::TempFolder& folder, const std::string& last_line) {
  const fs::path path = folder / "hub";
  support::write_text(
      path, "#!/bin/sh\necho \"$@\" >> " + (folder / "calls").string() + "\n" + last_line + "\n");
  fs::permissions(path, fs::perms::owner_all);
  return path;
}

TEST(ExportSession, AsksForWhatTheTruthKnows) {
  const TrueExports exports;
  const support::TempFolder folder;
  ExportOptions options;
  options.hub = fake_hub(folder, "exit 0");
  options.session = folder.path();
  options.out = folder / "out";
  options.mode = "hull";
  const auto status = export_session(exports.truth(), options);
  ASSERT_TRUE(status) << to_string(status.error());
  const std::string calls = support::read_text(folder / "calls");
  for (const char* kind : {"cameras", "mattes", "hull", "people"}) {
    EXPECT_NE(calls.find(std::string("export ") + kind + " --session"), std::string::npos) << kind;
  }
  EXPECT_NE(calls.find("--mode hull"), std::string::npos);
  EXPECT_NE(calls.find("--foreground"), std::string::npos);
  // The path has the rows with a clean picture: 0, 4 and 8.
  const auto path = recording::read_camera_table(options.out / "paths/virtual01.csv");
  ASSERT_TRUE(path) << to_string(path.error());
  ASSERT_EQ(path->size(), 3U);
  EXPECT_EQ((*path)[1].frame, 4);
}

TEST(ExportSession, NamesTheCommandThatFails) {
  const TrueExports exports;
  const support::TempFolder folder;
  ExportOptions options;
  options.hub = fake_hub(folder, "exit 3");
  options.session = folder.path();
  options.out = folder / "out";
  const auto failed = export_session(exports.truth(), options);
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().where.find("export cameras"), std::string::npos);
  EXPECT_NE(failed.error().what.find("exit code 3"), std::string::npos);
  options.hub = folder / "none";
  EXPECT_FALSE(export_session(exports.truth(), options));
  options.session = folder / "nothing";
  EXPECT_EQ(export_session(exports.truth(), options).error().kind, base::ErrorKind::kArgument);
}

}  // namespace
}  // namespace touchline::score
