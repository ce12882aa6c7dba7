// Replaces operator new of the whole test program by one that counts, so that "does not allocate"
// can be tested.
#include <cstdlib>
#include <new>

#include "corrections_data.hpp"

namespace {
thread_local std::uint64_t allocations = 0;

void* Allocate(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
}  // namespace

void* operator new(std::size_t size) { return Allocate(size); }
void* operator new[](std::size_t size) { return Allocate(size); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

namespace kawara::drivers::testing {
std::uint64_t AllocationsOfThisThread() { return allocations; }
}  // namespace kawara::drivers::testing
