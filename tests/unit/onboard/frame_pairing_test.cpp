#include "onboard/frame_pairing.hpp"

#include <gtest/gtest.h>

namespace kawara::onboard {
namespace {

core::MonoTime At(double seconds) {
  return core::MonoTime::FromNs(1'000'000'000'000) + core::DurationFromSeconds(seconds);
}

OrderedExposure Trigger(std::uint32_t number, double fired_s) {
  OrderedExposure exposure;
  exposure.trigger = number;
  exposure.fired = At(fired_s);
  return exposure;
}

FrameInput Frame(double exposed_s, std::uint32_t trigger = 0) {
  FrameInput frame;
  frame.exposure_start = At(exposed_s);
  frame.trigger_sequence = trigger;
  return frame;
}

class FramePairingTest : public testing::Test {
 protected:
  FramePairing pairing_{core::Milliseconds(5), core::Milliseconds(100)};
};

TEST_F(FramePairingTest, FrameFindsItsTriggerByTime) {
  pairing_.OnTrigger(Trigger(1, 0.0));
  pairing_.OnTrigger(Trigger(2, 1.0));
  const auto found = pairing_.OnFrame(Frame(1.006));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->trigger, 2U);
}

TEST_F(FramePairingTest, MissedFrameDoesNotShiftTheNextOnes) {
  for (std::uint32_t i = 1; i <= 4; ++i) pairing_.OnTrigger(Trigger(i, i));
  EXPECT_EQ(pairing_.OnFrame(Frame(1.005))->trigger, 1U);
  EXPECT_EQ(pairing_.OnFrame(Frame(3.005))->trigger, 3U);  // 2 never came
  EXPECT_EQ(pairing_.OnFrame(Frame(4.005))->trigger, 4U);
  EXPECT_EQ(pairing_.Expire(At(4.5)), 1);
  EXPECT_EQ(pairing_.stats().missed, 1);
}

TEST_F(FramePairingTest, LateDeliveryIsPairedByExposureNotByArrival) {
  pairing_.OnTrigger(Trigger(1, 0.0));
  pairing_.OnTrigger(Trigger(2, 1.0));
  FrameInput late = Frame(0.005);
  late.arrival = At(1.2);
  EXPECT_EQ(pairing_.OnFrame(late)->trigger, 1U);
  EXPECT_EQ(pairing_.OnFrame(Frame(1.005))->trigger, 2U);
}

TEST_F(FramePairingTest, SecondFrameOfATriggerIsRefused) {
  pairing_.OnTrigger(Trigger(1, 0.0));
  EXPECT_TRUE(pairing_.OnFrame(Frame(0.004)));
  EXPECT_FALSE(pairing_.OnFrame(Frame(0.006)));
  EXPECT_EQ(pairing_.stats().doubled, 1);
}

TEST_F(FramePairingTest, FrameFarFromAnyTriggerIsStray) {
  pairing_.OnTrigger(Trigger(1, 0.0));
  EXPECT_FALSE(pairing_.OnFrame(Frame(0.5)));
  EXPECT_EQ(pairing_.stats().stray, 1);
  EXPECT_TRUE(pairing_.OnFrame(Frame(0.0))) << "the trigger still waits for its own frame";
}

TEST_F(FramePairingTest, CameraThatNamesAnotherTriggerIsNotBelieved) {
  pairing_.OnTrigger(Trigger(7, 0.0));
  EXPECT_FALSE(pairing_.OnFrame(Frame(0.005, 6)));
  EXPECT_EQ(pairing_.stats().disagreed, 1);
  EXPECT_TRUE(pairing_.OnFrame(Frame(0.005, 7)));
}

/// A camera of 10 Hz that nobody triggers, at any phase to the triggers and with any delay until
/// its frames are here: each trigger gets one frame, exposed within half a period before it and a
/// period after it.
TEST(FramePairingOfAFreeCamera, EveryTriggerGetsOneFrameNearby) {
  for (double phase_s = 0.0; phase_s < 0.1; phase_s += 0.007) {
    for (const double delay_s : {0.0, 0.03, 0.07, 0.15, 0.4}) {
      FramePairing pairing(core::Duration(0), core::Milliseconds(53), core::Milliseconds(103));
      std::uint32_t triggers = 0;
      int frames = 0;
      for (int ms = 0; ms < 10'000; ++ms) {  // the machine's time
        const double now = 0.001 * ms;
        if (ms % 500 == 250 && ms < 9'000) pairing.OnTrigger(Trigger(++triggers, now));
        const double exposed = phase_s + 0.1 * frames;
        if (exposed + delay_s > now) continue;
        ++frames;
        if (const auto found = pairing.OnFrame(Frame(exposed))) {
          EXPECT_EQ(found->trigger, triggers) << phase_s << " " << delay_s;
          EXPECT_GT(At(exposed) - found->fired, core::Milliseconds(-54));
          EXPECT_LT(At(exposed) - found->fired, core::Milliseconds(104));
        }
        pairing.Expire(At(now));
      }
      EXPECT_EQ(pairing.stats().paired, triggers) << phase_s << " " << delay_s;
      EXPECT_EQ(pairing.stats().missed, 0);
    }
  }
}

}  // namespace
}  // namespace kawara::onboard
