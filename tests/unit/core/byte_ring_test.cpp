#include "core/byte_ring.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <random>
#include <thread>
#include <vector>

namespace kawara::core {
namespace {

struct Header {
  std::int64_t stamp = 0;
  std::uint32_t channel = 0;
};
using Bytes = std::vector<std::uint8_t>;

Bytes Pattern(std::size_t size, std::uint64_t seed) {
  Bytes bytes(size);
  for (std::size_t i = 0; i < size; ++i) bytes[i] = static_cast<std::uint8_t>(seed * 31 + i * 7);
  return bytes;
}

TEST(ByteRing, EmptyRecordsAreRecords) {
  ByteRing<Header> ring(256);
  ASSERT_TRUE(ring.TryPush({5, 6}, {}));
  int calls = 0;
  EXPECT_TRUE(ring.TryPop([&](const Header& h, std::span<const std::uint8_t> bytes) {
    ++calls;
    EXPECT_EQ(h.stamp, 5);
    EXPECT_EQ(h.channel, 6u);
    EXPECT_TRUE(bytes.empty());
  }));
  EXPECT_EQ(calls, 1);
  EXPECT_FALSE(ring.TryPop([&](const Header&, auto) { ++calls; }));
  EXPECT_EQ(calls, 1);
}

TEST(ByteRing, RefusesWhatCanNeverFit) {
  ByteRing<Header> ring(1024);
  EXPECT_FALSE(ring.TryPush({}, Bytes(ring.max_record_bytes() + 1)));
  EXPECT_EQ(ring.refused(), 1u);
  EXPECT_TRUE(ring.empty());
}

TEST(ByteRing, KeepsTheOldWhenFull) {
  ByteRing<Header> ring(1024);
  std::int64_t n = 0;
  while (ring.TryPush({n, 0}, Pattern(100, static_cast<std::uint64_t>(n)))) ++n;
  EXPECT_GE(n, 6);
  EXPECT_EQ(ring.refused(), 1u);
  for (std::int64_t i = 0; i < n; ++i) {
    ASSERT_TRUE(ring.TryPop([&](const Header& h, auto) { EXPECT_EQ(h.stamp, i); }));
  }
  EXPECT_TRUE(ring.empty());
}

/// The promise of max_record_bytes: wherever the ends stand, the longest record fits into an empty
/// ring.
TEST(ByteRing, LongestRecordFitsAtEveryPosition) {
  for (const std::size_t capacity : {64u, 96u, 256u, 1000u, 1040u}) {
    ByteRing<Header> ring(capacity);
    const Bytes longest = Pattern(ring.max_record_bytes(), 3);
    for (std::size_t step = 0; step < capacity; ++step) {
      ASSERT_TRUE(ring.TryPush({}, longest)) << capacity << " step " << step;
      ASSERT_TRUE(ring.TryPop([&](const Header&, std::span<const std::uint8_t> bytes) {
        ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), longest.begin(), longest.end()));
      }));
      ASSERT_TRUE(ring.TryPush({}, {}));  // moves the ends on by the smallest step
      ASSERT_TRUE(ring.TryPop([](const Header&, auto) {}));
    }
  }
}

TEST(ByteRing, BehavesLikeAQueue) {
  ByteRing<Header> ring(2048);
  std::deque<std::pair<std::int64_t, Bytes>> model;
  std::mt19937 random(2);
  for (std::int64_t n = 0; n < 50000; ++n) {
    if (random() % 2 == 0) {
      const Bytes bytes = Pattern(random() % (random() % 8 == 0 ? 1000 : 60), random());
      if (ring.TryPush({n, static_cast<std::uint32_t>(bytes.size())}, bytes)) {
        model.emplace_back(n, bytes);
      } else {
        ASSERT_GT(ring.used_bytes() + 2 * bytes.size() + 64, ring.capacity_bytes())
            << "refused although there was room";
      }
    } else {
      const bool popped = ring.TryPop([&](const Header& h, std::span<const std::uint8_t> bytes) {
        ASSERT_FALSE(model.empty());
        ASSERT_EQ(h.stamp, model.front().first);
        ASSERT_EQ(h.channel, bytes.size());
        ASSERT_TRUE(std::equal(bytes.begin(), bytes.end(), model.front().second.begin(),
                               model.front().second.end()));
      });
      ASSERT_EQ(popped, !model.empty());
      if (popped) model.pop_front();
    }
  }
}

TEST(ByteRing, TwoThreads) {
  constexpr std::int64_t kRecords = 10000;
  ByteRing<Header> ring(16384);
  std::thread producer([&] {
    Bytes bytes(300);
    for (std::int64_t n = 0; n < kRecords; ++n) {
      const std::size_t size = static_cast<std::size_t>(n * 37 % 300);
      for (std::size_t i = 0; i < size; ++i)
        bytes[i] = static_cast<std::uint8_t>(n + std::int64_t(i));
      while (!ring.TryPush({n, 1}, std::span(bytes).first(size))) std::this_thread::yield();
    }
  });
  std::int64_t next = 0, wrong = 0;
  while (next < kRecords) {
    const bool popped = ring.TryPop([&](const Header& h, std::span<const std::uint8_t> bytes) {
      if (h.stamp != next || bytes.size() != static_cast<std::size_t>(next * 37 % 300)) ++wrong;
      for (std::size_t i = 0; i < bytes.size(); ++i) {
        if (bytes[i] != static_cast<std::uint8_t>(next + std::int64_t(i))) ++wrong;
      }
      ++next;
    });
    if (!popped) std::this_thread::yield();
  }
  producer.join();
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace kawara::core
