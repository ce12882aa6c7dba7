#include "onboard/system_clock_reference.hpp"

#include <gtest/gtest.h>
#include <sys/shm.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace kawara::onboard {
namespace {

/// GPS time now, by the computer's clock taken to be `fast` ahead of it.
estimation::ClockStatus Now(core::Duration fast, estimation::ClockSource source, double sigma_s) {
  estimation::ClockStatus clock;
  clock.mono = core::MonoNow();
  const auto computer = std::chrono::system_clock::now().time_since_epoch();
  const auto utc = core::UtcTime::FromNs(
                       std::chrono::duration_cast<std::chrono::nanoseconds>(computer).count()) -
                   fast;
  clock.stream = estimation::StreamTime::FromNs(core::ToGps(utc).ns());
  clock.source = source;
  clock.sigma_s = sigma_s;
  return clock;
}

TEST(SystemClockReference, OffersWhatRestsOnTheReceiverAndSaysOnceWhatIsWrong) {
  using estimation::ClockSource;
  const int unit = 200'000 + getpid() % 100'000;
  core::Counters counters;
  std::vector<std::string> told;
  SystemClockReference reference(unit, counters,
                                 [&](const EventNote& note) { told.emplace_back(note.name); });
  const core::Duration fast = core::Milliseconds(1500);
  const auto offered = [&] { return counters.Register("system_clock.offered").value(); };
  for (int i = 0; i < 3; ++i) reference.OnClock(Now(fast, ClockSource::kPps, 1e-5));
  EXPECT_EQ(told, std::vector<std::string>{"system_clock.refused"});
  EXPECT_EQ(offered(), 0);

  const int id = shmget(0x4e545030 + unit, 96, IPC_CREAT | IPC_EXCL | 0600);
  ASSERT_GE(id, 0);
  reference.OnClock(Now(fast, ClockSource::kHoldover, 1e-5));
  reference.OnClock(Now(fast, ClockSource::kNone, 0.0));
  reference.OnClock(Now(fast, ClockSource::kEnvelope, 0.5));
  EXPECT_EQ(offered(), 0);
  reference.OnClock(Now(fast, ClockSource::kEnvelope, 0.01));
  reference.OnClock(Now(fast, ClockSource::kPps, 1e-5));
  shmctl(id, IPC_RMID, nullptr);
  EXPECT_EQ(offered(), 2);
  EXPECT_EQ(told.back(), "system_clock.offered");
  EXPECT_EQ(told.size(), 2U);
  // The test itself is interrupted at times between its two readings of the clock.
  EXPECT_NEAR(static_cast<double>(counters.Register("system_clock.off_us").value()), 1.5e6, 2e5);
}

}  // namespace
}  // namespace kawara::onboard
