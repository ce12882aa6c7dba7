#include "onboard/mapper/report/evenly_spread.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace kawara::mapper {
namespace {

using ::testing::ElementsAre;

std::vector<int> Spread(int offered, std::size_t most) {
  EvenlySpread<int> spread(most);
  for (int i = 0; i < offered; ++i) spread.Offer([i] { return i; });
  return spread.kept();
}

TEST(EvenlySpread, AFewAreAllKept) { EXPECT_THAT(Spread(4, 4), ElementsAre(0, 1, 2, 3)); }

TEST(EvenlySpread, OneMoreThinsThem) { EXPECT_THAT(Spread(5, 4), ElementsAre(0, 2, 4)); }

TEST(EvenlySpread, AnyNumberLeavesAtLeastHalfAtEvenDistances) {
  for (const std::size_t most : {2U, 6U, 8U}) {
    for (int offered = 1; offered < 300; ++offered) {
      const std::vector<int> kept = Spread(offered, most);
      ASSERT_LE(kept.size(), most);
      ASSERT_GE(kept.size(), std::min(static_cast<std::size_t>(offered), most / 2));
      ASSERT_EQ(kept.front(), 0);
      const int step = kept.size() > 1 ? kept[1] : 1;
      for (std::size_t i = 0; i < kept.size(); ++i) {
        ASSERT_EQ(kept[i], step * static_cast<int>(i)) << offered << " offered, at most " << most;
      }
      ASSERT_LT(offered - 1 - kept.back(), std::max(2, step)) << "the end is left out";
    }
  }
}

TEST(EvenlySpread, WhatIsNotKeptIsNotMade) {
  EvenlySpread<int> spread(2);
  int made = 0;
  for (int i = 0; i < 1000; ++i) spread.Offer([&made] { return ++made; });
  EXPECT_LE(made, 12);  // two at first and one for each doubling
}

}  // namespace
}  // namespace kawara::mapper
