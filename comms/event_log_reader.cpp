#include "comms/event_log_reader.hpp"

#include <algorithm>
#include <deque>

#include "comms/log_files.hpp"
#include "comms/log_scanner.hpp"

namespace kawara::comms {
namespace {

constexpr std::size_t kMaxKeptDamage = 1000;

/// The events of the files of one chain, one after another.
class ChainReader {
 public:
  ChainReader(LogChain chain, LogScannerOptions options, LogReaderStats& stats)
      : chain_(std::move(chain)), options_(options), stats_(&stats) {}

  const std::optional<LogEvent>& head() const { return head_; }

  void Advance() {
    head_.reset();
    while (true) {
      if (!scanner_ && !OpenNext()) return;
      head_ = scanner_->Next();
      UpdateStats();
      if (head_) return;
      scanner_.reset();
      counted_ = {};
    }
  }

 private:
  bool OpenNext() {
    while (next_file_ < chain_.files.size()) {
      const std::filesystem::path& path = chain_.files[next_file_++];
      const std::string name = path.string();
      auto source = LogFileSource::Open(path);
      if (!source) {
        AddDamage({name, 0, 0, source.error().message});
        continue;
      }
      scanner_.emplace(
          std::move(*source), options_,
          [this, name](std::uint64_t begin, std::uint64_t end, const std::string& what) {
            AddDamage({name, begin, end, what});
          });
      return true;
    }
    return false;
  }

  void AddDamage(const LogDamage& damage) {
    stats_->damaged_bytes += damage.end - damage.begin;
    // One hole seen through two windows is one hole.
    if (damage.begin != 0 && damage.file == last_damage_file_ && damage.begin == last_damage_end_) {
      if (last_damage_index_ < stats_->damage.size())
        stats_->damage[last_damage_index_].end = damage.end;
    } else {
      ++stats_->damage_count;
      last_damage_index_ = stats_->damage.size();
      last_damage_file_ = damage.file;
      if (stats_->damage.size() < kMaxKeptDamage) stats_->damage.push_back(damage);
    }
    last_damage_end_ = damage.end;
  }

  // The scanner counts for its file; the stats add up over files.
  void UpdateStats() {
    const auto add = [](std::uint64_t& total, std::uint64_t& counted, std::uint64_t now) {
      total += now - counted;
      counted = now;
    };
    add(stats_->bytes, counted_.position, scanner_->position());
    add(stats_->damaged_events, counted_.damaged_events, scanner_->damaged_events());
    add(stats_->unreadable_bytes, counted_.unreadable, scanner_->unreadable_bytes());
  }

  struct Counted {
    std::uint64_t position = 0;
    std::uint64_t damaged_events = 0;
    std::uint64_t unreadable = 0;
  };
  LogChain chain_;
  LogScannerOptions options_;
  LogReaderStats* stats_;
  std::size_t next_file_ = 0;
  std::optional<LogScanner> scanner_;
  std::optional<LogEvent> head_;
  Counted counted_;
  std::string last_damage_file_;
  std::uint64_t last_damage_end_ = 0;
  std::size_t last_damage_index_ = 0;
};

/// How many numbers a sequence leaves out. One wild number among good ones (a flipped bit nobody
/// guards) is not a gap: a number counts once the one after it goes on from there.
class NumberGaps {
 public:
  std::uint64_t Add(std::int64_t number) {
    std::uint64_t missing = 0;
    if (candidate_ && number > *candidate_) {
      if (last_)
        missing = static_cast<std::uint64_t>(*candidate_) - static_cast<std::uint64_t>(*last_) - 1;
      last_ = candidate_;
    } else if (last_ && number <= *last_) {
      last_.reset();  // counts from the start again: logs put one behind the other
    }
    candidate_ = number;
    return missing;
  }
  std::uint64_t Finish() {
    if (!candidate_ || !last_ || *candidate_ <= *last_) return 0;
    return static_cast<std::uint64_t>(*candidate_) - static_cast<std::uint64_t>(*last_) - 1;
  }

 private:
  std::optional<std::int64_t> last_;
  std::optional<std::int64_t> candidate_;
};

/// One recording: its chains merged by event number.
class RecordingReader {
 public:
  RecordingReader(LogRecording recording, const LogReaderOptions& options, LogReaderStats& stats)
      : by_recorder_(recording.by_recorder),
        deliver_log_crc_(options.deliver_log_crc),
        stats_(&stats) {
    const LogScannerOptions scanner_options{options.max_event_bytes, options.deliver_log_crc,
                                            recording.by_recorder};
    for (LogChain& chain : recording.chains)
      chains_.emplace_back(std::move(chain), scanner_options, stats);
  }

