#include "shared/wire/link_options.h"

#include <gtest/gtest.h>

namespace touchline::wire {
namespace {

TEST(LinkOptions, DefaultsAreValidAndStayOnTheMachine) {
  const LinkOptions options;
  EXPECT_TRUE(options.validate());
  EXPECT_EQ(options.interfaces, std::vector<std::string>{"127.0.0.1"});
  EXPECT_EQ(options.peers, std::vector<std::string>{"127.0.0.1"});
}

TEST(LinkOptions, AnErrorNamesFieldAndValue) {
  LinkOptions options;
  options.domain = 231;
  EXPECT_EQ(options.validate().error().where, "link.domain");
  EXPECT_NE(options.validate().error().what.find("231"), std::string::npos);
  options = {};
  options.interfaces = {};
  EXPECT_EQ(options.validate().error().where, "link.interfaces");
  for (const char* address :
       {"", "10.0.0", "10.0.0.256", "10.0.0.1.2", "eth0", "1..2.3", "1.2.3."}) {
    options = {};
    options.peers = {address};
    EXPECT_FALSE(options.validate()) << address;
  }
  options = {};
  options.tag = "a*b";  // would match other tags
  EXPECT_EQ(options.validate().error().where, "link.tag");
  options = {};
  options.lease = std::chrono::milliseconds(10);
  EXPECT_EQ(options.validate().error().where, "link.lease");
}

}  // namespace
}  // namespace touchline::wire
