#pragma once
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cinttypes>
#include <cstdint>
#include <cstdio>

namespace kawara::mapper {

/// How far the work is, on stderr: a line that is drawn over itself on a terminal; elsewhere one
/// every ten seconds, the first at once. One thread.
class ProgressLine {
 public:
  void Show(std::uint64_t stops, std::uint64_t all, std::uint64_t pairs) {
    const bool terminal = isatty(STDERR_FILENO) != 0;
    const auto now = std::chrono::steady_clock::now();
    if (first_ == 0) first_ = stops;
    const bool last = all > 0 && stops == all;
    if (now - shown_ < std::chrono::milliseconds(terminal ? 100 : 10000) && !last) return;
    shown_ = now;
    const double seconds = std::chrono::duration<double>(now - start_).count();
    const double rate = static_cast<double>(stops - first_ + 1) / std::max(1e-3, seconds);
    std::fprintf(stderr, "%skawara-mapper: %" PRIu64 " pairs", terminal ? "\r" : "", pairs);
    if (all > 0) {
      std::fprintf(stderr, ", stop %" PRIu64 " of %" PRIu64 ", %.1f a second, %.0f s left ", stops,
                   all, rate, static_cast<double>(all - std::min(all, stops)) / rate);
    }
    open_ = terminal;
    if (!terminal) std::fputc('\n', stderr);
  }
  /// Other lines may come.
  void End() {
    if (open_) std::fputc('\n', stderr);
    open_ = false;
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  std::chrono::steady_clock::time_point shown_ = start_ - std::chrono::seconds(60);
  std::uint64_t first_ = 0;
  bool open_ = false;
};

}  // namespace kawara::mapper
