#include "core/spsc_ring.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <deque>
#include <random>
#include <thread>

#include "core/measurements.hpp"

namespace kawara::core {
namespace {

/// An item that shows tearing: every word is computed from the first.
struct Item {
  std::uint64_t number = 0;
  std::array<std::uint64_t, 6> shadow{};
  static Item Make(std::uint64_t n) {
    Item item;
    item.number = n;
    for (std::size_t i = 0; i < item.shadow.size(); ++i) item.shadow[i] = n * (i + 3) + i;
    return item;
  }
  bool Whole() const {
    const Item same = Make(number);
    return shadow == same.shadow;
  }
};

TEST(SpscRing, StartsEmptyAndLeavesOutAlone) {
  SpscRing<int, 4> ring;
  int out = 7;
  EXPECT_FALSE(ring.TryPop(out));
  EXPECT_EQ(out, 7);
  EXPECT_TRUE(ring.empty());
}

TEST(SpscRing, FullRingRefusesAndCounts) {
  SpscRing<int, 2> ring;
  EXPECT_TRUE(ring.TryPush(1));
  EXPECT_TRUE(ring.TryPush(2));
  EXPECT_FALSE(ring.TryPush(3));
  EXPECT_EQ(ring.dropped(), 1u);
  int out = 0;
  ASSERT_TRUE(ring.TryPop(out));
  EXPECT_EQ(out, 1);
}

TEST(SpscRing, DropsTheOldestAndCounts) {
  SpscRing<int, 3> ring;
  for (int i = 1; i <= 3; ++i) EXPECT_TRUE(ring.PushDroppingOldest(i));
  for (int i = 4; i <= 10; ++i) EXPECT_FALSE(ring.PushDroppingOldest(i));
  EXPECT_EQ(ring.dropped(), 7u);
  EXPECT_EQ(ring.size(), 3u);
  int out = 0;
  for (int expected = 8; expected <= 10; ++expected) {
    ASSERT_TRUE(ring.TryPop(out));
    EXPECT_EQ(out, expected);
  }
  EXPECT_FALSE(ring.TryPop(out));
}

TEST(SpscRing, BehavesLikeABoundedDeque) {
  SpscRing<Item, 5> ring;
  std::deque<std::uint64_t> model;
  std::uint64_t lost = 0;
  std::mt19937 random(1);
  for (std::uint64_t n = 0; n < 20000; ++n) {
    switch (random() % 4) {
      case 0:
        if (model.size() == 5) {
          model.pop_front();
          ++lost;
        }
        model.push_back(n);
        ring.PushDroppingOldest(Item::Make(n));
        break;
      case 1:
        if (model.size() < 5) {
          model.push_back(n);
        } else {
          ++lost;
        }
        ring.TryPush(Item::Make(n));
        break;
      default: {
        Item out;
        ASSERT_EQ(ring.TryPop(out), !model.empty());
        if (!model.empty()) {
          ASSERT_EQ(out.number, model.front());
          ASSERT_TRUE(out.Whole());
          model.pop_front();
        }
      }
    }
    ASSERT_EQ(ring.size(), model.size());
    ASSERT_EQ(ring.dropped(), lost);
  }
}

TEST(SpscRing, CarriesMeasurementsWithEigenMembers) {
  SpscRing<GnssFix, 4> ring;
  GnssFix fix;
  fix.time = GpsTime::FromNs(123);
  fix.position_cov_enu_m2 << 1, 2, 3, 4, 5, 6, 7, 8, 9;
  ring.TryPush(fix);
  GnssFix out;
  ASSERT_TRUE(ring.TryPop(out));
  EXPECT_EQ(out.time, fix.time);
  EXPECT_EQ(out.position_cov_enu_m2, fix.position_cov_enu_m2);
}

/// Two threads at full speed. Whatever the interleaving: items are whole, in order, never twice,
/// and every one is either popped or counted as dropped. Under TSan this also shows the absence of
/// data races.
TEST(SpscRing, TwoThreadsDroppingOldest) {
  constexpr std::uint64_t kItems = 200000;
  SpscRing<Item, 8> ring;
  std::atomic<bool> done{false};
  std::thread producer([&] {
    for (std::uint64_t n = 1; n <= kItems; ++n) ring.PushDroppingOldest(Item::Make(n));
    done.store(true, std::memory_order_release);
  });
  std::uint64_t last = 0, popped = 0, torn = 0, disorder = 0;
  for (;;) {
    const bool was_done = done.load(std::memory_order_acquire);
    Item out;
    if (ring.TryPop(out)) {
      ++popped;
      torn += out.Whole() ? 0u : 1u;
      disorder += out.number > last ? 0u : 1u;
      last = out.number;
    } else if (was_done) {
      break;
    }
  }
  producer.join();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(disorder, 0u);
  EXPECT_EQ(last, kItems);
  EXPECT_EQ(popped + ring.dropped(), kItems);
}

TEST(SpscRing, TwoThreadsRefusing) {
  constexpr std::uint64_t kItems = 20000;
  SpscRing<Item, 64> ring;
  std::thread producer([&] {
    for (std::uint64_t n = 1; n <= kItems; ++n) {
      while (!ring.TryPush(Item::Make(n))) std::this_thread::yield();
    }
  });
  std::uint64_t next = 1, wrong = 0;
  while (next <= kItems) {
    Item out;
    if (!ring.TryPop(out)) {
      std::this_thread::yield();
      continue;
    }
    wrong += (out.number == next && out.Whole()) ? 0u : 1u;
    ++next;
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace kawara::core
