#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/event_log.hpp"
#include "comms/file_system.hpp"
#include "comms/log_crc.hpp"
#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::comms {

struct LogWriterOptions {
  /// fdatasync this long after the first event that is not on the medium yet. 0: with every event.
  core::Duration sync_interval = core::Milliseconds(100);
  bool fdatasync = true;  ///< false: leave it to the kernel (copies, tests)
  bool crc = true;        ///< LOG.CRC with every sync
};

/// Writes one LCM event log that LCM's own tools read, with CRC-32C of every record on the side
/// channel LOG.CRC. An event is acknowledged when synced_events() counts it: then it is on the
/// medium, with its CRC, and no power cut takes it away. Everything not acknowledged stays in
/// memory until it is, so that after a disk error it can go elsewhere. One thread only.
class EventLogWriter {
 public:
  /// Errors: kInvalidArgument (exists already), kNotFound, kPermission, kFull, kIo.
  [[nodiscard]] static core::Expected<EventLogWriter> Create(
      const std::filesystem::path& path, LogWriterOptions options = {},
      FileSystem& file_system = PosixFileSystem());
  EventLogWriter(EventLogWriter&&) noexcept = default;
  EventLogWriter& operator=(EventLogWriter&&) noexcept = default;
  ~EventLogWriter() = default;  ///< closes without Sync; call Close

  /// Takes the event in, writes and syncs as the options say. The event is kept whatever happens:
  /// on an error (kFull, kIo, ...) call Service or Sync again later, or TakeUnsynced and go on in
  /// another file. Errors: also kInvalidArgument (channel, size): then it was not taken in.
  [[nodiscard]] core::Expected<void> Append(std::int64_t time_utc_us, std::string_view channel,
                                            std::span<const std::uint8_t> data, core::MonoTime now);
  /// The same with a number given elsewhere (larger than all before it); Append counts on from
  /// there. A LOG.CRC carries the number of the last event it lists, so that the numbers are those
  /// of events alone.
  [[nodiscard]] core::Expected<void> AppendNumbered(std::int64_t number, std::int64_t time_utc_us,
                                                    std::string_view channel,
                                                    std::span<const std::uint8_t> data,
                                                    core::MonoTime now);
  /// Syncs if it is time. Call it regularly when events may stop coming.
  [[nodiscard]] core::Expected<void> Service(core::MonoTime now);
  /// LOG.CRC, write, fdatasync: afterwards everything taken in is acknowledged.
  [[nodiscard]] core::Expected<void> Sync();
  /// Sync and close.
  [[nodiscard]] core::Expected<void> Close();

  std::uint64_t appended_events() const { return appended_events_; }
  std::uint64_t synced_events() const { return synced_events_; }
  std::uint64_t bytes() const { return bytes_; }  ///< taken in, LOG.CRC included
  std::size_t unsynced_bytes() const { return unsynced_.size(); }
  const std::filesystem::path& path() const { return path_; }

  /// An event that was taken in but never acknowledged.
  struct UnsyncedEvent {
    std::int64_t number = 0;
    std::int64_t time_utc_us = 0;
    std::string channel;
    std::vector<std::uint8_t> data;
  };
  /// Gives them up to the caller (LOG.CRC excluded), for another file. The writer may only be
  /// destroyed afterwards.
  std::vector<UnsyncedEvent> TakeUnsynced();

 private:
  EventLogWriter(std::filesystem::path path, LogWriterOptions options,
                 std::unique_ptr<OutputFile> file);
  static core::Expected<void> CheckEvent(std::string_view channel,
                                         std::span<const std::uint8_t> data);
  bool IsSyncDue(core::MonoTime now) const;
  core::Expected<void> Flush();

  std::filesystem::path path_;
  LogWriterOptions options_;
  std::unique_ptr<OutputFile> file_;
  std::vector<std::uint8_t> unsynced_;  ///< records since the last Sync
  std::size_t written_ = 0;             ///< of unsynced_, in the file already
  std::vector<LogCrcEntry> crcs_;       ///< of unsynced_, until its LOG.CRC is made
  std::size_t unsynced_events_ = 0;
  core::MonoTime first_unsynced_;
  std::int64_t next_number_ = 0;
  std::int64_t last_number_ = 0;
  std::int64_t last_time_utc_us_ = 0;
  std::uint64_t appended_events_ = 0;
  std::uint64_t synced_events_ = 0;
  std::uint64_t bytes_ = 0;
};

}  // namespace kawara::comms
