#include <gtest/gtest.h>

#include <thread>

#include "core/config/config.hpp"
#include "station/epoch_gaps.hpp"
#include "station/item_queue.hpp"
#include "station/station_config.hpp"

namespace kawara::station {
namespace {

Item Picture(std::int64_t epoch, std::size_t bytes) {
  gis::PanoramaRecord record;
  record.epoch = epoch;
  record.jpeg = std::make_shared<const std::vector<std::uint8_t>>(bytes);
  return {.record = std::move(record), .received = {}};
}
Item Row() { return {.record = gis::PoseRecord{}, .received = {}}; }

TEST(EpochGaps, CountsFromWhereverItJoined) {
  EpochGaps gaps;
  for (const int n : {100, 101, 105, 106}) EXPECT_TRUE(gaps.Take(n));
  EXPECT_EQ(gaps.missing(), 3);
}

TEST(EpochGaps, AFilledHoleIsLateAndARepeatIsNothing) {
  EpochGaps gaps;
  for (const int n : {1, 4}) gaps.Take(n);
  EXPECT_TRUE(gaps.Take(2));
  EXPECT_FALSE(gaps.Take(2));
  EXPECT_FALSE(gaps.Take(4));
  EXPECT_EQ(gaps.missing(), 1);
  EXPECT_EQ(gaps.late(), 1);
}

TEST(EpochGaps, AHugeJumpCostsNoMemory) {
  EpochGaps gaps;
  gaps.Take(1);
  gaps.Take(1'000'000'000'000);
  EXPECT_EQ(gaps.missing(), 999'999'999'998);
  EXPECT_TRUE(gaps.Take(999'999'999'999));
  EXPECT_FALSE(gaps.Take(2)) << "too long ago to know";
}

TEST(ItemQueue, HandsOverInOrderWithinTheBatchLimit) {
  ItemQueue queue(1 << 20);
  for (int i = 1; i <= 3; ++i) queue.Push(Picture(i, 1000));
  const auto batch = queue.Pop(core::Duration(0), 2 * Picture(1, 1000).bytes());
  ASSERT_EQ(batch.size(), 2U);
  EXPECT_EQ(batch[0].picture()->epoch, 1);
  EXPECT_EQ(queue.Pop(core::Duration(0), 1).size(), 1U) << "always at least one";
  EXPECT_TRUE(queue.Pop(core::Duration(0), 1).empty());
}

TEST(ItemQueue, TheOldestPictureGivesWayAndNavigationStays) {
  const std::size_t picture_bytes = Picture(1, 10'000).bytes();
  ItemQueue queue(3 * picture_bytes);
  queue.Push(Row());
  for (int i = 1; i <= 4; ++i) queue.Push(Picture(i, 10'000));
  EXPECT_EQ(queue.dropped_pictures(), 2);
  EXPECT_EQ(queue.dropped_rows(), 0);
  const auto batch = queue.Pop(core::Duration(0), 1 << 20);
  ASSERT_EQ(batch.size(), 3U);
  EXPECT_EQ(batch[0].picture(), nullptr);
  EXPECT_EQ(batch[1].picture()->epoch, 3);
}

TEST(ItemQueue, BetweenTwoThreadsNothingIsLost) {
  ItemQueue queue(1 << 28);
  constexpr int kItems = 5000;
  std::thread producer([&queue] {
    for (int i = 1; i <= kItems; ++i) queue.Push(Picture(i, 10));
    queue.Stop();
  });
  std::int64_t expected = 1;
  for (;;) {
    const auto batch = queue.Pop(core::Seconds(5), 10'000);
    if (batch.empty()) break;
    for (const Item& item : batch) EXPECT_EQ(item.picture()->epoch, expected++);
  }
  producer.join();
  EXPECT_EQ(expected, kItems + 1);
}

TEST(StationConfig, TheCommentedFileIsTheDefaults) {
  const auto file =
      core::config::Load<StationConfig>(std::string(KAWARA_SOURCE_DIR) + "/configs/station.yaml");
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(core::config::Dump(*file), core::config::Dump(StationConfig{}));
}

}  // namespace
}  // namespace kawara::station
