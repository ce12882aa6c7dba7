// Pulses through the kernel's own driver (pps_parport): the strobe of the emulated parallel port
// raises its interrupt.
#include <gtest/gtest.h>
#include <sys/io.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>

#include "drivers/pps_device.hpp"

namespace kawara::drivers {
namespace {

constexpr unsigned short kControl = 0x37a;

/// When a pulse was made, at the earliest and at the latest.
struct Made {
  core::MonoTime from, to;
};

Made Pulse() {
  const core::MonoTime from = core::MonoNow();
  outb(0x1d, kControl);  // select, initialised, interrupt enabled, strobe on ...
  outb(0x1c, kControl);  // ... and off: the edge
  return {from, core::MonoNow()};
}

/// The edge that comes of a pulse made now, or nothing within a long time.
std::optional<PpsEdge> Await(KernelPps& pps) {
  for (int i = 0; i < 100; ++i) {
    const auto edge = pps.Next(core::Milliseconds(200));
    EXPECT_TRUE(edge) << (edge ? "" : edge.error().message);
    if (!edge) return std::nullopt;
    if (*edge) return *edge;
  }
  return std::nullopt;
}

class KernelPulses : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_EQ(ioperm(0x378, 3, 1), 0);
    Pulse();  // one of before the opening: never told
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    const auto none = pps_.Next(core::Milliseconds(50));
    ASSERT_TRUE(none) << none.error().message;
    ASSERT_FALSE(none->has_value());
  }
  KernelPps pps_{"/dev/pps0", PulseEdge::kRising};
};

TEST_F(KernelPulses, AreStampedOnTheMonotonicClock) {
  std::uint32_t last = 0;
  for (int i = 0; i < 20; ++i) {
    const Made made = Pulse();
    const auto edge = Await(pps_);
    ASSERT_TRUE(edge);
    EXPECT_GE(edge->mono, made.from - core::Milliseconds(1));
    // The emulated interrupt takes its time.
    EXPECT_LE(edge->mono, made.to + core::Milliseconds(100));
    EXPECT_TRUE(i == 0 || edge->sequence == last + 1) << last << " then " << edge->sequence;
    last = edge->sequence;
  }
  EXPECT_EQ(pps_.stats().edges, 20U);
}

TEST_F(KernelPulses, AreStampedWhileOneWaits) {
  for (int i = 0; i < 5; ++i) {
    Made made;
    std::thread receiver([&made] {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      made = Pulse();
    });
    const auto edge = Await(pps_);
    receiver.join();
    ASSERT_TRUE(edge);
    EXPECT_GE(edge->mono, made.from - core::Milliseconds(1));
    EXPECT_LE(edge->mono, made.to + core::Milliseconds(100));
  }
}

TEST_F(KernelPulses, MissedOnesShowInTheCount) {
  Pulse();
  const auto first = Await(pps_);
  ASSERT_TRUE(first);
  for (int i = 0; i < 3; ++i) {
    Pulse();
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  const auto newest = Await(pps_);
  ASSERT_TRUE(newest);
  EXPECT_EQ(newest->sequence, first->sequence + 3);
}

/// The system clock is set while an edge is waited for: at most that edge is lost, and none is put
/// at a wrong time.
TEST_F(KernelPulses, SettingTheSystemClockDoesNoHarm) {
  int lost = 0;
  for (int i = 0; i < 8; ++i) {
    Made made;
    std::thread receiver([&made, i] {
      std::this_thread::sleep_for(std::chrono::milliseconds(60));
      timeval now{};
      gettimeofday(&now, nullptr);
      now.tv_sec += i % 2 == 0 ? 3600 : -3600;
      if (i < 4) settimeofday(&now, nullptr);
      made = Pulse();
      if (i >= 4) settimeofday(&now, nullptr);
    });
    const auto edge = pps_.Next(core::Milliseconds(800));
    receiver.join();
    ASSERT_TRUE(edge) << edge.error().message;
    if (!*edge) {
      ++lost;
      continue;
    }
    EXPECT_GE((*edge)->mono, made.from - core::Milliseconds(1)) << i;
    EXPECT_LE((*edge)->mono, made.to + core::Milliseconds(100)) << i;
  }
  EXPECT_LE(pps_.stats().clock_steps, 8U);
  EXPECT_EQ(static_cast<std::uint64_t>(lost), pps_.stats().clock_steps);
  // The next one is as good as ever.
  const Made made = Pulse();
  const auto edge = Await(pps_);
  ASSERT_TRUE(edge);
  EXPECT_GE(edge->mono, made.from - core::Milliseconds(1));
}

TEST(KernelPps, RefusesAnEdgeTheDriverDoesNotStamp) {
  KernelPps pps("/dev/pps0", PulseEdge::kFalling);
  const auto edge = pps.Next(core::Milliseconds(50));
  if (edge) GTEST_SKIP() << "this driver stamps both";
  EXPECT_NE(edge.error().message.find("gps.pps.edge"), std::string::npos) << edge.error().message;
}

TEST(KernelPps, SaysThatItWasUnpluggedAndComesBack) {
  const std::string other = "/tmp/pps-link";
  ASSERT_EQ(symlink("/dev/pps0", other.c_str()), 0);
  KernelPps pps(other, PulseEdge::kRising);
  ASSERT_TRUE(pps.Next(core::Milliseconds(50)));
  unlink(other.c_str());
  const auto gone = pps.Next(core::Milliseconds(50));
  ASSERT_FALSE(gone);
  EXPECT_NE(gone.error().message.find("unplugged"), std::string::npos) << gone.error().message;
  EXPECT_FALSE(pps.Next(core::Milliseconds(50)));
  ASSERT_EQ(symlink("/dev/pps0", other.c_str()), 0);
  ASSERT_TRUE(pps.Next(core::Milliseconds(50)));
  ASSERT_EQ(ioperm(0x378, 3, 1), 0);
  Pulse();
  EXPECT_TRUE(Await(pps));
  unlink(other.c_str());
}

}  // namespace
}  // namespace kawara::drivers
