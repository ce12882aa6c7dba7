#include "core/html.hpp"

#include <gtest/gtest.h>

#include <string>

namespace kawara::core {
namespace {

TEST(HtmlEscaped, NothingCanLeaveItsPlace) {
  EXPECT_EQ(HtmlEscaped("<b a=\"1\" c='2'>&amp;"),
            "&lt;b a=&quot;1&quot; c=&#39;2&#39;&gt;&amp;amp;");
}

TEST(HtmlEscaped, OtherTextStaysAsItIs) {
  EXPECT_EQ(HtmlEscaped("瓦版 5 %\n\tend"), "瓦版 5 %\n\tend");
  EXPECT_EQ(HtmlEscaped(""), "");
}

TEST(HtmlEscaped, ControlCharactersAreReplaced) {
  EXPECT_EQ(HtmlEscaped(std::string("a\0b\x1B\x7F", 5)), "a\uFFFDb\uFFFD\uFFFD");
}

}  // namespace
}  // namespace kawara::core
