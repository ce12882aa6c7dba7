#include "tools/navigate/progress.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace kawara::navigate {

Progress::Progress() : terminal_(::isatty(STDERR_FILENO) == 1), start_(core::MonoNow()) {}

Progress::~Progress() {
  if (shown_percent_ >= 0) std::fputs("\r\033[K", stderr);
}

void Progress::Show(double part) {
  constexpr int kWidth = 40;
  if (core::MonoNow() - start_ < core::Seconds(1)) return;
  const int percent = static_cast<int>(100.0 * std::clamp(part, 0.0, 1.0));
  if (percent == shown_percent_) return;
  shown_percent_ = percent;
  const auto full = static_cast<std::size_t>(kWidth * percent / 100);
  const std::string bar = std::string(full, '#') + std::string(kWidth - full, '.');
  std::fprintf(stderr, "\r[%s] %3d %%", bar.c_str(), percent);
}

}  // namespace kawara::navigate
