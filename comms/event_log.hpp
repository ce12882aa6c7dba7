#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

/// LCM's event log: records one after another, all integers big-endian, no header, no index.
///   uint32 0xEDA1DA01 | int64 number | int64 time [us] | int32 channel length | int32 data length
///   | channel | data
/// Source: LCM documentation, "LCM Log File format".
namespace kawara::comms {

constexpr std::uint32_t kLogSync = 0xEDA1DA01U;
constexpr std::size_t kLogHeaderBytes = 28;
constexpr std::size_t kLogMaxChannelBytes = 63;                   ///< LCM's limit
constexpr std::size_t kLogMaxDataBytes = std::size_t{256} << 20;  ///< LCM's limit for a message
constexpr std::string_view kLogCrcChannel = "LOG.CRC";  ///< log_crc_t, see comms/log_crc.hpp

/// How much is known of an event's integrity.
enum class LogIntegrity : std::uint8_t {
  kVerified,  ///< its CRC-32C stands in the log and is right
  kFramed,    ///< no CRC for it, but it lies correctly between its neighbours
};

/// One event of a log. Views point into the reader and are valid until its next call.
struct LogEvent {
  std::int64_t number = 0;
  std::int64_t time_utc_us =
      0;  ///< when it was recorded, microseconds since 1970 UTC by the system clock
  std::string_view channel;
  std::span<const std::uint8_t> data;
  LogIntegrity integrity = LogIntegrity::kFramed;
};

}  // namespace kawara::comms
