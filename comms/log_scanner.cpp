#include "comms/log_scanner.hpp"

#include <algorithm>
#include <array>

#include "comms/bus.hpp"
#include "comms/crc32c.hpp"

namespace kawara::comms {
namespace {

// As far as a list of CRCs is looked for; the writer makes one long before.
constexpr std::size_t kMaxWindowEvents = 16384;
constexpr std::uint64_t kMaxWindowBytes = 64 << 20;
// In a log that seems to have none.
constexpr std::uint64_t kSmallWindowBytes = 512 << 10;

std::string EventName(const LogRecordHeader& header) {
  return "event " + std::to_string(header.number);
}

}  // namespace

LogScanner::LogScanner(LogFileSource source, LogScannerOptions options, DamageSink damage)
    : source_(std::move(source)), options_(options), damage_(std::move(damage)) {}

std::optional<LogEvent> LogScanner::Next() {
  while (true) {
    while (next_in_window_ < window_.size()) {
      const Candidate& c = window_[next_in_window_++];
      if (!c.good || (c.is_crc_list && !options_.deliver_log_crc)) continue;
      const auto record = Bytes(c);
      const auto channel_bytes = static_cast<std::size_t>(c.header.channel_bytes);
      const auto channel = record.subspan(kLogHeaderBytes, channel_bytes);
      return LogEvent{c.header.number,
                      c.header.time_utc_us,
                      {reinterpret_cast<const char*>(channel.data()), channel.size()},
                      record.subspan(kLogHeaderBytes + channel_bytes),
                      c.integrity};
    }
    if (position_ >= source_.size()) return std::nullopt;
    FillWindow();
  }
}

void LogScanner::FillWindow() {
  window_.clear();
  next_in_window_ = 0;
  window_begin_ = position_;
  std::optional<std::vector<LogCrcEntry>> entries;
  const std::uint64_t max_bytes = expect_lists_ ? kMaxWindowBytes : kSmallWindowBytes;
  while (position_ < source_.size() && window_.size() < kMaxWindowEvents &&
         position_ - window_begin_ < max_bytes) {
    std::optional<Candidate> c = CandidateAt(position_);
    if (!c) {
      position_ = source_.Find(kLogSync, position_ + 1, window_begin_);
      continue;
    }
    position_ = c->confirmed ? c->end : c->begin + 4;
    window_.push_back(*c);
    if (c->confirmed) (void)Bytes(*c);  // so that the file is read once, in one go
    if (!c->is_crc_list) continue;
    entries = ReadLogCrcRecord(Bytes(*c));
    if (entries) {
      position_ = c->end;  // its own CRC is right, whatever follows it
      break;
    }
  }
  if (entries) {
    JudgeByCrc(*entries);
  } else {
    JudgeByFraming();
  }
  DropOverlapped();
  ReportDamage();
  whole_window_ = entries.has_value();
  expect_lists_ = entries.has_value();
}

std::optional<LogScanner::Candidate> LogScanner::CandidateAt(std::uint64_t offset) {
  const auto start_bytes =
      std::min<std::uint64_t>(source_.size() - offset, kLogHeaderBytes + kLogMaxChannelBytes + 8);
  (void)source_.View(offset, static_cast<std::size_t>(start_bytes),
                     window_begin_);  // what is peeked at below
  const std::optional<LogRecordHeader> header = PlausibleHeader(offset, false);
  if (!header) return std::nullopt;
  Candidate c;
  c.begin = offset;
  c.header = *header;
  c.end = offset + kLogHeaderBytes + static_cast<std::uint64_t>(header->channel_bytes) +
          static_cast<std::uint64_t>(header->data_bytes);
  // The channel, and of the data the fingerprint: a list of CRCs shows in both, so that one may be
  // wrong.
  std::array<std::uint8_t, kLogMaxChannelBytes + 8> start{};
  const auto channel_bytes = static_cast<std::size_t>(header->channel_bytes);
  const auto fingerprint_bytes = static_cast<std::size_t>(std::min(header->data_bytes, 8));
  source_.Peek(offset + kLogHeaderBytes, std::span(start).first(channel_bytes + fingerprint_bytes));
  const std::string_view name(reinterpret_cast<const char*>(start.data()), channel_bytes);
  if (!IsChannelName(name)) return std::nullopt;
  c.is_crc_list = name == kLogCrcChannel ||
                  IsLogCrcMessage(std::span(start).subspan(channel_bytes, fingerprint_bytes));
  c.confirmed = IsFollowedByRecord(c.end);
  return c;
}

std::optional<LogRecordHeader> LogScanner::PlausibleHeader(std::uint64_t offset, bool ignore_sync) {
  if (source_.size() - offset < kLogHeaderBytes) return std::nullopt;
  std::array<std::uint8_t, kLogHeaderBytes> bytes{};
  source_.Peek(offset, bytes);
  const LogRecordHeader header = ReadRecordHeader(bytes);
  if (!ignore_sync && header.sync != kLogSync) return std::nullopt;
  if (header.channel_bytes < 1 ||
      header.channel_bytes > static_cast<std::int32_t>(kLogMaxChannelBytes)) {
    return std::nullopt;
  }
  if (header.data_bytes < 0 ||
      static_cast<std::size_t>(header.data_bytes) > options_.max_event_bytes) {
    return std::nullopt;
  }
  const std::uint64_t body = static_cast<std::uint64_t>(header.channel_bytes) +
                             static_cast<std::uint64_t>(header.data_bytes);
  if (body > source_.size() - offset - kLogHeaderBytes) return std::nullopt;
  return header;
}

// The sync word, or as much of it as a file cut off there still has.
bool LogScanner::AtRecordStart(std::uint64_t offset) {
  std::array<std::uint8_t, 4> word{0xED, 0xA1, 0xDA, 0x01};
  std::array<std::uint8_t, 4> bytes{};
  const auto length = static_cast<std::size_t>(std::min<std::uint64_t>(4, source_.size() - offset));
  source_.Peek(offset, std::span(bytes).first(length));
  return std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length),
                    word.begin());
}

