#include "tools/score/page/plot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tools/score/page/html_text.h"

namespace touchline::score::page {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(RoundTicks, LieWithinAndAreEvenlySpaced) {
  for (const auto& [low, high] :
       {std::pair{0.0, 1.0}, {-3.2, 17.9}, {1e-6, 3e-6}, {99.1, 99.4}, {-1e5, 2e7}}) {
    const auto ticks = round_ticks(low, high, 5);
    ASSERT_GE(ticks.size(), 2U);
    EXPECT_LE(ticks.size(), 8U);
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      EXPECT_GE(ticks[i], low - 1e-6 * (high - low));
      EXPECT_LE(ticks[i], high + 1e-6 * (high - low));
      if (i >= 2) {
        EXPECT_NEAR(ticks[i] - ticks[i - 1], ticks[1] - ticks[0], 1e-6 * (high - low));
      }
    }
  }
  EXPECT_TRUE(round_ticks(1, 1, 5).empty());
  EXPECT_TRUE(round_ticks(0, std::numeric_limits<double>::infinity(), 5).empty());
}

TEST(Plot, LeavesOutWhatIsNoNumber) {
  Plot plot;
  plot.lines = {{"m1", {{0, 1, ""}, {1, std::nan(""), ""}, {2, 3, "#worst"}}, 0.5}};
  const std::string svg = plot_svg(plot);
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
  EXPECT_THAT(svg, Not(HasSubstr("inf")));
  EXPECT_THAT(svg, HasSubstr("href=\"#worst\""));
}

TEST(Plot, OfNothingSaysSo) { EXPECT_THAT(plot_svg({}), HasSubstr("no values")); }

TEST(Plot, OfOneValueOrEqualValuesHasAnAxis) {
  Plot plot;
  plot.lines = {{"m1", {{4, 2, ""}}, std::nullopt}};
  EXPECT_THAT(plot_svg(plot), Not(HasSubstr("nan")));
  plot.lines = {{"m1", {{4, 0, ""}, {5, 0, ""}}, std::nullopt}};
  EXPECT_THAT(plot_svg(plot), Not(HasSubstr("nan")));
}

TEST(Plot, EscapesNames) {
  Plot plot;
  plot.title = "a < b";
  plot.lines = {{"<script>", {{0, 1, ""}, {1, 2, ""}}, std::nullopt}};
  const std::string svg = plot_svg(plot);
  EXPECT_THAT(svg, Not(HasSubstr("<script>")));
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
}

TEST(Interval, OfNoIntervalShowsTheFigureAlone) {
  const std::string svg = interval_svg(std::nan(""), std::nan(""), 3, std::nullopt, 3, 3);
  EXPECT_THAT(svg, HasSubstr("<circle"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(Plan, MarksWhoIsTold) {
  const std::string svg =
      plan_svg({{"p1", 0, 0, false}, {"p2", 20, 5, false}}, {{"q1", 0.3, 0, false}}, 1.5, 52.5, 34);
  EXPECT_THAT(svg, HasSubstr("told 0.30 m away"));
  EXPECT_THAT(svg, HasSubstr("nobody told within reach"));
}

TEST(HtmlText, EscapesAndNames) {
  EXPECT_EQ(escaped("<a href=\"x\">&'"), "&lt;a href=&quot;x&quot;&gt;&amp;&#39;");
  EXPECT_EQ(plain("rms on a 1 m/grid"), "rms_on_a_1_m_grid");
  EXPECT_EQ(figure(1.2345, 2), "1.23");
  EXPECT_EQ(figure(std::nan(""), 2), "&#8211;");
}

}  // namespace
}  // namespace touchline::score::page
