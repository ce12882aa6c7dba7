#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tools/navigate/decimal_time.hpp"
#include "tools/navigate/plot_data.hpp"
#include "tools/navigate/report_page.hpp"
#include "tools/navigate/run_summary.hpp"

namespace kawara::navigate {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TrajectoryPoint Point(int i, estimation::NavState state = estimation::NavState::kFixed) {
  TrajectoryPoint point{};
  point.time = *ParseSeconds("1000") + core::Milliseconds(10 * i);
  point.position = {0.6, 2.4, 50.0};
  point.state = state;
  return point;
}

TEST(PlotData, ARunOfAnyLengthStaysSmallAndEven) {
  PlotData plot;
  constexpr int kPoints = 1'000'000;
  for (int i = 0; i < kPoints; ++i) plot.Add(Point(i));
  EXPECT_GT(plot.points().size(), 3000U);
  EXPECT_LT(plot.points().size(), 10000U);
  const auto step = plot.points()[1].time - plot.points()[0].time;
  for (std::size_t i = 1; i < plot.points().size(); ++i) {
    ASSERT_EQ(plot.points()[i].time - plot.points()[i - 1].time, step) << i;
  }
  EXPECT_LT(Point(kPoints).time - plot.points().back().time, 2 * step);
}

TEST(PlotData, EveryChangeOfStateIsKept) {
  PlotData plot;
  for (int i = 0; i < 100'000; ++i) {
    plot.Add(
        Point(i, i % 10'000 == 77 ? estimation::NavState::kFloat : estimation::NavState::kFixed));
  }
  EXPECT_EQ(plot.states().size(), 21U);
  EXPECT_EQ(plot.states()[1].state, estimation::NavState::kFloat);
  EXPECT_EQ(plot.states()[1].begin, Point(77).time);
  EXPECT_EQ(plot.states()[1].end, Point(78).time);
}

TEST(ReportPage, NeedsNothingElseAndEscapesWhatItIsTold) {
  PlotData plot;
  for (int i = 0; i < 10; ++i) plot.Add(Point(i));
  const std::string page = ReportPage(plot, {{Point(2).time, Point(4).time}}, "<b>&", "a < b");
  EXPECT_THAT(page, HasSubstr("<title>&lt;b&gt;&amp;</title>"));
  EXPECT_THAT(page, HasSubstr("a &lt; b"));
  EXPECT_THAT(page, HasSubstr("\"blanks\":[[0.02,0.04]]"));
  EXPECT_THAT(page, HasSubstr("\"h\":[50,50,"));
  for (const char* link : {"http:", "https:", "src=", "@import", "<link"}) {
    EXPECT_THAT(page, Not(HasSubstr(link)));
  }
}

TEST(ReportPage, WithoutASolutionItIsStillAPage) {
  const std::string page = ReportPage(PlotData(), {}, "nothing", "no solution");
  EXPECT_THAT(page, HasSubstr("\"t\":[]"));
  EXPECT_THAT(page, HasSubstr("</html>"));
}

TEST(RunSummary, JsonSaysNullForWhatIsNotKnown) {
  RunSummary summary;
  summary.scored = true;
  const std::string json = SummaryJson(summary);
  EXPECT_THAT(json, HasSubstr("\"found\": null"));
  EXPECT_THAT(json, HasSubstr("\"held_out_fixed\": {\"n\": 0, \"rms_n_m\": null"));
  EXPECT_THAT(json, HasSubstr("\"seconds_to_first_row\": null"));
  EXPECT_THAT(json, Not(HasSubstr("nan")));
}

TEST(RunSummary, TableNamesSourcesThatWereThereOnly) {
  RunSummary summary;
  auto& fixed = summary.stats.source[static_cast<std::size_t>(estimation::NavSource::kFixed)];
  fixed = {.offered = 12, .accepted = 10, .rejected = 2, .nis_sum = 45.0, .nis_dof = 30};
  const std::string table = SummaryTable(summary);
  EXPECT_THAT(table, HasSubstr("12        10         2      1.50"));
  EXPECT_THAT(table, Not(HasSubstr(ToString(estimation::NavSource::kFloat))));
  EXPECT_THAT(table, HasSubstr("no solution"));
}

}  // namespace
}  // namespace kawara::navigate
