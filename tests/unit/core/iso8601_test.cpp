#include "core/iso8601.hpp"

#include <gtest/gtest.h>

namespace kawara::core {
namespace {

constexpr std::int64_t kNs = 1'000'000'000;

TEST(Iso8601, FormatsWithTheDigitsAskedFor) {
  const UtcTime t = UtcTime::FromNs(1752003258 * kNs + 499'999'999);
  EXPECT_EQ(FormatIso8601(t), "2025-07-08T19:34:18.499Z");
  EXPECT_EQ(FormatIso8601(t, Iso8601Digits::kSeconds), "2025-07-08T19:34:18Z");
  EXPECT_EQ(FormatIso8601(t, Iso8601Digits::kMicroseconds), "2025-07-08T19:34:18.499999Z");
  EXPECT_EQ(FormatIso8601(t, Iso8601Digits::kNanoseconds), "2025-07-08T19:34:18.499999999Z");
  EXPECT_EQ(FormatIso8601Basic(t), "20250708T193418Z");
}

TEST(Iso8601, BeforeTheEpochOfPosix) {
  EXPECT_EQ(FormatIso8601(UtcTime::FromNs(-1), Iso8601Digits::kNanoseconds),
            "1969-12-31T23:59:59.999999999Z");
}

struct Case {
  const char* text;
  std::int64_t ns;
};
class Iso8601Good : public ::testing::TestWithParam<Case> {};
TEST_P(Iso8601Good, Parses) {
  const auto t = ParseIso8601(GetParam().text);
  ASSERT_TRUE(t) << t.error().message;
  EXPECT_EQ(t->ns(), GetParam().ns);
}
INSTANTIATE_TEST_SUITE_P(
    Table, Iso8601Good,
    ::testing::Values(Case{"2025-07-08T19:34:18.499Z", 1752003258 * kNs + 499'000'000},
                      Case{"2025-07-08T19:34:18Z", 1752003258 * kNs},
                      Case{"2025-07-08 19:34:18z", 1752003258 * kNs},
                      Case{"2025-07-09T04:34:18+09:00", 1752003258 * kNs},
                      Case{"2025-07-08T16:04:18-0330", 1752003258 * kNs},
                      Case{"2025-07-08T19:34:18.123456789123Z", 1752003258 * kNs + 123'456'789},
                      Case{"1969-12-31T23:59:59.5Z", -kNs / 2},
                      Case{"2016-12-31T23:59:60Z", 1483228800 * kNs},
                      Case{"2016-12-31T23:59:60.25Z", 1483228800 * kNs + 250'000'000},
                      Case{"2017-01-01T08:59:60+09:00", 1483228800 * kNs},
                      Case{"2024-02-29T00:00:00Z", 1709164800 * kNs}));

TEST(Iso8601, RefusesWhatNamesNoInstant) {
  for (const char* text : {"",
                           "2025",
                           "2025-07-08",
                           "2025-07-08T19:34:18",
                           "2025-07-08T19:34Z",
                           "2025-7-08T19:34:18Z",
                           "2025-07-08T19:34:18.Z",
                           "2025-07-08T19:34:18Zjunk",
                           "2025-13-08T19:34:18Z",
                           "2023-02-29T00:00:00Z",
                           "2025-07-08T24:00:00Z",
                           "2025-07-08T19:60:18Z",
                           "2025-07-08T19:34:61Z",
                           "2025-07-08T19:34:60Z",
                           "2025-07-08T23:59:60+01:00",
                           "-025-07-08T19:34:18Z",
                           "2025-07-08T19:34:18+24:00",
                           "0001-01-01T00:00:00Z",
                           "2025/07/08T19:34:18Z",
                           "2025-07-08T1a:34:18Z"}) {
    const auto t = ParseIso8601(text);
    EXPECT_FALSE(t.has_value()) << text;
    EXPECT_EQ(t.has_value() ? ErrorCode::kFormat : t.error().code, ErrorCode::kFormat);
  }
}

TEST(Iso8601, RoundTripsToTheNanosecond) {
  for (std::int64_t ns = -9'200'000'000'000'000'000; ns < 9'190'000'000'000'000'000;
       ns += 123'456'789'123'456'789) {
    const UtcTime t = UtcTime::FromNs(ns);
    const auto again = ParseIso8601(FormatIso8601(t, Iso8601Digits::kNanoseconds));
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_EQ(*again, t);
  }
}

}  // namespace
}  // namespace kawara::core
