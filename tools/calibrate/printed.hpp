#pragma once
#include <array>
#include <cstdarg>
#include <cstdio>
#include <string>

namespace kawara::calibrate {

/// printf into a string, at most 1000 bytes. The compiler checks the arguments.
[[gnu::format(printf, 1, 2)]] inline std::string Printed(const char* format, ...) {
  std::array<char, 1000> text{};
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text.data(), text.size(), format, arguments);
  va_end(arguments);
  return text.data();
}

}  // namespace kawara::calibrate
