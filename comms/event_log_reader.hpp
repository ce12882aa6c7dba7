#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "comms/event_log.hpp"
#include "core/expected.hpp"

namespace kawara::comms {

struct LogReaderOptions {
  /// A longer record is taken for damage. Bounds the memory: about this plus 16 MiB a file.
  std::size_t max_event_bytes = kLogMaxDataBytes;
  /// Hand out LOG.CRC events too (they are the log's own bookkeeping).
  bool deliver_log_crc = false;
};

/// A stretch of a file that holds no readable event, or an event that is not what was written.
struct LogDamage {
  std::string file;
  std::uint64_t begin = 0;  ///< byte offsets, end exclusive
  std::uint64_t end = 0;
  std::string what;  ///< "not a record", "CRC of event 712 on POSE is wrong", "cut off in the
                     ///< middle of a record"
};

struct LogReaderStats {
  std::uint64_t files = 0;
  std::uint64_t bytes = 0;             ///< of the files, as far as read
  std::uint64_t events = 0;            ///< handed out
  std::uint64_t verified = 0;          ///< of those, by CRC
  std::uint64_t damaged_events = 0;    ///< recognised as events, but wrong: withheld
  std::uint64_t damaged_bytes = 0;     ///< in all damage ranges
  std::uint64_t damage_count = 0;      ///< ranges, also those beyond the kept ones
  std::uint64_t unreadable_bytes = 0;  ///< the disk refused (within damaged_bytes)
  std::uint64_t duplicates =
      0;  ///< written twice by the recorder after a disk error, handed out once
  /// Event numbers of a recording that are nowhere in its files: destroyed, dropped or given up for
  /// space.
  std::uint64_t missing_numbers = 0;
  std::vector<LogDamage> damage;  ///< the first 1000 ranges
};

/// Reads LCM event logs whatever state they are in: past cut, zeroed, inserted, missing and flipped
/// bytes, losing only the records that were hit. What CRCs the log carries are checked; a wrong
/// event is never handed out. Several files are one stream: the segments of one recording (same
/// folder, recorder's names) in the order of their event numbers, different recordings in the order
/// of time. Never throws. One thread only.
class EventLogReader {
 public:
  /// Files, or folders of which every log in them is taken. Errors: kNotFound, kPermission, kFormat
  /// (not a log).
  [[nodiscard]] static core::Expected<EventLogReader> Open(
      const std::vector<std::filesystem::path>& paths, const LogReaderOptions& options = {});
  EventLogReader(EventLogReader&&) noexcept;
  EventLogReader& operator=(EventLogReader&&) noexcept;
  ~EventLogReader();

  /// The next event; null at the end. Never an error: what cannot be read is in stats().
  std::optional<LogEvent> Next();
  /// Complete after Next() has returned null.
  const LogReaderStats& stats() const;
  /// The files in use, in the order found.
  std::vector<std::filesystem::path> files() const;
  std::uint64_t total_bytes() const;

 private:
  struct Impl;
  explicit EventLogReader(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::comms