bool LogScanner::IsFollowedByRecord(std::uint64_t end) {
  if (AtRecordStart(end)) return true;
  // Perhaps only the sync word of the next one is hit: then its lengths lead to the one after.
  const std::optional<LogRecordHeader> header = PlausibleHeader(end, true);
  if (!header) return false;
  return AtRecordStart(end + kLogHeaderBytes + static_cast<std::uint64_t>(header->channel_bytes) +
                       static_cast<std::uint64_t>(header->data_bytes));
}

void LogScanner::JudgeByCrc(const std::vector<LogCrcEntry>& entries) {
  std::unordered_map<std::int64_t, std::uint32_t> listed;
  for (const LogCrcEntry& entry : entries) listed.emplace(entry.number, entry.crc32c);
  Candidate& list = window_.back();
  list.good = true;
  list.integrity = LogIntegrity::kVerified;
  std::uint64_t first_verified = list.begin;
  std::vector<Candidate*> older;  // than this list: of a batch whose own list is lost?
  for (Candidate& c : window_) {
    if (c.is_crc_list) continue;
    const auto entry = listed.find(c.header.number);
    if (entry != listed.end() && Crc32c(Bytes(c)) == entry->second) {
      c.good = true;
      c.integrity = LogIntegrity::kVerified;
      first_verified = std::min(first_verified, c.begin);
      listed.erase(entry);
    } else if (entry == listed.end() && c.confirmed && first_verified == list.begin &&
               (entries.empty() || c.header.number < entries.front().number)) {
      older.push_back(&c);
    }
  }
  // They are, if the window began behind a lost list, or if there is a hole that can have been
  // their list. They are then no worse than events of a log without CRCs. Otherwise these are
  // events whose number is wrong.
  const bool list_fits =
      !older.empty() && first_verified - older.back()->end >= LogCrcRecordBytes(older.size());
  for (Candidate* c : older)
    c->good = (!whole_window_ || list_fits) && !source_.IsUnreadable(c->begin, c->end);
  if (!listed.empty()) RecoverHidden(listed);
  for (const auto& [number, crc] : listed) {
    // In a batch too large for one window, or behind a lost list, the first events went out
    // unverified before.
    damaged_events_ += whole_window_ || number > last_number_ ? 1 : 0;
  }
}

