#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "comms/event_log.hpp"

/// The CRC side channel: a log_crc_t event on LOG.CRC lists number and CRC-32C of every record
/// since the LOG.CRC before it, and as its last entry itself: that CRC covers its own record up to
/// the CRC's own four bytes, which are the last of the record. So a reader can tell a damaged event
/// from a damaged list.
namespace kawara::comms {

struct LogCrcEntry {
  std::int64_t number = 0;
  std::uint32_t crc32c = 0;
};

/// The whole record of a LOG.CRC event for `entries` (without itself).
std::vector<std::uint8_t> MakeLogCrcRecord(std::int64_t number, std::int64_t time_utc_us,
                                           std::span<const LogCrcEntry> entries);
/// The entries (without itself) of a LOG.CRC record; null if it is not one, or damaged.
std::optional<std::vector<LogCrcEntry>> ReadLogCrcRecord(std::span<const std::uint8_t> record);

/// Does this begin like a log_crc_t?
bool IsLogCrcMessage(std::span<const std::uint8_t> data);
/// Length of the record that lists `events` events.
constexpr std::uint64_t LogCrcRecordBytes(std::uint64_t events) {
  return kLogHeaderBytes + kLogCrcChannel.size() + 8 + 4 + 12 * (events + 1);
}

/// Appends one record to `out`.
void AppendRecord(std::vector<std::uint8_t>& out, std::int64_t number, std::int64_t time_utc_us,
                  std::string_view channel, std::span<const std::uint8_t> data);

/// Fields of a record's first 28 bytes, unjudged.
struct LogRecordHeader {
  std::uint32_t sync = 0;
  std::int64_t number = 0;
  std::int64_t time_utc_us = 0;
  std::int32_t channel_bytes = 0;
  std::int32_t data_bytes = 0;
};
LogRecordHeader ReadRecordHeader(std::span<const std::uint8_t, kLogHeaderBytes> bytes);

}  // namespace kawara::comms
