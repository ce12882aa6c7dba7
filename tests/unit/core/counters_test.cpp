#include "core/counters.hpp"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

namespace kawara::core {
namespace {

TEST(Counters, SnapshotIsSortedByName) {
  Counters counters;
  counters.Register("link.tx.expired").Add(3);
  counters.Register("gps.nmea.bad_checksum").Add();
  counters.Register("ahrs.gaps");
  const std::vector<Counters::Value> expected{
      {"ahrs.gaps", 0}, {"gps.nmea.bad_checksum", 1}, {"link.tx.expired", 3}};
  EXPECT_EQ(counters.Snapshot(), expected);
}

TEST(Counters, SameNameIsSameCounter) {
  Counters counters;
  Counter& a = counters.Register("a.b");
  for (int i = 0; i < 100; ++i) counters.Register("x" + std::to_string(i));
  EXPECT_EQ(&counters.Register("a.b"), &a);
}

TEST(CountersDeathTest, BadNamesAreOurBug) {
  Counters counters;
  for (const char* name : {"", ".", "a.", ".a", "a..b", "Gps", "a b", "a-b"}) {
    EXPECT_DEATH(counters.Register(name), "IsDottedName") << name;
  }
}

TEST(Counters, ThreadsLoseNothing) {
  Counters counters;
  Counter& counter = counters.Register("a");
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&] {
      for (int i = 0; i < 10000; ++i) counter.Add();
    });
  }
  for (int i = 0; i < 50; ++i) counters.Snapshot();
  for (auto& thread : threads) thread.join();
  EXPECT_EQ(counter.value(), 40000);
}

}  // namespace
}  // namespace kawara::core
