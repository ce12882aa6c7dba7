#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "comms/event_log.hpp"
#include "comms/log_crc.hpp"
#include "comms/log_file_source.hpp"

namespace kawara::comms {

struct LogScannerOptions {
  std::size_t max_event_bytes = kLogMaxDataBytes;
  bool deliver_log_crc = false;
  /// The recorder's files: numbers only grow. Lets a wrong number be seen where no CRC covers it.
  bool ascending_numbers = false;
};

/// Finds the events of one log file, in windows that end with a LOG.CRC (or at a size limit, or the
/// end of file).
///
/// In a window every place that looks like a record is a candidate: sync word, lengths that fit. It
/// is confirmed if the next record (or the end of file) follows it exactly. After an unconfirmed
/// one the search goes on right behind its sync word, because its length may be what is wrong. Then
/// the window is judged. Under a LOG.CRC a candidate is good if its CRC is the listed one,
/// confirmed or not. Without, confirmed candidates are taken, unconfirmed ones are not: their end
/// may be missing. What lies between the good ones is damage.
class LogScanner {
 public:
  using DamageSink =
      std::function<void(std::uint64_t begin, std::uint64_t end, const std::string& what)>;
  LogScanner(LogFileSource source, LogScannerOptions options, DamageSink damage);

  /// Next good event in the order of the file; null at the end. Views are valid until the next
  /// call.
  std::optional<LogEvent> Next();

  std::uint64_t position() const { return position_; }
  std::uint64_t size() const { return source_.size(); }
  /// Events that are known to have been here and are not: listed by a CRC, or with a wrong one.
  std::uint64_t damaged_events() const { return damaged_events_; }
  std::uint64_t unreadable_bytes() const { return source_.unreadable_bytes(); }

 private:
  struct Candidate {
    std::uint64_t begin = 0;
    std::uint64_t end = 0;
    LogRecordHeader header;
    bool confirmed = false;
    bool is_crc_list = false;
    bool good = false;
    LogIntegrity integrity = LogIntegrity::kFramed;
  };

  void FillWindow();
  std::optional<Candidate> CandidateAt(std::uint64_t offset);
  std::optional<LogRecordHeader> PlausibleHeader(std::uint64_t offset, bool ignore_sync);
  bool IsFollowedByRecord(std::uint64_t end);
  bool AtRecordStart(std::uint64_t offset);
  void JudgeByCrc(const std::vector<LogCrcEntry>& entries);
  void RecoverHidden(std::unordered_map<std::int64_t, std::uint32_t>& listed);
  std::vector<Candidate> CandidatesInside(const Candidate& outer);
  void JudgeByFraming();
  void DropOverlapped();
  void ReportDamage();
  std::string DescribeDamage(std::uint64_t begin, std::uint64_t end, const Candidate* rejected);
  std::span<const std::uint8_t> Bytes(const Candidate& c) {
    return source_.View(c.begin, static_cast<std::size_t>(c.end - c.begin), window_begin_);
  }

  LogFileSource source_;
  LogScannerOptions options_;
  DamageSink damage_;
  std::uint64_t position_ = 0;
  std::uint64_t window_begin_ = 0;
  std::vector<Candidate> window_;
  std::size_t next_in_window_ = 0;
  bool whole_window_ =
      true;  ///< the window starts at the file's start or right after a good LOG.CRC
  bool expect_lists_ = true;  ///< the last window ended with one
  std::int64_t last_number_ = std::numeric_limits<std::int64_t>::min();  ///< of the last good event
  std::uint64_t damaged_events_ = 0;
};

}  // namespace kawara::comms
