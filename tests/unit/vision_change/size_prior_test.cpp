#include "vision/change/size_prior.hpp"

#include <gtest/gtest.h>

namespace kawara::vision {
namespace {

SeenExtent Whole(double m) { return {m, 0.05, true}; }
SeenExtent AtLeast(double m) { return {m, 0.1, false}; }

TEST(SizePrior, GuessesByWhatWasSeen) {
  EXPECT_EQ(GuessSize({Whole(4.4), Whole(1.7), Whole(1.5)}, 1.0).cls, core::SizeClass::kCar);
  EXPECT_EQ(GuessSize({Whole(7.5), Whole(2.2), Whole(3.0)}, 1.0).cls, core::SizeClass::kTruck);
  EXPECT_EQ(GuessSize({Whole(0.5), Whole(0.4), Whole(1.7)}, 0.2).cls, core::SizeClass::kPerson);
  EXPECT_EQ(GuessSize({Whole(2.8), Whole(2.4), Whole(0.8)}, 0.0).cls, core::SizeClass::kRubble);
}

TEST(SizePrior, WhatIsHiddenIsThatOfItsKindAndUncertain) {
  const SizeGuess truck = GuessSize({Whole(7.0), AtLeast(1.4), Whole(3.0)}, 1.0);
  EXPECT_NEAR(truck.size_m.y(), 2.25, 0.15);
  EXPECT_GT(truck.sd_m.y(), 0.1);
  const SizeGuess car = GuessSize({AtLeast(3.0), Whole(1.7), Whole(1.5)}, 1.0);
  EXPECT_NEAR(car.size_m.x(), 4.4, 0.3);
  EXPECT_GT(car.sd_m.x(), 0.3);
}

TEST(SizePrior, WhatWasSeenIsNeverMadeLess) {
  for (const double seen : {1.0, 2.0, 2.5, 3.0})
    EXPECT_GE(GuessSize({Whole(7.0), AtLeast(seen), Whole(3.0)}, 1.0).size_m.y(), seen - 0.12);
}

}  // namespace
}  // namespace kawara::vision
