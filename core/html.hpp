#pragma once
#include <string>
#include <string_view>

namespace kawara::core {

/// Text as it may stand in an HTML page, between tags or inside a quoted attribute: & < > " ' by
/// their names; control characters but line feed and tab, which no page may hold, become U+FFFD.
/// Source: HTML Living Standard 13.1.2.3, 13.1.4. UTF-8 in, UTF-8 out; bytes that are no UTF-8
/// stay.
std::string HtmlEscaped(std::string_view text);

}  // namespace kawara::core
