#include <functional>
#include <set>

#include "comms/log_crc.hpp"
#include "log_test_support.hpp"

/// What damage may cost: the events it hit, nothing else, and never a wrong event handed out.
namespace kawara::comms {
namespace {

constexpr std::int64_t kCount = 80;
constexpr std::int64_t kBatch = 25;
constexpr std::int64_t kHit = 50;  // the event that the cases damage: first of its batch

struct Log {
  Blob bytes;
  std::vector<std::size_t> begin;  // of event i (LOG.CRC not counted); one more: end of file
};

Log MakeLog(bool crc) {
  const TestFolder folder;
  auto writer = EventLogWriter::Create(
      folder / "a", {.sync_interval = std::chrono::hours(1), .fdatasync = false, .crc = crc});
  for (std::int64_t i = 0; i < kCount; ++i) {
    EXPECT_TRUE(
        writer->Append(TestTime(i), TestChannel(i), TestData(i), core::MonoTime::FromNs(1)));
    if (i % kBatch == kBatch - 1) {
      EXPECT_TRUE(writer->Sync());
    }
  }
  EXPECT_TRUE(writer->Close());
  Log log{ReadAll(folder / "a"), {}};
  for (std::size_t at = 0; at < log.bytes.size();) {
    const LogRecordHeader header =
        ReadRecordHeader(std::span(log.bytes).subspan(at).first<kLogHeaderBytes>());
    const auto name = std::span(log.bytes).subspan(at + kLogHeaderBytes,
                                                   static_cast<std::size_t>(header.channel_bytes));
    if (std::string(name.begin(), name.end()) != kLogCrcChannel) log.begin.push_back(at);
    at += kLogHeaderBytes + static_cast<std::size_t>(header.channel_bytes + header.data_bytes);
  }
  log.begin.push_back(log.bytes.size());
  return log;
}

std::set<std::int64_t> Lost(const ReadResult& read) {
  std::set<std::int64_t> lost;
  for (std::int64_t i = 0; i < kCount; ++i) lost.insert(i);
  for (const ReadEvent& event : read.events) {
    const std::int64_t i = IndexOf(event);
    EXPECT_GE(i, 0) << "a wrong event was handed out: number " << event.number << " on "
                    << event.channel;
    EXPECT_EQ(lost.erase(i), 1U) << "event " << i << " came twice";
  }
  return lost;
}

ReadResult ReadDamaged(const Blob& bytes) {
  const TestFolder folder;
  WriteAll(folder / "a", bytes);
  return ReadLogs({folder / "a"});
}

using Events = std::set<std::int64_t>;
struct Case {
  const char* name;
  std::function<void(Blob&, std::size_t begin, std::size_t end)> damage;  // of event kHit
  Events lost_with_crc;
  Events lost_without_crc;
  bool leaves_traces = true;
};

void PutLength(Blob& bytes, std::size_t at, std::uint32_t value) {
  for (unsigned i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}
std::uint32_t DataLength(const Blob& bytes, std::size_t at) {
  return std::uint32_t{bytes[at + 26]} << 8 | bytes[at + 27];
}
Blob::iterator At(Blob& bytes, std::size_t at) {
  return bytes.begin() + static_cast<std::ptrdiff_t>(at);
}

const Case kCases[] = {
    {"data length one more",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 24, DataLength(b, at) + 1); },
     {kHit},
     {kHit}},
    {"data length one less",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 24, DataLength(b, at) - 1); },
     {kHit},
     {kHit}},
    {"data length 0x7fffffff",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 24, 0x7fffffff); },
     {kHit},
     {kHit}},
    {"data length 0x40000000",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 24, 0x40000000); },
     {kHit},
     {kHit}},
    {"data length negative",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 24, 0xffffff00); },
     {kHit},
     {kHit}},
    {"channel length huge",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 20, 0x7fffffff); },
     {kHit},
     {kHit}},
    {"channel length zero",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at + 20, 0); },
     {kHit},
     {kHit}},
    {"sync word zeroed",
     [](Blob& b, std::size_t at, std::size_t) { PutLength(b, at, 0); },
     {kHit},
     {kHit}},
    {"ten bytes missing",
     [](Blob& b, std::size_t at, std::size_t) { b.erase(At(b, at + 40), At(b, at + 50)); },
     {kHit},
     {kHit}},
    // Behind the event, before the next: only a CRC can tell that the event itself is whole.
    {"garbage put in behind it",
     [](Blob& b, std::size_t, std::size_t end) { b.insert(At(b, end), 777, 0x5a); },
     {},
     {kHit}},
    {"garbage put into it",
     [](Blob& b, std::size_t at, std::size_t) { b.insert(At(b, at + 45), 777, 0xed); },
     {kHit},
     {kHit}},
    {"cut out and closed up",
     [](Blob& b, std::size_t at, std::size_t end) { b.erase(At(b, at), At(b, end)); },
     {kHit},
     {kHit},
     false},
    {"its header zeroed",
     [](Blob& b, std::size_t at, std::size_t) { std::fill_n(At(b, at), kLogHeaderBytes, 0); },
     {kHit},
     {kHit - 1, kHit}},
};

