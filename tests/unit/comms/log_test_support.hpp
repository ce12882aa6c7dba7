#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "comms/event_log_reader.hpp"
#include "comms/event_log_writer.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::comms {

using Blob = std::vector<std::uint8_t>;

using TestFolder = testing::TestFolder;

inline Blob ReadAll(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}
inline void WriteAll(const std::filesystem::path& path, const Blob& bytes) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
}

/// What event i of every test log holds: sizes from 0 to some hundred bytes, every byte value.
inline Blob TestData(std::int64_t i) {
  Blob data(static_cast<std::size_t>((i * 37) % 301));
  for (std::size_t k = 0; k < data.size(); ++k) {
    data[k] = static_cast<std::uint8_t>(static_cast<std::size_t>(i) * 7 + k * 13);
  }
  return data;
}
inline std::string TestChannel(std::int64_t i) {
  return i % 3 == 0 ? "POSE" : i % 3 == 1 ? "RAW.GPS" : "A";
}
inline std::int64_t TestTime(std::int64_t i) { return 1'700'000'000'000'000 + i * 10'000; }

struct ReadEvent {
  std::int64_t number = 0;
  std::int64_t time_utc_us = 0;
  std::string channel;
  Blob data;
  LogIntegrity integrity = LogIntegrity::kFramed;
};
struct ReadResult {
  std::vector<ReadEvent> events;
  LogReaderStats stats;
};

inline ReadResult ReadLogs(const std::vector<std::filesystem::path>& paths,
                           LogReaderOptions options = {}) {
  ReadResult result;
  auto reader = EventLogReader::Open(paths, options);
  EXPECT_TRUE(reader.has_value()) << (reader ? "" : reader.error().message);
  if (!reader) return result;
  while (const auto event = reader->Next()) {
    result.events.push_back({event->number,
                             event->time_utc_us,
                             std::string(event->channel),
                             {event->data.begin(), event->data.end()},
                             event->integrity});
  }
  result.stats = reader->stats();
  return result;
}

/// Index of the test event that this is, exactly; -1 if it is none (a wrong value handed out).
inline std::int64_t IndexOf(const ReadEvent& event) {
  const std::int64_t i = (event.time_utc_us - TestTime(0)) / 10'000;
  const bool same = event.time_utc_us == TestTime(i) && event.channel == TestChannel(i) &&
                    event.data == TestData(i);
  return i >= 0 && same ? i : -1;
}

}  // namespace kawara::comms
