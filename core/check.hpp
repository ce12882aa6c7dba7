#pragma once
#include <cstdio>
#include <cstdlib>

/// For our own bugs only, never for data from outside: prints where and what, then aborts.
#define CORE_CHECK(condition)                                                                 \
  do {                                                                                        \
    if (!(condition)) {                                                                       \
      std::fprintf(stderr, "%s:%d: CORE_CHECK failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                           \
    }                                                                                         \
  } while (false)
