#include "tools/navigate/decimal_time.hpp"

#include <gtest/gtest.h>

#include <string>

namespace kawara::navigate {
namespace {

std::int64_t NsAfterZero(const std::string& text) {
  const auto t = ParseSeconds(text);
  return t ? (*t - *ParseSeconds("0")).count() : -999;
}

TEST(DecimalTime, EveryDigitCounts) {
  EXPECT_EQ(NsAfterZero("300000.01333"), 300'000'013'330'000);
  EXPECT_EQ(NsAfterZero("243258.499"), 243'258'499'000'000);
  EXPECT_EQ(NsAfterZero("604799.999999999"), 604'799'999'999'999);
  EXPECT_EQ(NsAfterZero("1657000000.123456789"), 1'657'000'000'123'456'789);
  EXPECT_EQ(NsAfterZero("-0.5"), -500'000'000);
  EXPECT_EQ(NsAfterZero("+7"), 7'000'000'000);
  EXPECT_EQ(NsAfterZero(".25"), 250'000'000);
  EXPECT_EQ(NsAfterZero("3."), 3'000'000'000);
}

TEST(DecimalTime, BeyondTheNanosecondItRounds) {
  EXPECT_EQ(NsAfterZero("1.0000000004"), 1'000'000'000);
  EXPECT_EQ(NsAfterZero("1.0000000005"), 1'000'000'001);
  EXPECT_EQ(NsAfterZero("1.9999999999"), 2'000'000'000);
  EXPECT_EQ(NsAfterZero("0.00000000049"), 0);
}

TEST(DecimalTime, ExponentsAreNumbersToo) {
  EXPECT_EQ(NsAfterZero("2.4325849900e+05"), 243'258'499'000'000);
}

TEST(DecimalTime, WhatIsNoTime) {
  for (const char* text : {"", "-", "+", ".", "abc", "1.2.3", "12:30:00", "nan", "inf", "1e", "1 2",
                           "4000000001", "99999999999999999999", "1e300", "0x10", "--1"}) {
    EXPECT_FALSE(ParseSeconds(text)) << text;
  }
}

TEST(DecimalTime, PrintedAsItCame) {
  for (const char* text : {"300000.000", "243258.499", "300000.01333", "0.000", "-12.500",
                           "1657000000.123456789", "-0.000000001"}) {
    EXPECT_EQ(FormatSeconds(*ParseSeconds(text)), text);
  }
}

TEST(DecimalTime, ZeroIsATimeThatIsSet) { EXPECT_TRUE(ParseSeconds("0")->IsSet()); }

}  // namespace
}  // namespace kawara::navigate
