#include "comms/recorder.hpp"

#include <sched.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdio>
#include <kawara/event_t.hpp>
#include <random>
#include <set>

#include "comms/codec.hpp"
#include "faulty_file_system.hpp"
#include "log_test_support.hpp"

/// The recorder with its thread, and what is left of a recording when the process dies.
namespace kawara::comms {
namespace {

RecorderConfig SmallConfig(const std::filesystem::path& folder) {
  RecorderConfig config;
  config.folder = folder;
  config.mission = "m";
  config.segment_bytes = 64 << 10;
  config.navigation_sync = core::Milliseconds(20);
  config.picture_sync = core::Milliseconds(20);
  config.navigation_queue_bytes = 1 << 20;
  config.picture_queue_bytes = 4 << 20;
  config.disk_reserve_bytes = 0;
  config.navigation_reserve_bytes = 0;
  return config;
}

// Message i of writer w: the receiver can check every byte.
Blob Stamped(std::uint32_t writer, std::uint32_t i, std::size_t size) {
  Blob data(std::max<std::size_t>(size, 8));
  for (std::size_t k = 0; k < 4; ++k) {
    data[k] = static_cast<std::uint8_t>(writer >> (8 * k));
    data[4 + k] = static_cast<std::uint8_t>(i >> (8 * k));
  }
  for (std::size_t k = 8; k < data.size(); ++k) data[k] = static_cast<std::uint8_t>(i * 31 + k);
  return data;
}

TEST(Recorder, KeepsTheOrderOfCallsOverBothContents) {
  const TestFolder folder;
  auto recorder = Recorder::Start(SmallConfig(folder.path()), Blob{});
  ASSERT_TRUE(recorder.has_value()) << recorder.error().message;
  for (std::uint32_t i = 0; i < 500; ++i) {
    ASSERT_TRUE((*recorder)->Write(i % 7 == 3 ? "FRAME" : "POSE", Stamped(0, i, 50 + i % 5000), i));
    if (i % 100 == 99) {
      ASSERT_TRUE((*recorder)->Flush(core::Seconds(20)));
    }
  }
  (*recorder)->Stop();
  const ReadResult read = ReadLogs({folder.path()});
  std::uint32_t i = 0;
  for (const ReadEvent& event : read.events) {
    if (event.channel == "CONFIG" || event.channel == "EVENT") continue;
    EXPECT_EQ(event.data, Stamped(0, i, 50 + i % 5000)) << i;
    ++i;
  }
  EXPECT_EQ(i, 500U);
  EXPECT_EQ(read.stats.missing_numbers, 0U);
  EXPECT_EQ(read.stats.verified, read.stats.events);
}

// Run it under TSan: many writers, one recorder, a reader of the statistics.
TEST(Recorder, ManyWriters) {
  constexpr std::uint32_t kWriters = 4;
  constexpr std::uint32_t kEach = 2000;
  const TestFolder folder;
  auto recorder = Recorder::Start(SmallConfig(folder.path()), Blob{});
  ASSERT_TRUE(recorder.has_value());
  std::array<std::uint64_t, kWriters> refused{};
  {
    std::vector<std::jthread> threads;
    for (std::uint32_t w = 0; w < kWriters; ++w) {
      threads.emplace_back([&, w] {
        for (std::uint32_t i = 0; i < kEach; ++i) {
          const bool taken =
              (*recorder)->Write(w == 0 ? "FRAME" : "RAW.GPS", Stamped(w, i, (i * 97) % 3000), i);
          refused[w] += taken ? 0 : 1;
          if (i % 256 == 0) (void)(*recorder)->stats();
        }
      });
    }
  }
  (*recorder)->Stop();
  const RecorderStats stats = (*recorder)->stats();
  const ReadResult read = ReadLogs({folder.path()});
  std::array<std::set<std::uint32_t>, kWriters> seen;
  std::array<std::int64_t, kWriters> last{-1, -1, -1, -1};
  for (const ReadEvent& event : read.events) {
    if (event.channel != "FRAME" && event.channel != "RAW.GPS") continue;
    const std::uint32_t w = event.data[0];
    const auto i = static_cast<std::uint32_t>(event.data[4] | event.data[5] << 8);
    ASSERT_LT(w, kWriters);
    EXPECT_EQ(event.data, Stamped(w, i, (i * 97) % 3000));
    EXPECT_GT(static_cast<std::int64_t>(i), last[w]);
    last[w] = i;
    seen[w].insert(i);
  }
  std::uint64_t dropped = 0;
  for (std::uint32_t w = 0; w < kWriters; ++w) {
    EXPECT_EQ(seen[w].size() + refused[w], kEach) << w;
    dropped += refused[w];
  }
  EXPECT_EQ(stats.dropped_events[0] + stats.dropped_events[1], dropped);
  EXPECT_EQ(read.stats.missing_numbers, dropped);
}

TEST(Recorder, SlowDiskIsBuffered) {
  const TestFolder folder;
  FaultyFileSystem disk;
  auto recorder = Recorder::Start(SmallConfig(folder.path()), Blob{}, {}, disk);
  ASSERT_TRUE(recorder.has_value());
  disk.hold_writes = true;
  ASSERT_TRUE((*recorder)->Write("POSE", Stamped(0, 0, 200), 0));
  while (disk.held == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  // 5 s at 100 Hz of 1 KB and 5 pictures of 600 KB, handed over while the disk sits on one write.
  for (std::uint32_t i = 1; i < 500; ++i) {
    ASSERT_TRUE((*recorder)->Write("POSE", Stamped(0, i, 1000), i));
    if (i % 100 == 0) {
      ASSERT_TRUE((*recorder)->Write("FRAME", Stamped(0, i, 600'000), i));
    }
  }
  EXPECT_EQ(disk.held, 1);
  disk.hold_writes = false;
  (*recorder)->Stop();
  EXPECT_EQ((*recorder)->stats().dropped_events[0], 0U);
  EXPECT_EQ(ReadLogs({folder.path()}).stats.missing_numbers, 0U);
}

// What is lost is said in the log itself.
TEST(Recorder, DropsAreCountedInTheLog) {
  const TestFolder folder;
  FaultyFileSystem disk;
  std::vector<std::string> announced;
  std::mutex mutex;
  RecorderConfig config = SmallConfig(folder.path());
  config.navigation_queue_bytes = 64 << 10;
  auto recorder = Recorder::Start(
      config, Blob{},
      [&](const RecorderEvent& event) {
        const std::lock_guard lock(mutex);
        announced.push_back(event.name);
      },
      disk);
  ASSERT_TRUE(recorder.has_value());
  {
    const std::lock_guard lock(disk.mutex);
    disk.capacity_bytes = 0;
  }
  std::uint64_t refused = 0;
  for (std::uint32_t i = 0; i < 20000 && refused < 10; ++i) {
    if (!(*recorder)->Write("POSE", Stamped(0, i, 1000), i)) ++refused;
    if (refused == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_EQ(refused, 10U);
  {
    const std::lock_guard lock(disk.mutex);
    disk.capacity_bytes = UINT64_MAX;
  }
  for (int i = 0; i < 500; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    const std::lock_guard lock(mutex);
    if (std::ranges::count(announced, "recorder.navigation_dropped") > 0) break;
  }
  (*recorder)->Stop();
  const ReadResult read = ReadLogs({folder.path()});
  EXPECT_EQ(read.stats.missing_numbers, 10U);
  std::set<std::string> logged;
  for (const ReadEvent& event : read.events) {
    if (event.channel == "EVENT") logged.insert(Decode<event_t>(event.data)->name);
  }
  EXPECT_TRUE(logged.contains("recorder.navigation_waiting"));
  EXPECT_TRUE(logged.contains("recorder.navigation_resumed"));
  EXPECT_TRUE(logged.contains("recorder.navigation_dropped"));
}

TEST(Recorder, RefusesWhatIsNoMessage) {
  const TestFolder folder;
  auto recorder = Recorder::Start(SmallConfig(folder.path()), Blob{});
  ASSERT_TRUE(recorder.has_value());
  EXPECT_FALSE((*recorder)->Write("", Blob{1}, 0));
  EXPECT_FALSE((*recorder)->Write(std::string(64, 'x'), Blob{1}, 0));
  EXPECT_FALSE(
      (*recorder)->Write("BIG", Blob(2 << 20), 0));  // larger than the queue: counted as dropped
  (*recorder)->Stop();
  EXPECT_EQ((*recorder)->stats().dropped_events[0], 1U);
}

/// Runs f in a child process; gtest failures and crashes in there are its exit status.
template <class F>
pid_t Fork(F f) {
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    f();
    ::_exit(::testing::Test::HasFailure() ? 1 : 0);
  }
  return child;
}

// kill -9 at any moment: what Flush acknowledged is there, whole, and the log reads without repair.
TEST(Recorder, KilledAtAnyMomentKeepsWhatWasAcknowledged) {
  std::mt19937 random(1);
  for (int round = 0; round < 25; ++round) {
    const TestFolder folder;
    int acknowledged_pipe[2];
    ASSERT_EQ(::pipe(acknowledged_pipe), 0);
    const pid_t child = Fork([&] {
      auto recorder = Recorder::Start(SmallConfig(folder.path()), Blob{});
      for (std::uint32_t i = 0; recorder; ++i) {
        (void)(*recorder)->Write(i % 5 == 0 ? "PHASE1" : "POSE", Stamped(7, i, (i * 131) % 4000),
                                 i);
        if (i % 9 == 8 && (*recorder)->Flush(core::Seconds(60))) {
          if (::write(acknowledged_pipe[1], &i, sizeof i) != sizeof i) ::_exit(2);
        }
      }
    });
    ::close(acknowledged_pipe[1]);
    // The moment is counted in acknowledgements and a little time, so that it falls everywhere in a
    // cycle.
    std::uint32_t acknowledged = 0;
    const int after = static_cast<int>(random() % 6) + 1;
    for (int k = 0; k < after; ++k) {
      ASSERT_EQ(::read(acknowledged_pipe[0], &acknowledged, sizeof acknowledged),
                static_cast<ssize_t>(sizeof acknowledged));
    }
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 20000));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    std::uint32_t more = 0;
    while (::read(acknowledged_pipe[0], &more, sizeof more) == static_cast<ssize_t>(sizeof more))
      acknowledged = more;
    ::close(acknowledged_pipe[0]);

    const ReadResult read = ReadLogs({folder.path()});
    std::uint32_t next = 0;
    for (const ReadEvent& event : read.events) {
      if (event.channel != "PHASE1" && event.channel != "POSE") continue;
      const auto i =
          static_cast<std::uint32_t>(event.data[4] | event.data[5] << 8 | event.data[6] << 16);
      EXPECT_EQ(event.data, Stamped(7, i, (i * 131) % 4000));
      if (i <= acknowledged) {
        EXPECT_EQ(i, next);
      }
      next = i + 1;
    }
    EXPECT_GT(next, acknowledged) << "round " << round;
  }
}

// A real file system that is really full: 8 MiB of memory, mounted in a namespace of the child's
// own.
TEST(Recorder, FullTmpfs) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to mount a tmpfs";
  const TestFolder folder;
  const pid_t child = Fork([&] {
    if (::unshare(CLONE_NEWNS) != 0 ||
        ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("tmpfs", folder.path().c_str(), "tmpfs", 0, "size=8m") != 0) {
      ::_exit(77);
    }
    RecorderConfig config = SmallConfig(folder.path());
    config.segment_bytes = 1 << 20;
    config.navigation_reserve_bytes = 1 << 20;
    auto recorder = Recorder::Start(config, Blob{});
    ASSERT_TRUE(recorder.has_value()) << recorder.error().message;
    for (std::uint32_t i = 0; i < 200; ++i) {
      EXPECT_TRUE((*recorder)->Write("POSE", Stamped(1, i, 400), i));
      EXPECT_TRUE((*recorder)->Write("FRAME", Stamped(2, i, 200'000), i));
      EXPECT_TRUE((*recorder)->Flush(core::Seconds(60)));
    }
    (*recorder)->Stop();
    const RecorderStats stats = (*recorder)->stats();
    EXPECT_EQ(stats.dropped_events[0], 0U);
    EXPECT_GT(stats.deleted_segments, 20U);
    const ReadResult read = ReadLogs({folder.path()});
    EXPECT_EQ(std::ranges::count(read.events, "POSE", &ReadEvent::channel), 200);
    EXPECT_GT(std::ranges::count(read.events, "FRAME", &ReadEvent::channel), 10);
    EXPECT_EQ(read.stats.damage_count, 0U);
  });
  int status = 0;
  ASSERT_EQ(::waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "cannot mount here";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace kawara::comms