TEST(LogDamage, CostsWhatItHit) {
  for (const bool crc : {true, false}) {
    const Log log = MakeLog(crc);
    for (const Case& c : kCases) {
      SCOPED_TRACE(std::string(c.name) + (crc ? ", with CRC" : ", without"));
      Blob bytes = log.bytes;
      c.damage(bytes, log.begin[kHit], log.begin[kHit + 1]);
      const ReadResult read = ReadDamaged(bytes);
      EXPECT_EQ(Lost(read), crc ? c.lost_with_crc : c.lost_without_crc);
      if (crc) {
        EXPECT_EQ(read.stats.damaged_events, c.lost_with_crc.size());
      }
      EXPECT_EQ(read.stats.damage_count, c.leaves_traces ? 1U : 0U);
      EXPECT_EQ(read.stats.missing_numbers, Lost(read).size());
    }
  }
}

TEST(LogDamage, ZeroedBlockCostsTheEventsInIt) {
  for (const bool crc : {true, false}) {
    const Log log = MakeLog(crc);
    Blob bytes = log.bytes;
    const std::size_t from = log.begin[kHit] + 40;
    std::fill_n(At(bytes, from), 4096, std::uint8_t{0});
    Events hit;
    for (std::int64_t i = 0; i < kCount; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (log.begin[k] < from + 4096 && log.begin[k + 1] > from) hit.insert(i);
    }
    const ReadResult read = ReadDamaged(bytes);
    EXPECT_EQ(Lost(read), hit) << (crc ? "with CRC" : "without");
    ASSERT_EQ(read.stats.damage_count, 1U);
    EXPECT_EQ(read.stats.damage[0].begin, log.begin[kHit]);
    EXPECT_GE(read.stats.damage[0].end, from + 4096);
  }
}

// Every length of a file cut off: the whole events before the cut are there.
TEST(LogDamage, CutAnywhere) {
  for (const bool crc : {true, false}) {
    const Log log = MakeLog(crc);
    const TestFolder folder;
    WriteAll(folder / "a", log.bytes);
    for (std::size_t length = log.begin[kHit + 2]; length >= log.begin[kHit - 2]; --length) {
      std::filesystem::resize_file(folder / "a", length);
      Events expected;
      for (std::int64_t i = 0; i < kCount; ++i) {
        // The end of event i is where the next record (perhaps a LOG.CRC) begins.
        const auto at = log.begin[static_cast<std::size_t>(i)];
        if (at + kLogHeaderBytes + TestChannel(i).size() + TestData(i).size() > length)
          expected.insert(i);
      }
      EXPECT_EQ(Lost(ReadLogs({folder / "a"})), expected) << length;
    }
  }
}

