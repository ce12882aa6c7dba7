#pragma once
#include <cstdint>

namespace kawara::testing {

/// Calls of operator new by this thread since the program began. A test that uses it replaces the
/// global operator new of its program (counting_allocator.cpp is linked in by that use).
std::uint64_t AllocationsOfThisThread();

/// How often `body` allocates on this thread.
///     EXPECT_EQ(CountAllocations([&] { decoder.Feed(now, bytes, sink); }), 0U);
template <class Body>
std::uint64_t CountAllocations(Body&& body) {
  const std::uint64_t before = AllocationsOfThisThread();
  body();
  return AllocationsOfThisThread() - before;
}

}  // namespace kawara::testing
