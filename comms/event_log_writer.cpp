#include "comms/event_log_writer.hpp"

#include <algorithm>
#include <utility>

#include "comms/bus.hpp"
#include "comms/crc32c.hpp"

namespace kawara::comms {
namespace {

// To the kernel in pieces of this size; it makes its own writes out of them.
constexpr std::size_t kFlushBytes = 256 << 10;
// However long the sync interval: bounds what is in memory and how far a reader looks ahead for the
// CRCs.
constexpr std::size_t kMaxUnsyncedBytes = 16 << 20;
constexpr std::size_t kMaxUnsyncedEvents = 4096;

}  // namespace

EventLogWriter::EventLogWriter(std::filesystem::path path, LogWriterOptions options,
                               std::unique_ptr<OutputFile> file)
    : path_(std::move(path)), options_(options), file_(std::move(file)) {}

core::Expected<EventLogWriter> EventLogWriter::Create(const std::filesystem::path& path,
                                                      LogWriterOptions options,
                                                      FileSystem& file_system) {
  auto file = file_system.Create(path);
  if (!file) return tl::unexpected(std::move(file.error()));
  return EventLogWriter(path, options, std::move(*file));
}

core::Expected<void> EventLogWriter::Append(std::int64_t time_utc_us, std::string_view channel,
                                            std::span<const std::uint8_t> data,
                                            core::MonoTime now) {
  if (auto ok = CheckEvent(channel, data); !ok) return ok;
  return AppendNumbered(next_number_, time_utc_us, channel, data, now);
}

core::Expected<void> EventLogWriter::CheckEvent(std::string_view channel,
                                                std::span<const std::uint8_t> data) {
  if (IsChannelName(channel) && data.size() <= kLogMaxDataBytes) return {};
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "log: cannot hold " + std::to_string(data.size()) + " bytes on channel '" +
                        std::string(channel.substr(0, 2 * kLogMaxChannelBytes)) + "'");
}

core::Expected<void> EventLogWriter::AppendNumbered(std::int64_t number, std::int64_t time_utc_us,
                                                    std::string_view channel,
                                                    std::span<const std::uint8_t> data,
                                                    core::MonoTime now) {
  if (auto ok = CheckEvent(channel, data); !ok) return ok;
  if (unsynced_events_ == 0) first_unsynced_ = now;
  const std::size_t begin = unsynced_.size();
  AppendRecord(unsynced_, number, time_utc_us, channel, data);
  if (options_.crc) crcs_.push_back({number, Crc32c(std::span(unsynced_).subspan(begin))});
  last_number_ = number;
  next_number_ = number + 1;
  last_time_utc_us_ = time_utc_us;
  ++unsynced_events_;
  ++appended_events_;
  bytes_ += unsynced_.size() - begin;
  if (IsSyncDue(now)) return Sync();
  if (unsynced_.size() - written_ >= kFlushBytes) return Flush();
  return {};
}

bool EventLogWriter::IsSyncDue(core::MonoTime now) const {
  return unsynced_events_ > 0 &&
         (now - first_unsynced_ >= options_.sync_interval ||
          unsynced_.size() >= kMaxUnsyncedBytes || unsynced_events_ >= kMaxUnsyncedEvents);
}

core::Expected<void> EventLogWriter::Service(core::MonoTime now) {
  if (IsSyncDue(now)) return Sync();
  return {};
}

core::Expected<void> EventLogWriter::Flush() {
  while (written_ < unsynced_.size()) {
    const auto n = file_->Write(std::span(unsynced_).subspan(written_));
    if (!n) return tl::unexpected(n.error());
    if (*n == 0)
      return core::Fail(core::ErrorCode::kIo, "write " + path_.string() + ": nothing written");
    written_ += *n;
  }
  return {};
}

core::Expected<void> EventLogWriter::Sync() {
  if (unsynced_events_ == 0) return {};
  // After a failed attempt crcs_ is empty or holds only what was appended since: no event is listed
  // twice.
  if (!crcs_.empty()) {
    const std::vector<std::uint8_t> record =
        MakeLogCrcRecord(last_number_, last_time_utc_us_, crcs_);
    unsynced_.insert(unsynced_.end(), record.begin(), record.end());
    bytes_ += record.size();
    crcs_.clear();
  }
  if (auto ok = Flush(); !ok) return ok;
  if (options_.fdatasync) {
    if (auto ok = file_->Sync(); !ok) {
      // The kernel may have thrown away what it could not write and call it clean: the next attempt
      // writes it all again. A reader hands out an event that then stands twice in a recording only
      // once.
      written_ = 0;
      return ok;
    }
  }
  synced_events_ += unsynced_events_;
  unsynced_events_ = 0;
  unsynced_.clear();
  written_ = 0;
  return {};
}

core::Expected<void> EventLogWriter::Close() {
  if (auto ok = Sync(); !ok) return ok;
  file_.reset();
  return {};
}

std::vector<EventLogWriter::UnsyncedEvent> EventLogWriter::TakeUnsynced() {
  std::vector<UnsyncedEvent> events;
  std::span<const std::uint8_t> rest = unsynced_;
  while (rest.size() >= kLogHeaderBytes) {
    const LogRecordHeader header = ReadRecordHeader(rest.first<kLogHeaderBytes>());
    const auto channel_bytes = static_cast<std::size_t>(header.channel_bytes);
    const auto data_bytes = static_cast<std::size_t>(header.data_bytes);
    const auto channel = rest.subspan(kLogHeaderBytes, channel_bytes);
    const auto data = rest.subspan(kLogHeaderBytes + channel_bytes, data_bytes);
    std::string name(channel.begin(), channel.end());
    if (name != kLogCrcChannel) {
      events.push_back(
          {header.number, header.time_utc_us, std::move(name), {data.begin(), data.end()}});
    }
    rest = rest.subspan(kLogHeaderBytes + channel_bytes + data_bytes);
  }
  unsynced_.clear();
  written_ = 0;
  unsynced_events_ = 0;
  crcs_.clear();
  return events;
}

}  // namespace kawara::comms