class FlippableFile {
 public:
  explicit FlippableFile(Blob bytes) : bytes_(std::move(bytes)) { WriteAll(folder_ / "a", bytes_); }
  ReadResult ReadFlipped(std::size_t at) const {
    Put(at, static_cast<std::uint8_t>(bytes_[at] ^ (1U << (at % 8))));
    ReadResult read = ReadLogs({folder_ / "a"});
    Put(at, bytes_[at]);
    return read;
  }

 private:
  void Put(std::size_t at, std::uint8_t byte) const {
    std::fstream file(folder_ / "a", std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(static_cast<std::streamoff>(at));
    file.put(static_cast<char>(byte));
  }
  TestFolder folder_;
  Blob bytes_;
};

// One bit turned over in every byte. Loses only that record; a flipped
// payload is noticed.
TEST(LogDamage, FlipEveryByte) {
  const Log log = MakeLog(true);
  const FlippableFile file(log.bytes);
  std::size_t hit = 0;
  for (std::size_t at = 0; at < log.bytes.size(); ++at) {
    while (at >= log.begin[hit + 1]) ++hit;
    const ReadResult read = file.ReadFlipped(at);
    const Events lost = Lost(read);
    const auto i = static_cast<std::int64_t>(hit);
    const bool in_event =
        at < log.begin[hit] + kLogHeaderBytes + TestChannel(i).size() + TestData(i).size();
    EXPECT_EQ(lost, in_event ? Events{i} : Events{}) << "byte " << at;
    EXPECT_EQ(read.stats.damage_count, 1U) << "byte " << at;
    if (HasFailure()) return;
  }
}

TEST(LogDamage, FlipEveryByteWithoutCrcNeverCostsMoreThanTheNeighbours) {
  const Log log = MakeLog(false);
  const FlippableFile file(log.bytes);
  std::size_t hit = 0;
  for (std::size_t at = 0; at < log.bytes.size(); ++at) {
    while (at >= log.begin[hit + 1]) ++hit;
    const ReadResult read = file.ReadFlipped(at);
    EXPECT_GE(read.events.size(), static_cast<std::size_t>(kCount - 2)) << "byte " << at;
  }
}

TEST(LogDamage, GarbageBeforeTheFirstEvent) {
  const Log log = MakeLog(true);
  Blob bytes = log.bytes;
  bytes.insert(bytes.begin(), 5000, 0x11);
  const ReadResult read = ReadDamaged(bytes);
  EXPECT_EQ(Lost(read), Events{});
  EXPECT_EQ(read.stats.damaged_bytes, 5000U);
}

// A power cut leaves blocks that were given to the file but not written.
TEST(LogDamage, ZerosAtTheEnd) {
  const Log log = MakeLog(true);
  Blob bytes = log.bytes;
  bytes.insert(bytes.end(), 8192, 0);
  const ReadResult read = ReadDamaged(bytes);
  EXPECT_EQ(Lost(read), Events{});
  EXPECT_EQ(read.stats.damaged_bytes, 8192U);
}

// An event whose payload is itself a log: what is inside is never taken for events of the outer
// one.
TEST(LogDamage, LogInsideALog) {
  const Log inner = MakeLog(true);
  const TestFolder folder;
  auto writer = EventLogWriter::Create(
      folder / "a", {.sync_interval = std::chrono::hours(1), .fdatasync = false});
  ASSERT_TRUE(writer->Append(1, "FILE", inner.bytes, core::MonoTime::FromNs(1)));
  ASSERT_TRUE(writer->Append(2, "END", {}, core::MonoTime::FromNs(1)));
  ASSERT_TRUE(writer->Close());
  ReadResult read = ReadLogs({folder / "a"});
  EXPECT_EQ(read.events.size(), 2U);
  EXPECT_EQ(read.stats.damage_count, 0U);
}

}  // namespace
}  // namespace kawara::comms
