#include "comms/recorder_disk.hpp"

#include <sys/time.h>

#include <algorithm>

#include "comms/log_files.hpp"

namespace kawara::comms {
namespace {

constexpr core::Duration kRetryInterval = core::Milliseconds(250);
constexpr core::Duration kWatchInterval = core::Seconds(1);

const char* Name(RecordClass content) {
  return content == RecordClass::kNavigation ? "navigation" : "pictures";
}

std::int64_t WallTimeUs() {
  timeval now{};
  ::gettimeofday(&now, nullptr);
  return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_usec;
}

}  // namespace

RecorderDisk::RecorderDisk(RecorderConfig config, std::vector<std::uint8_t> config_message,
                           Announce announce, FileSystem& file_system)
    : config_(std::move(config)),
      config_message_(std::move(config_message)),
      announce_(std::move(announce)),
      disk_(&file_system) {
  track(RecordClass::kPictures).content = RecordClass::kPictures;
}

core::Expected<void> RecorderDisk::Open(core::MonoTime now) {
  if (auto ok = disk_->CreateFolder(config_.folder); !ok) return ok;
  const std::string mission = config_.mission.empty() ? "mission" : config_.mission;
  folder_ = config_.folder / mission;
  for (int i = 1; std::ranges::count(disk_->List(config_.folder), folder_) > 0; ++i) {
    folder_ = config_.folder / (mission + "-" + std::to_string(i));
  }
  if (auto ok = disk_->CreateFolder(folder_); !ok) return ok;
  MakeReserve();
  for (Track& t : tracks_) {
    auto ok = OpenSegment(t, now);
    while (!ok && ok.error().code == core::ErrorCode::kFull && MakeRoom(t.content))
      ok = OpenSegment(t, now);
    if (!ok) return ok;
  }
  return {};
}

core::Expected<void> RecorderDisk::OpenSegment(Track& t, core::MonoTime now) {
  const bool navigation = t.content == RecordClass::kNavigation;
  const LogWriterOptions options{.sync_interval =
                                     navigation ? config_.navigation_sync : config_.picture_sync};
  auto writer =
      EventLogWriter::Create(folder_ / SegmentName(Name(t.content), t.next_index), options, *disk_);
  // A name is used once, even if its file could not be made whole.
  ++t.next_index;
  if (!writer) return tl::unexpected(std::move(writer.error()));
  t.writer.emplace(std::move(*writer));
  t.opened = now;
  ++segments_;
  return t.writer->AppendNumbered(0, WallTimeUs(), "CONFIG", config_message_, now);
}

void RecorderDisk::CloseSegment(Track& t) {
  if (!t.writer) return;
  t.synced_events += t.writer->synced_events();
  t.bytes += t.writer->bytes();
  t.writer.reset();
}

bool RecorderDisk::Take(RecordClass content, const MessageRing::Message& message,
                        core::MonoTime now) {
  Track& t = track(content);
  if (content == RecordClass::kPictures && pictures_paused_) {
    ++t.dropped_events;
    t.dropped_bytes += message.data.size();
    return true;
  }
  if (t.waiting && (now < t.retry_at || !Settle(t, now))) return false;
  RollIfDue(t, now);
  if (!t.writer) return false;
  auto ok = t.writer->AppendNumbered(message.number, message.time_utc_us, message.channel,
                                     message.data, now);
  // Unless it could not be a log event at all, the writer has it now, whatever the disk said.
  if (!ok && ok.error().code != core::ErrorCode::kInvalidArgument)
    (void)Settle(t, now, std::move(ok));
  return true;
}

void RecorderDisk::RollIfDue(Track& t, core::MonoTime now) {
  const bool due = t.writer && (t.writer->bytes() >= config_.segment_bytes ||
                                now - t.opened >= config_.segment_duration);
  if (!due || (t.writer->appended_events() <= 1) || !Settle(t, now)) return;
  CloseSegment(t);
  (void)Settle(t, now);
}

void RecorderDisk::Service(core::MonoTime now) {
  if (now >= next_watch_) {
    next_watch_ = now + kWatchInterval;
    WatchFreeSpace(now);
  }
  for (Track& t : tracks_) {
    if (t.waiting) {
      if (now >= t.retry_at) (void)Settle(t, now);
    } else if (t.writer) {
      auto ok = t.writer->Service(now);
      if (!ok) (void)Settle(t, now, std::move(ok));
    }
  }
}

bool RecorderDisk::Sync(core::MonoTime now) {
  bool all = true;
  for (Track& t : tracks_) {
    if (t.content == RecordClass::kPictures && pictures_paused_) continue;
    all &= Settle(t, now);
  }
  return all;
}

// Brings a track to where everything it took over is on the medium, by way of a new file if need
// be. What stands in its way is announced once when it starts waiting, and once when it goes on.
bool RecorderDisk::Settle(Track& t, core::MonoTime now, core::Expected<void> trouble) {
  const auto settled = TrySettle(t, now, std::move(trouble));
  const std::string name = Name(t.content);
  if (settled) {
    if (t.waiting) {
      t.waiting = false;
      announce_(0, "recorder." + name + "_resumed",
                "recording " + name + " again after " +
                    std::to_string(
                        std::chrono::duration_cast<std::chrono::milliseconds>(now - t.waiting_since)
                            .count()) +
                    " ms; it waited in memory");
    }
    return true;
  }
  if (t.content == RecordClass::kPictures && settled.error().code == core::ErrorCode::kFull) {
    PausePictures("the disk is full");
    return false;
  }
  t.retry_at = now + kRetryInterval;
  if (!t.waiting) {
    t.waiting = true;
    t.waiting_since = now;
    announce_(
        2, "recorder." + name + "_waiting",
        "the disk does not take " + name + ", it waits in memory: " + settled.error().message);
  }
  return false;
}

core::Expected<void> RecorderDisk::TrySettle(Track& t, core::MonoTime now,
                                             core::Expected<void> result) {
  if (t.content == RecordClass::kPictures && pictures_paused_) return {};
  bool new_file = false;
  while (true) {
    if (result) result = OpenAndSync(t, now);
    if (result) return result;
    if (result.error().code == core::ErrorCode::kFull) {
      if (!MakeRoom(t.content)) return result;
    } else {
      ++disk_errors_;
      if (t.writer) {
        // What this file still owed goes to another; a number-0 CONFIG is written there anyway.
        t.carried = t.writer->TakeUnsynced();
        std::erase_if(t.carried, [](const auto& event) { return event.number == 0; });
        CloseSegment(t);
      }
      if (new_file) return result;
      announce_(2, "recorder.disk_error", result.error().message + "; going on in a new segment");
      new_file = true;
    }
    result = {};
  }
}

core::Expected<void> RecorderDisk::OpenAndSync(Track& t, core::MonoTime now) {
  if (!t.writer) {
    auto opened = OpenSegment(t, now);
    if (!opened) return opened;
  }
  for (const auto& event : t.carried) {
    (void)t.writer->AppendNumbered(event.number, event.time_utc_us, event.channel, event.data, now);
  }
  t.carried.clear();
  return t.writer->Sync();
}

void RecorderDisk::GiveUpUnsynced(Track& t) {
  if (t.writer) {
    auto lost = t.writer->TakeUnsynced();
    std::ranges::move(lost, std::back_inserter(t.carried));
  }
  for (const auto& event : t.carried) {
    if (event.number == 0) continue;
    ++t.dropped_events;
    t.dropped_bytes += event.data.size();
  }
  t.carried.clear();
  CloseSegment(t);
}

void RecorderDisk::Close(core::MonoTime now) {
  for (Track& t : tracks_) {
    if (!pictures_paused_ || t.content == RecordClass::kNavigation) (void)Settle(t, now);
    GiveUpUnsynced(t);
  }
  if (has_reserve_) (void)disk_->Remove(folder_ / kReserveName);
  has_reserve_ = false;
}

void RecorderDisk::AddTo(RecorderStats& stats) const {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const Track& t = tracks_[i];
    stats.synced_events[i] = t.synced_events + (t.writer ? t.writer->synced_events() : 0);
    stats.dropped_events[i] += t.dropped_events;
    stats.dropped_bytes[i] += t.dropped_bytes;
    stats.bytes_written += t.bytes + (t.writer ? t.writer->bytes() : 0);
  }
  stats.segments = segments_;
  stats.deleted_segments = deleted_segments_;
  stats.deleted_bytes = deleted_bytes_;
  stats.disk_errors = disk_errors_;
}

}  // namespace kawara::comms