  const std::optional<LogEvent>& head() const { return current_->head(); }

  void Advance() {
    if (current_ == nullptr) {
      for (ChainReader& chain : chains_) chain.Advance();
    } else {
      current_->Advance();
    }
    while (true) {
      current_ =
          &*std::ranges::min_element(chains_, [](const ChainReader& a, const ChainReader& b) {
            if (!a.head() || !b.head()) return a.head().has_value() && !b.head();
            return a.head()->number < b.head()->number;
          });
      if (!current_->head()) {
        if (!finished_) stats_->missing_numbers += gaps_.Finish();
        finished_ = true;
        return;
      }
      if (IsWanted(*current_->head())) return;
      current_->Advance();
    }
  }

 private:
  bool IsWanted(const LogEvent& event) {
    if (event.channel == kLogCrcChannel)
      return deliver_log_crc_;  // repeats the number of the event before it
    if (!by_recorder_) {
      stats_->missing_numbers += gaps_.Add(event.number);
      return true;
    }
    // CONFIG opens every segment as number 0. Otherwise a number comes again where the recorder
    // wrote it again.
    if (last_number_ && event.number <= *last_number_) {
      stats_->duplicates += event.number != 0 ? 1 : 0;
      return false;
    }
    last_number_ = event.number;
    if (event.number != 0) stats_->missing_numbers += gaps_.Add(event.number);
    return true;
  }

  std::deque<ChainReader> chains_;  // their scanners' sinks point back at them
  bool by_recorder_;
  bool deliver_log_crc_;
  LogReaderStats* stats_;
  ChainReader* current_ = nullptr;
  std::optional<std::int64_t> last_number_;
  NumberGaps gaps_;
  bool finished_ = false;
};

}  // namespace

struct EventLogReader::Impl {
  LogReaderStats stats;
  std::deque<RecordingReader> recordings;
  std::vector<std::filesystem::path> files;
  std::uint64_t total_bytes = 0;
  RecordingReader* current = nullptr;
  bool started = false;
};

EventLogReader::EventLogReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
EventLogReader::EventLogReader(EventLogReader&&) noexcept = default;
EventLogReader& EventLogReader::operator=(EventLogReader&&) noexcept = default;
EventLogReader::~EventLogReader() = default;

core::Expected<EventLogReader> EventLogReader::Open(const std::vector<std::filesystem::path>& paths,
                                                    const LogReaderOptions& options) {
  auto found = FindLogs(paths);
  if (!found) return tl::unexpected(std::move(found.error()));
  auto impl = std::make_unique<Impl>();
  for (LogRecording& recording : *found) {
    for (const LogChain& chain : recording.chains) {
      for (const std::filesystem::path& file : chain.files) {
        std::error_code error;
        const std::uintmax_t bytes = std::filesystem::file_size(file, error);
        if (!error) impl->total_bytes += bytes;
        impl->files.push_back(file);
      }
    }
    impl->recordings.emplace_back(std::move(recording), options, impl->stats);
  }
  impl->stats.files = impl->files.size();
  return EventLogReader(std::move(impl));
}

std::optional<LogEvent> EventLogReader::Next() {
  if (!impl_->started) {
    for (RecordingReader& recording : impl_->recordings) recording.Advance();
    impl_->started = true;
  } else if (impl_->current != nullptr) {
    impl_->current->Advance();
  }
  impl_->current = nullptr;
  for (RecordingReader& recording : impl_->recordings) {
    if (!recording.head()) continue;
    if (impl_->current == nullptr ||
        recording.head()->time_utc_us < impl_->current->head()->time_utc_us) {
      impl_->current = &recording;
    }
  }
  if (impl_->current == nullptr) return std::nullopt;
  const LogEvent event = *impl_->current->head();
  ++impl_->stats.events;
  impl_->stats.verified += event.integrity == LogIntegrity::kVerified ? 1 : 0;
  return event;
}

const LogReaderStats& EventLogReader::stats() const { return impl_->stats; }
std::vector<std::filesystem::path> EventLogReader::files() const { return impl_->files; }
std::uint64_t EventLogReader::total_bytes() const { return impl_->total_bytes; }

}  // namespace kawara::comms
