#pragma once
#include <cerrno>
#include <ctime>

#include "core/time.hpp"

namespace kawara::sim {

/// Signals do not end it early.
inline void SleepUntil(core::MonoTime t) {
  const timespec until{.tv_sec = t.ns() / 1'000'000'000, .tv_nsec = t.ns() % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace kawara::sim
