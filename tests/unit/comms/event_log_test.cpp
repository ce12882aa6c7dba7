#include <lcm/eventlog.h>

#include <memory>

#include "comms/crc32c.hpp"
#include "log_test_support.hpp"

namespace kawara::comms {
namespace {

// Writes events 0..count-1; a LOG.CRC after every `batch` of them.
void WriteTestLog(const std::filesystem::path& path, std::int64_t count, std::int64_t batch,
                  bool crc = true) {
  auto writer = EventLogWriter::Create(
      path, {.sync_interval = std::chrono::hours(1), .fdatasync = false, .crc = crc});
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  for (std::int64_t i = 0; i < count; ++i) {
    const Blob data = TestData(i);
    ASSERT_TRUE(writer->Append(TestTime(i), TestChannel(i), data, core::MonoTime::FromNs(1)));
    if (i % batch == batch - 1) {
      ASSERT_TRUE(writer->Sync());
    }
  }
  ASSERT_TRUE(writer->Close());
}

void ExpectAll(const ReadResult& read, std::int64_t count) {
  ASSERT_EQ(static_cast<std::int64_t>(read.events.size()), count);
  for (std::int64_t i = 0; i < count; ++i)
    EXPECT_EQ(IndexOf(read.events[static_cast<std::size_t>(i)]), i);
}

TEST(Crc32c, KnownAnswers) {
  // RFC 3720 appendix B.4.
  Blob bytes(32, 0);
  EXPECT_EQ(Crc32c(bytes), 0x8A9136AAU);
  bytes.assign(32, 0xff);
  EXPECT_EQ(Crc32c(bytes), 0x62A8AB43U);
  for (std::size_t i = 0; i < 32; ++i) bytes[i] = static_cast<std::uint8_t>(i);
  EXPECT_EQ(Crc32c(bytes), 0x46DD794EU);
  const std::string nine = "123456789";
  EXPECT_EQ(Crc32c({reinterpret_cast<const std::uint8_t*>(nine.data()), nine.size()}), 0xE3069283U);
}

TEST(Crc32c, PortableAndContinuedAgree) {
  const Blob bytes = TestData(300 / 37 * 8);
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    const auto part = std::span(bytes).first(n);
    EXPECT_EQ(Crc32c(part), internal::Crc32cPortable(part, 0)) << n;
    EXPECT_EQ(Crc32c(std::span(bytes).subspan(n), Crc32c(part)), Crc32c(bytes)) << n;
  }
}

TEST(EventLog, RoundTripIsVerified) {
  const TestFolder folder;
  WriteTestLog(folder / "a.lcmlog", 500, 40);
  const ReadResult read = ReadLogs({folder / "a.lcmlog"});
  ExpectAll(read, 500);
  EXPECT_EQ(read.stats.verified, 500U);
  EXPECT_EQ(read.stats.damage_count, 0U);
  EXPECT_EQ(read.stats.missing_numbers, 0U);
  EXPECT_EQ(read.stats.bytes, std::filesystem::file_size(folder / "a.lcmlog"));
}

TEST(EventLog, LcmReadsOurs) {
  const TestFolder folder;
  WriteTestLog(folder / "a.lcmlog", 200, 30);
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "a.lcmlog").c_str(), "r");
  ASSERT_NE(log, nullptr);
  std::int64_t i = 0;
  std::int64_t lists = 0;
  while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
    const std::string channel(event->channel, static_cast<std::size_t>(event->channellen));
    if (channel != kLogCrcChannel) {
      const auto* bytes = static_cast<const std::uint8_t*>(event->data);
      EXPECT_EQ(event->eventnum, i);
      EXPECT_EQ(channel, TestChannel(i));
      EXPECT_EQ(event->timestamp, TestTime(i));
      EXPECT_EQ(Blob(bytes, bytes + event->datalen), TestData(i));
      ++i;
    } else {
      EXPECT_EQ(event->eventnum, i - 1);
      ++lists;
    }
    lcm_eventlog_free_event(event);
  }
  lcm_eventlog_destroy(log);
  EXPECT_EQ(i, 200);
  EXPECT_EQ(lists, 7);  // after 30, 60, ... 180 and at the end
}

TEST(EventLog, OursReadsLcm) {
  const TestFolder folder;
  lcm_eventlog_t* log = lcm_eventlog_create((folder / "lcm.log").c_str(), "w");
  ASSERT_NE(log, nullptr);
  for (std::int64_t i = 0; i < 200; ++i) {
    std::string channel = TestChannel(i);
    Blob data = TestData(i);
    lcm_eventlog_event_t event{};
    event.timestamp = TestTime(i);
    event.channellen = static_cast<std::int32_t>(channel.size());
    event.datalen = static_cast<std::int32_t>(data.size());
    event.channel = channel.data();
    event.data = data.data();
    ASSERT_EQ(lcm_eventlog_write_event(log, &event), 0);
  }
  lcm_eventlog_destroy(log);
  const ReadResult read = ReadLogs({folder / "lcm.log"});
  ExpectAll(read, 200);
  EXPECT_EQ(read.stats.verified, 0U);
  EXPECT_EQ(read.stats.damage_count, 0U);
}

