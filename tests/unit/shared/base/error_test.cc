#include "shared/base/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "shared/base/result.h"

namespace touchline::base {
namespace {

using testing::HasSubstr;

TEST(Error, SaysWhereWhatAndCure) {
  const std::string line =
      to_string(Error{ErrorKind::kFormat, "recording.toml:7", "unknown key", "remove it"});
  EXPECT_THAT(line, HasSubstr("recording.toml:7"));
  EXPECT_THAT(line, HasSubstr("unknown key"));
  EXPECT_THAT(line, HasSubstr("remove it"));
  EXPECT_THAT(line, testing::Not(HasSubstr("\n")));
}

TEST(Error, OnlyArgumentsAndConfigurationExitWithTwo) {
  std::set<std::string_view> names;
  for (int kind = 0; kind <= static_cast<int>(ErrorKind::kInternal); ++kind) {
    const auto as_kind = static_cast<ErrorKind>(kind);
    const bool two = as_kind == ErrorKind::kArgument || as_kind == ErrorKind::kConfiguration;
    EXPECT_EQ(exit_code(Error{as_kind, "", "", ""}), two ? 2 : 1);
    names.insert(name(as_kind));
  }
  EXPECT_EQ(names.size(), static_cast<std::size_t>(ErrorKind::kInternal) + 1);
}

TEST(Result, CarriesTheErrorOn) {
  const Result<int> failed = fail(ErrorKind::kIo, "disk", "is full");
  ASSERT_FALSE(failed);
  const Status passed_on = fail(failed.error());
  EXPECT_EQ(passed_on.error().kind, ErrorKind::kIo);
  EXPECT_EQ(passed_on.error().where, "disk");
}

}  // namespace
}  // namespace touchline::base
