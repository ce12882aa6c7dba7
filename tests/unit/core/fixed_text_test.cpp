#include "core/fixed_text.hpp"

#include <gtest/gtest.h>

namespace kawara::core {
namespace {

// Run it under UBSan: found by fuzzing the NMEA decoder with "PASHR,RID".
TEST(FixedText, TakesAViewOfNothing) {
  FixedText<8> text{std::string_view{}};
  EXPECT_TRUE(text.empty());
  text.Append("ab").Append(std::string_view{});
  EXPECT_EQ(text.view(), "ab");
}

TEST(FixedText, IsCutWhereItWouldRunOver) {
  FixedText<4> text("abc");
  EXPECT_EQ(text.Append("defg").view(), "abcd");
  EXPECT_EQ(text.Append(7).view(), "abcd");
}

TEST(FixedText, WritesNumbersWithoutALocale) {
  FixedText<40> text;
  text.Append(-12).Append(" ").Append(3.14159, 2).Append(" ").Append(1e300, 1);
  EXPECT_EQ(text.view(), "-12 3.14 1e+300");
}

}  // namespace
}  // namespace kawara::core