TEST(EventLog, RefusesToOverwrite) {
  const TestFolder folder;
  WriteTestLog(folder / "a.lcmlog", 1, 1);
  const auto again = EventLogWriter::Create(folder / "a.lcmlog");
  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().code, core::ErrorCode::kInvalidArgument);
}

TEST(EventLog, RefusesWhatCannotBeRead) {
  const TestFolder folder;
  auto writer = EventLogWriter::Create(folder / "a.lcmlog");
  ASSERT_TRUE(writer.has_value());
  for (const std::string& channel : {std::string(), std::string(64, 'A'), std::string("A\nB")}) {
    EXPECT_FALSE(writer->Append(1, channel, {}, core::MonoTime::FromNs(1)).has_value()) << channel;
  }
  EXPECT_EQ(writer->appended_events(), 0U);
}

TEST(EventLog, NotALog) {
  const TestFolder folder;
  const std::string text = "GPS notes, not a log\n";
  WriteAll(folder / "notes.txt", Blob(text.begin(), text.end()));
  std::filesystem::create_directory(folder / "empty");
  const struct {
    std::filesystem::path path;
    core::ErrorCode code;
  } cases[] = {{folder / "notes.txt", core::ErrorCode::kFormat},
               {folder / "missing.lcmlog", core::ErrorCode::kNotFound},
               {folder / "empty", core::ErrorCode::kNotFound}};
  for (const auto& c : cases) {
    const auto reader = EventLogReader::Open({c.path});
    ASSERT_FALSE(reader.has_value()) << c.path;
    EXPECT_EQ(reader.error().code, c.code) << reader.error().message;
  }
}

TEST(EventLog, SyncIsDueByTime) {
  const TestFolder folder;
  auto writer =
      EventLogWriter::Create(folder / "a.lcmlog", {.sync_interval = core::Milliseconds(100)});
  ASSERT_TRUE(writer.has_value());
  const auto at = [](std::int64_t ms) { return core::MonoTime{} + core::Milliseconds(ms); };
  ASSERT_TRUE(writer->Append(1, "A", {}, at(1000)));
  ASSERT_TRUE(writer->Service(at(1099)));
  EXPECT_EQ(writer->synced_events(), 0U);
  ASSERT_TRUE(writer->Service(at(1100)));
  EXPECT_EQ(writer->synced_events(), 1U);
  ASSERT_TRUE(writer->Append(2, "A", {}, at(1150)));
  EXPECT_EQ(writer->synced_events(), 1U);  // the clock starts with the first event that waits
  ASSERT_TRUE(writer->Append(3, "A", {}, at(1250)));
  EXPECT_EQ(writer->synced_events(), 3U);
}

// A recording is its segments' events in the order of their numbers, whatever the files are called
// first.
TEST(EventLog, MergesContentsByNumber) {
  const TestFolder folder;
  const LogWriterOptions options{.sync_interval = std::chrono::hours(1), .fdatasync = false};
  auto navigation = EventLogWriter::Create(folder / "navigation-000000.lcmlog", options);
  auto pictures = EventLogWriter::Create(folder / "pictures-000000.lcmlog", options);
  auto pictures1 = EventLogWriter::Create(folder / "pictures-000001.lcmlog", options);
  for (std::int64_t i = 0; i < 90; ++i) {
    auto& writer = i % 5 != 2 ? navigation : i < 40 ? pictures : pictures1;
    ASSERT_TRUE(writer->AppendNumbered(i + 1, TestTime(i), TestChannel(i), TestData(i),
                                       core::MonoTime::FromNs(1)));
  }
  ASSERT_TRUE(pictures->Close() && pictures1->Close() && navigation->Close());
  const ReadResult read = ReadLogs({folder.path()});
  ExpectAll(read, 90);
  EXPECT_EQ(read.stats.missing_numbers, 0U);
  EXPECT_EQ(read.stats.duplicates, 0U);

  std::filesystem::remove(folder / "pictures-000000.lcmlog");  // gave way to navigation
  const ReadResult rest = ReadLogs({folder.path()});
  EXPECT_EQ(rest.events.size(), 82U);
  EXPECT_EQ(rest.stats.missing_numbers, 8U);
  EXPECT_EQ(rest.stats.damage_count, 0U);
}

TEST(EventLog, DifferentRecordingsInTheOrderOfTime) {
  const TestFolder folder;
  for (std::int64_t half = 0; half < 2; ++half) {
    auto writer =
        EventLogWriter::Create(folder / ("log" + std::to_string(half)), {.fdatasync = false});
    for (std::int64_t i = half; i < 60; i += 2) {
      ASSERT_TRUE(
          writer->Append(TestTime(i), TestChannel(i), TestData(i), core::MonoTime::FromNs(1)));
    }
    ASSERT_TRUE(writer->Close());
  }
  ExpectAll(ReadLogs({folder / "log1", folder / "log0"}), 60);
  ExpectAll(ReadLogs({folder / "log1", folder / "log0", folder / "log0"}),
            60);  // named twice: read once
}

}  // namespace
}  // namespace kawara::comms
