#include "onboard/heartbeat.hpp"

#include <gtest/gtest.h>

namespace kawara::onboard {
namespace {

TEST(HeartWatch, KnowsWhetherItBeatSinceTheLastLook) {
  Heartbeat heart;
  HeartWatch watch(heart);
  EXPECT_FALSE(watch.HasBeaten());
  heart.Beat();
  heart.Beat();
  EXPECT_TRUE(watch.HasBeaten());
  EXPECT_FALSE(watch.HasBeaten());
  heart.Beat();
  EXPECT_TRUE(watch.HasBeaten());
}

}  // namespace
}  // namespace kawara::onboard
