#include "onboard/shutter_model.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstdlib>

namespace kawara::onboard {
namespace {

using core::Milliseconds;

constexpr core::Duration Microseconds(std::int64_t n) { return core::Nanoseconds(n * 1000); }

constexpr core::MonoTime kFired = core::MonoTime::FromNs(5'000'000'000'000);

/// Exposures 7 ms after their triggers and stamps 25 ms after them, with these scatters.
ShutterModel Taught(core::Duration lead_scatter, core::Duration stamp_scatter, int exposures) {
  ShutterModel model;
  for (int i = 0; i < exposures; ++i) {
    const int side = i % 2 == 0 ? 1 : -1;
    const core::MonoTime start = kFired + Milliseconds(7) + side * lead_scatter;
    model.Learn(kFired, start + Milliseconds(25) + side * stamp_scatter, start);
  }
  return model;
}

TEST(ShutterModel, SaysNothingBeforeItHasSeenEnough) {
  EXPECT_FALSE(Taught(core::Duration(0), core::Duration(0), ShutterModel::kEnough - 1)
                   .StartOf(kFired, kFired));
  EXPECT_TRUE(
      Taught(core::Duration(0), core::Duration(0), ShutterModel::kEnough).StartOf(kFired, kFired));
}

TEST(ShutterModel, DatesAnExposureByWhatScattersLess) {
  const core::MonoTime stamp = kFired + Milliseconds(40);
  const auto by_trigger = Taught(Microseconds(100), Milliseconds(3), 100).StartOf(kFired, stamp);
  ASSERT_TRUE(by_trigger);
  EXPECT_LT(std::abs((*by_trigger - (kFired + Milliseconds(7))).count()), 50'000);
  const auto by_stamp = Taught(Milliseconds(3), Microseconds(100), 100).StartOf(kFired, stamp);
  ASSERT_TRUE(by_stamp);
  EXPECT_LT(std::abs((*by_stamp - (stamp - Milliseconds(25))).count()), 50'000);
}

TEST(ShutterModel, FollowsACameraThatWasSetAnew) {
  ShutterModel model = Taught(Microseconds(10), Microseconds(10), 50);
  for (int i = 0; i < 100; ++i) {
    model.Learn(kFired, kFired + Milliseconds(60), kFired + Milliseconds(20));
  }
  EXPECT_NEAR(core::ToSeconds(model.lead().mean), 0.020, 1e-4);
  EXPECT_NEAR(core::ToSeconds(model.stamp().mean), 0.040, 1e-4);
}

}  // namespace
}  // namespace kawara::onboard
