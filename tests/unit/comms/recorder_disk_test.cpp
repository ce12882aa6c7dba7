#include "comms/recorder_disk.hpp"

#include <algorithm>

#include "faulty_file_system.hpp"
#include "log_test_support.hpp"

/// What the recorder does when the disk is full or fails, call by call, without its thread.
namespace kawara::comms {
namespace {

constexpr std::uint64_t kMiB = 1 << 20;

class RecorderDiskTest : public ::testing::Test {
 protected:
  RecorderConfig Config() {
    RecorderConfig config;
    config.folder = folder_.path();
    config.mission = "20260708T063000Z";
    config.segment_bytes = kMiB;
    config.disk_reserve_bytes = 0;
    config.navigation_reserve_bytes = 0;
    return config;
  }
  void Open(const RecorderConfig& config) {
    recorder_.emplace(
        config, Blob{'c'},
        [this](int, const std::string& name, const std::string&) { announced_.push_back(name); },
        disk_);
    ASSERT_TRUE(recorder_->Open(now_));
  }
  bool Take(RecordClass content, std::size_t bytes) {
    const Blob data(bytes, static_cast<std::uint8_t>(number_));
    const std::string channel = content == RecordClass::kPictures ? "FRAME" : "POSE";
    now_ += core::Milliseconds(10);
    const bool taken = recorder_->Take(content, {number_, number_ * 1000, channel, data}, now_);
    if (taken) ++number_;
    return taken;
  }
  bool Navigation(std::size_t bytes = 500) { return Take(RecordClass::kNavigation, bytes); }
  bool Picture(std::size_t bytes = 300'000) { return Take(RecordClass::kPictures, bytes); }
  RecorderStats Stats() {
    RecorderStats stats;
    recorder_->AddTo(stats);
    return stats;
  }
  bool Announced(const std::string& name) { return std::ranges::count(announced_, name) > 0; }
  ReadResult Read() { return ReadLogs({folder_.path()}); }
  static std::int64_t Count(const ReadResult& read, const std::string& channel) {
    return std::ranges::count(read.events, channel, &ReadEvent::channel);
  }

  TestFolder folder_;
  FaultyFileSystem disk_;
  std::optional<RecorderDisk> recorder_;
  std::vector<std::string> announced_;
  core::MonoTime now_ = core::MonoTime::FromNs(1'000'000'000);
  std::int64_t number_ = 1;
};

TEST_F(RecorderDiskTest, SegmentsBySizeReadAsOne) {
  Open(Config());
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(Navigation() && Picture());
  recorder_->Close(now_);
  const ReadResult read = Read();
  EXPECT_EQ(Stats().segments, 11U);  // one of navigation, ten of pictures: four make one over 1 MiB
  ASSERT_EQ(read.events.size(), 81U);
  EXPECT_EQ(read.events[0].channel, "CONFIG");
  for (std::size_t i = 0; i < 81; ++i)
    EXPECT_EQ(read.events[i].number, static_cast<std::int64_t>(i));
  EXPECT_EQ(read.stats.verified, 81U);
  EXPECT_EQ(read.stats.damage_count + read.stats.missing_numbers + read.stats.duplicates, 0U);
}

TEST_F(RecorderDiskTest, EverySegmentOpensWithConfig) {
  Open(Config());
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(Picture());
  recorder_->Close(now_);
  for (const char* name :
       {"navigation-000000.lcmlog", "pictures-000000.lcmlog", "pictures-000001.lcmlog"}) {
    const ReadResult read = ReadLogs({recorder_->folder() / name});
    ASSERT_FALSE(read.events.empty());
    EXPECT_EQ(read.events[0].channel, "CONFIG") << name;
    EXPECT_EQ(read.stats.missing_numbers, 0U) << name;
  }
}

TEST_F(RecorderDiskTest, SegmentsByTime) {
  RecorderConfig config = Config();
  config.segment_duration = core::Seconds(60);
  Open(config);
  ASSERT_TRUE(Navigation());
  now_ += core::Seconds(61);
  ASSERT_TRUE(Navigation());
  recorder_->Close(now_);
  EXPECT_TRUE(std::filesystem::exists(recorder_->folder() / "navigation-000001.lcmlog"));
}

TEST_F(RecorderDiskTest, MissionNameTakenAlready) {
  Open(Config());
  const auto first = recorder_->folder();
  recorder_->Close(now_);
  Open(Config());
  EXPECT_EQ(recorder_->folder(), first.string() + "-1");
}

TEST_F(RecorderDiskTest, FullDiskTakesTheOldestPicturesFirst) {
  disk_.capacity_bytes = 6 * kMiB;
  Open(Config());
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(Navigation() && Picture()) << i;
  recorder_->Close(now_);
  const ReadResult read = Read();
  EXPECT_EQ(Count(read, "POSE"), 60);
  const std::int64_t pictures = Count(read, "FRAME");
  EXPECT_GE(pictures, 10);
  EXPECT_LE(pictures, static_cast<std::int64_t>(disk_.capacity_bytes / 300'000));
  EXPECT_EQ(read.events.back().channel, "FRAME");  // the newest stayed
  EXPECT_GT(Stats().deleted_segments, 5U);
  EXPECT_EQ(Stats().dropped_events[0] + Stats().dropped_events[1], 0U);
  EXPECT_TRUE(Announced("recorder.pictures_deleted"));
  EXPECT_EQ(read.stats.missing_numbers, static_cast<std::uint64_t>(60 - pictures));
}

TEST_F(RecorderDiskTest, PicturesOfOlderMissionsGoFirst) {
  const auto old = folder_ / "20250101T000000Z";
  const auto notes = folder_ / "00notes";
  for (const auto& path : {old, notes}) {
    std::filesystem::create_directory(path);
    WriteAll(path / "pictures-000000.lcmlog", Blob(1000, 0));
  }
  WriteAll(old / "navigation-000000.lcmlog", Blob(1000, 0));
  disk_.capacity_bytes = 3 * kMiB;
  Open(Config());
  for (int i = 0; i < 12; ++i) ASSERT_TRUE(Picture());
  EXPECT_FALSE(std::filesystem::exists(old / "pictures-000000.lcmlog"));
  EXPECT_TRUE(std::filesystem::exists(old / "navigation-000000.lcmlog"));
  EXPECT_TRUE(
      std::filesystem::exists(notes / "pictures-000000.lcmlog"));  // not a mission of the recorder
}

TEST_F(RecorderDiskTest, ReserveIsKeptFreeByDeletingPictures) {
  RecorderConfig config = Config();
  config.disk_reserve_bytes = 4 * kMiB;
  disk_.capacity_bytes = 10 * kMiB;
  Open(config);
  for (int i = 0; i < 200; ++i) {
    ASSERT_TRUE(Navigation(100) && Picture(100'000));
    now_ += core::Milliseconds(500);
    recorder_->Service(now_);
    EXPECT_GE(disk_.FreeBytes("").value(),
              3 * kMiB);  // one second of pictures short of the reserve at most
  }
  EXPECT_GT(Stats().deleted_segments, 5U);
  EXPECT_EQ(Stats().dropped_events[0], 0U);
}

TEST_F(RecorderDiskTest, FullForGoodPausesPicturesThenUsesTheReserveThenWaits) {
  RecorderConfig config = Config();
  config.navigation_reserve_bytes = kMiB;
  disk_.capacity_bytes = 3 * kMiB;
  Open(config);
  int taken = 0;
  while (taken < 100 && Navigation(100'000)) {
    ++taken;
    (void)Picture(100'000);
  }
  // 3 MiB of navigation fit, its reserve included, and no picture is left of them.
  EXPECT_GE(taken, 28);
  EXPECT_TRUE(Announced("recorder.pictures_paused"));
  EXPECT_TRUE(Announced("recorder.reserve_used"));
  EXPECT_TRUE(Announced("recorder.navigation_waiting"));
  EXPECT_GT(Stats().dropped_events[1], 0U);
  EXPECT_EQ(Stats().dropped_events[0], 0U);
  EXPECT_FALSE(Navigation());  // stays in the caller's queue

  disk_.capacity_bytes = 100 * kMiB;  // somebody made room
  now_ += core::Seconds(2);
  recorder_->Service(now_);
  EXPECT_TRUE(Navigation());
  EXPECT_TRUE(Picture());
  EXPECT_TRUE(Announced("recorder.navigation_resumed"));
  EXPECT_TRUE(Announced("recorder.pictures_resumed"));
  recorder_->Close(now_);
  const ReadResult read = Read();
  EXPECT_EQ(Count(read, "POSE"), taken + 1);  // the last of `taken` waited in the writer
  EXPECT_EQ(read.stats.damage_count, 0U);
}

TEST_F(RecorderDiskTest, WriteErrorGoesOnInANewSegment) {
  Open(Config());
  for (int i = 0; i < 30; ++i) {
    if (i == 10) disk_.failing_writes = 1;
    ASSERT_TRUE(Navigation());
  }
  recorder_->Close(now_);
  const ReadResult read = Read();
  EXPECT_EQ(Count(read, "POSE"), 30);
  EXPECT_EQ(Stats().disk_errors, 1U);
  EXPECT_EQ(Stats().dropped_events[0], 0U);
  EXPECT_TRUE(Announced("recorder.disk_error"));
  EXPECT_TRUE(std::filesystem::exists(recorder_->folder() / "navigation-000001.lcmlog"));
  EXPECT_EQ(read.stats.missing_numbers, 0U);
}

// A failed fdatasync may have thrown away what was written before it.
TEST_F(RecorderDiskTest, SyncErrorLosesNothing) {
  Open(Config());
  for (int i = 0; i < 60; ++i) {
    if (i % 15 == 5) disk_.failing_syncs = 1;
    ASSERT_TRUE(Navigation());
  }
  recorder_->Close(now_);
  const ReadResult read = Read();
  EXPECT_EQ(Count(read, "POSE"), 60);
  EXPECT_EQ(read.stats.missing_numbers, 0U);
  EXPECT_EQ(Stats().disk_errors, 4U);
}

TEST_F(RecorderDiskTest, DeadDiskWaitsAndComesBack) {
  Open(Config());
  ASSERT_TRUE(Navigation());
  disk_.failing_writes = 1000;
  while (Navigation()) {
  }
  EXPECT_TRUE(Announced("recorder.navigation_waiting"));
  const auto waiting_from = number_;
  now_ += core::Seconds(10);
  recorder_->Service(now_);
  EXPECT_FALSE(Navigation());
  disk_.failing_writes = 0;
  now_ += core::Seconds(1);
  EXPECT_TRUE(Navigation());
  recorder_->Close(now_);
  EXPECT_EQ(Count(Read(), "POSE"), waiting_from);
  EXPECT_EQ(std::ranges::count(announced_, "recorder.navigation_waiting"), 1);
  EXPECT_EQ(std::ranges::count(announced_, "recorder.navigation_resumed"), 1);
}

TEST_F(RecorderDiskTest, WhatTheDeadDiskNeverTookIsCounted) {
  Open(Config());
  ASSERT_TRUE(Navigation());
  ASSERT_TRUE(recorder_->Sync(now_));
  disk_.failing_writes = 1 << 30;
  int taken = 0;
  while (Navigation()) ++taken;
  recorder_->Close(now_);
  EXPECT_EQ(Stats().dropped_events[0], static_cast<std::uint64_t>(taken));
  EXPECT_EQ(Count(Read(), "POSE"), 1);
}

TEST_F(RecorderDiskTest, CannotStart) {
  RecorderConfig config = Config();
  disk_.failing_creates = 1;
  config.navigation_reserve_bytes = 0;
  RecorderDisk recorder(
      config, Blob{}, [](int, const std::string&, const std::string&) {}, disk_);
  const auto opened = recorder.Open(now_);
  ASSERT_FALSE(opened.has_value());
  EXPECT_NE(opened.error().message.find("navigation-000000"), std::string::npos)
      << opened.error().message;
}

}  // namespace
}  // namespace kawara::comms