// A length can be wrong so that the end still falls on the start of a later event. The ones jumped
// over are in there.
void LogScanner::RecoverHidden(std::unordered_map<std::int64_t, std::uint32_t>& listed) {
  std::vector<Candidate> recovered;
  for (const Candidate& c : window_) {
    if (c.good || !c.confirmed || c.is_crc_list) continue;
    for (Candidate& hidden : CandidatesInside(c)) {
      const auto entry = listed.find(hidden.header.number);
      if (entry == listed.end() || Crc32c(Bytes(hidden)) != entry->second) continue;
      hidden.good = true;
      hidden.integrity = LogIntegrity::kVerified;
      listed.erase(entry);
      recovered.push_back(hidden);
    }
  }
  window_.insert(window_.end(), recovered.begin(), recovered.end());
  std::ranges::stable_sort(window_, {}, &Candidate::begin);
}

std::vector<LogScanner::Candidate> LogScanner::CandidatesInside(const Candidate& outer) {
  std::vector<Candidate> inside;
  std::uint64_t at = outer.begin + 4;
  while ((at = source_.Find(kLogSync, at, window_begin_, outer.end)) < outer.end &&
         inside.size() < kMaxWindowEvents) {
    const std::optional<Candidate> c = CandidateAt(at);
    if (c && c->end <= outer.end) inside.push_back(*c);
    at += 4;
  }
  return inside;
}

void LogScanner::JudgeByFraming() {
  std::vector<Candidate> recovered;
  for (std::size_t i = 0; i < window_.size(); ++i) {
    Candidate& c = window_[i];
    c.good = c.confirmed && !c.is_crc_list && !source_.IsUnreadable(c.begin, c.end);
    if (!c.good || i + 1 == window_.size() || !window_[i + 1].confirmed) continue;
    const std::int64_t next = window_[i + 1].header.number;
    if (options_.ascending_numbers) {
      c.good = c.header.number < next || (window_[i + 1].is_crc_list && c.header.number == next);
    } else if (next > c.header.number && next - 1 != c.header.number) {
      // Numbers are left out: lost before this log was made, or inside this event because its
      // length is wrong.
      for (Candidate& hidden : CandidatesInside(c)) {
        if (hidden.header.number <= c.header.number || hidden.header.number >= next ||
            !hidden.confirmed)
          continue;
        c.good = false;
        hidden.good = true;
        recovered.push_back(hidden);
      }
    }
  }
  if (recovered.empty()) return;
  window_.insert(window_.end(), recovered.begin(), recovered.end());
  std::ranges::stable_sort(window_, {}, &Candidate::begin);
}

// A verified event may hold bytes that look like events: those are its own.
void LogScanner::DropOverlapped() {
  std::uint64_t good_until = window_begin_;
  for (Candidate& c : window_) {
    if (!c.good) continue;
    if (c.begin < good_until) {
      c.good = false;
    } else {
      good_until = c.end;
      last_number_ = c.header.number;
      position_ = std::max(position_, c.end);
    }
  }
}

void LogScanner::ReportDamage() {
  std::uint64_t from = window_begin_;
  const Candidate* rejected = nullptr;
  for (const Candidate& c : window_) {
    if (!c.good) {
      if (rejected == nullptr && c.begin >= from) rejected = &c;
      continue;
    }
    if (c.begin > from) damage_(from, c.begin, DescribeDamage(from, c.begin, rejected));
    from = c.end;
    rejected = nullptr;
  }
  if (position_ > from) damage_(from, position_, DescribeDamage(from, position_, rejected));
}

std::string LogScanner::DescribeDamage(std::uint64_t begin, std::uint64_t end,
                                       const Candidate* rejected) {
  if (source_.IsUnreadable(begin, end)) return "cannot be read from the disk";
  if (rejected != nullptr && rejected->begin == begin) {
    const std::string what =
        rejected->is_crc_list ? "the list of CRCs" : EventName(rejected->header);
    return what + (rejected->confirmed ? " is not what was written"
                                       : " and what follows it do not fit together");
  }
  if (end == source_.size() && AtRecordStart(begin))
    return "the file is cut off in the middle of an event";
  return "not an event";
}

}  // namespace kawara::comms
