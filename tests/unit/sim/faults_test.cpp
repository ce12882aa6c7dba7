#include "sim/faults/faults.hpp"

#include <gtest/gtest.h>

namespace kawara::sim {
namespace {

TEST(Faults, ReadTimeKindAndLength) {
  const auto faults = ParseFaults("t=30 gps.unplug 5s");
  ASSERT_TRUE(faults);
  ASSERT_EQ(faults->size(), 1U);
  EXPECT_EQ((*faults)[0].kind, FaultKind::kGpsUnplug);
  EXPECT_EQ((*faults)[0].begin, core::Seconds(30));
  EXPECT_EQ((*faults)[0].length, core::Seconds(5));
}

TEST(Faults, SeveralInOneTextWithFractionsAndDefaultLength) {
  const auto faults = ParseFaults("t=1.5s  ahrs.garbage\t0.25 ; t=0 camera.miss");
  ASSERT_TRUE(faults);
  ASSERT_EQ(faults->size(), 2U);
  EXPECT_EQ((*faults)[0].begin, core::Milliseconds(1500));
  EXPECT_EQ((*faults)[0].length, core::Milliseconds(250));
  EXPECT_EQ((*faults)[1].kind, FaultKind::kCameraMiss);
  EXPECT_EQ((*faults)[1].length, core::Seconds(5));
}

TEST(Faults, EveryNameIsReadBack) {
  for (int kind = 0; kind <= static_cast<int>(FaultKind::kRadioDelay); ++kind) {
    const auto expected = static_cast<FaultKind>(kind);
    const auto faults = ParseFaults(std::string("t=1 ") + ToString(expected));
    ASSERT_TRUE(faults) << ToString(expected);
    EXPECT_EQ((*faults)[0].kind, expected);
  }
}

TEST(Faults, ValuesAreReadAndTheLastOneGivenHolds) {
  auto faults = ParseFaults("t=1 radio.loss=0.25 10s; t=3 radio.loss 2s");
  ASSERT_TRUE(faults);
  const FaultPlan plan(*faults);
  EXPECT_EQ(plan.Value(FaultKind::kRadioLoss, core::Milliseconds(500)), std::nullopt);
  EXPECT_EQ(plan.Value(FaultKind::kRadioLoss, core::Seconds(2)), 0.25);
  EXPECT_EQ(plan.Value(FaultKind::kRadioLoss, core::Seconds(4)), 0.3);
  EXPECT_EQ(plan.Value(FaultKind::kRadioLoss, core::Seconds(6)), 0.25);
  EXPECT_EQ(plan.Value(FaultKind::kRadioRate, core::Seconds(2)), std::nullopt);
}

TEST(Faults, MistakesSayWhatAndHowToMend) {
  const struct {
    const char* text;
    const char* must_say;
  } cases[] = {
      {"", "0 words"},
      {"t=3", "1 words"},
      {"gps.unplug 5s", "'gps.unplug' is no time"},
      {"t=x gps.unplug", "'t=x' is no time"},
      {"t=-1 gps.unplug", "'t=-1' is no time"},
      {"t=nan gps.unplug", "'t=nan' is no time"},
      {"t=1 gps.explode", "camera.disconnect"},
      {"t=1 gps.unplug soon", "'soon' is no length"},
      {"t=1 gps.unplug 0s", "'0s' is no length"},
      {"t=1 gps.unplug 5s now", "4 words"},
      {"t=1 gps.unplug 5s;", "0 words"},
      {"t=1 gps.unplug=3", "'gps.unplug' takes no value"},
      {"t=1 radio.loss=1.5", "a share of 0 to 1"},
      {"t=1 radio.rate=", "bits per second"},
      {"t=1 radio.delay=x", "seconds"},
  };
  for (const auto& c : cases) {
    const auto faults = ParseFaults(c.text);
    ASSERT_FALSE(faults) << c.text;
    EXPECT_EQ(faults.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_NE(faults.error().message.find(c.must_say), std::string::npos) << faults.error().message;
  }
}

TEST(Faults, PlanCoversFromBeginToBeforeEnd) {
  const FaultPlan plan(*ParseFaults("t=2 gps.silent 1s; t=10 gps.silent 1s"));
  const auto active = [&](int ms) {
    return plan.Active(FaultKind::kGpsSilent, core::Milliseconds(ms));
  };
  EXPECT_FALSE(active(1999));
  EXPECT_TRUE(active(2000));
  EXPECT_TRUE(active(2999));
  EXPECT_FALSE(active(3000));
  EXPECT_TRUE(active(10500));
  EXPECT_FALSE(plan.Active(FaultKind::kGpsUnplug, core::Milliseconds(2500)));
}

}  // namespace
}  // namespace kawara::sim
