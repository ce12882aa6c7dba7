#include "onboard/mapper/pair_queue.hpp"

#include <gtest/gtest.h>

namespace kawara::mapper {
namespace {

TEST(PairQueue, WhoWaitsIsCalledMeanwhileAndMayPushHimself) {
  PairQueue queue;
  int calls = 0;
  const auto waiting = [&] {
    if (++calls < 2) return;
    PicturePair pair;
    pair.stop = 7;
    EXPECT_TRUE(queue.Push(std::move(pair)));
  };
  const auto pair = queue.Pop(waiting);
  ASSERT_TRUE(pair);
  EXPECT_EQ(pair->stop, 7U);
  EXPECT_EQ(calls, 2);
}

TEST(PairQueue, NobodyWaitsForAClosedOne) {
  PairQueue queue;
  EXPECT_TRUE(queue.Push({}));
  queue.Close();
  int calls = 0;
  const auto waiting = [&] { ++calls; };
  EXPECT_TRUE(queue.Pop(waiting));
  EXPECT_FALSE(queue.Pop(waiting));
  EXPECT_FALSE(queue.Push({}));
  EXPECT_EQ(calls, 0);
}

}  // namespace
}  // namespace kawara::mapper
