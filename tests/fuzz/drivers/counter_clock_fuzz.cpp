// Any counters at any arrival times: stamps always rise and stay finite.
#include <cstdint>
#include <cstring>

#include "core/check.hpp"
#include "drivers/counter_clock.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara;
  drivers::CounterClock clock;
  core::MonoTime arrival = core::MonoTime::FromNs(1'000'000'000);
  core::MonoTime last;
  for (; size >= 5; data += 5, size -= 5) {
    std::uint16_t counter = 0, wait = 0;
    std::memcpy(&counter, data, 2);
    std::memcpy(&wait, data + 2, 2);
    arrival +=
        core::Nanoseconds(static_cast<std::int64_t>(wait) * (data[4] >= 250 ? 1'000'000 : 1'000));
    const core::MonoTime stamp = clock.Update(counter, arrival, (data[4] & 1U) != 0);
    CORE_CHECK(stamp > last);
    CORE_CHECK(clock.skew_ppm() > -10'001 && clock.skew_ppm() < 10'001);
    last = stamp;
  }
  return 0;
}
