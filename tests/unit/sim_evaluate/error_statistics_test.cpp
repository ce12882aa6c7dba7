#include "sim/evaluate/error_statistics.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace kawara::sim {
namespace {

using ::testing::HasSubstr;

TEST(Summarise, KnownAnswers) {
  const ErrorStatistics s = Summarise({-3, 1, 1, 5});
  EXPECT_EQ(s.count, 4U);
  EXPECT_DOUBLE_EQ(s.mean, 1.0);
  EXPECT_DOUBLE_EQ(s.sd, std::sqrt(8.0));
  EXPECT_DOUBLE_EQ(s.rms, 3.0);
  EXPECT_DOUBLE_EQ(s.median, 2.0);  // of 1 1 3 5
  EXPECT_DOUBLE_EQ(s.p95, 5.0);
  EXPECT_DOUBLE_EQ(s.max, 5.0);
}

TEST(Summarise, PercentileIsNearestRank) {
  std::vector<double> errors;
  for (int i = 1; i <= 100; ++i) errors.push_back(i);
  EXPECT_DOUBLE_EQ(Summarise(errors).p95, 95.0);
}

TEST(Summarise, NothingIsNotZero) {
  EXPECT_EQ(Summarise({}).count, 0U);
  EXPECT_TRUE(std::isnan(Summarise({}).rms));
}

TEST(ErrorReport, JsonHoldsWhatTextShows) {
  ErrorReport report;
  report.Add("north", "m", Summarise({0.5}));
  report.Add("none", "m", Summarise({}));
  report.Add("found", "objects", 3);
  EXPECT_THAT(report.Text(), HasSubstr("north"));
  EXPECT_THAT(report.Json(), HasSubstr(R"("north": {"unit": "m", "n": 1, "mean": 0.5,)"));
  EXPECT_THAT(report.Json(), HasSubstr(R"("none": {"unit": "m", "n": 0, "mean": null,)"));
  EXPECT_THAT(report.Json(), HasSubstr(R"("found": {"unit": "objects", "value": 3})"));
}

}  // namespace
}  // namespace kawara::sim
