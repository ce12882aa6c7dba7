#pragma once
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/event_log_writer.hpp"
#include "comms/message_ring.hpp"
#include "comms/recorder.hpp"

namespace kawara::comms {

/// The recorder's side towards the disk: segments, syncs, and what happens when the disk is full or
/// fails. No thread, no clock of its own: everything happens in the calls, at the `now` they are
/// given. One thread only.
class RecorderDisk {
 public:
  static constexpr const char* kReserveName = "navigation.reserve";
  using Announce =
      std::function<void(int severity, const std::string& name, const std::string& text)>;
  RecorderDisk(RecorderConfig config, std::vector<std::uint8_t> config_message, Announce announce,
               FileSystem& file_system);

  /// Makes the mission's folder, its reserve and the first segments. Errors: the disk's.
  [[nodiscard]] core::Expected<void> Open(core::MonoTime now);
  /// Takes a message over, in memory at least. False: not now (disk full or failing); offer it
  /// again.
  [[nodiscard]] bool Take(RecordClass content, const MessageRing::Message& message,
                          core::MonoTime now);
  /// Syncs what is due, looks after free space, tries again what failed. Call it some times a
  /// second.
  void Service(core::MonoTime now);
  /// Everything taken over is on the medium. False: the disk refuses.
  [[nodiscard]] bool Sync(core::MonoTime now);
  /// Sync, close, give back the reserve. What the disk refuses is counted as dropped.
  void Close(core::MonoTime now);

  const std::filesystem::path& folder() const { return folder_; }
  void AddTo(RecorderStats& stats) const;

 private:
  /// One of the two files being written.
  struct Track {
    RecordClass content = RecordClass::kNavigation;
    std::optional<EventLogWriter> writer;
    std::vector<EventLogWriter::UnsyncedEvent> carried;  ///< of a file that failed, for the next
    std::uint32_t next_index = 0;
    core::MonoTime opened;
    bool waiting = false;  ///< the disk does not take it
    core::MonoTime waiting_since;
    core::MonoTime retry_at;
    std::uint64_t synced_events = 0;  ///< of closed files
    std::uint64_t bytes = 0;          ///< of closed files
    std::uint64_t dropped_events = 0;
    std::uint64_t dropped_bytes = 0;
  };

  Track& track(RecordClass content) { return tracks_[static_cast<std::size_t>(content)]; }
  core::Expected<void> OpenSegment(Track& t, core::MonoTime now);
  void CloseSegment(Track& t);
  void RollIfDue(Track& t, core::MonoTime now);
  bool Settle(Track& t, core::MonoTime now, core::Expected<void> trouble = {});
  core::Expected<void> TrySettle(Track& t, core::MonoTime now, core::Expected<void> trouble);
  core::Expected<void> OpenAndSync(Track& t, core::MonoTime now);
  void GiveUpUnsynced(Track& t);
  bool MakeRoom(RecordClass content);
  std::optional<std::filesystem::path> OldestPictures();
  bool DeleteOldestPictures(std::uint64_t free_bytes);
  void PausePictures(const std::string& why);
  void WatchFreeSpace(core::MonoTime now);
  void MakeReserve();

  RecorderConfig config_;
  std::vector<std::uint8_t> config_message_;
  Announce announce_;
  FileSystem* disk_;
  std::filesystem::path folder_;
  std::array<Track, 2> tracks_;
  bool pictures_paused_ = false;
  bool has_reserve_ = false;
  core::MonoTime next_watch_;
  std::uint64_t segments_ = 0;
  std::uint64_t deleted_segments_ = 0;
  std::uint64_t deleted_bytes_ = 0;
  std::uint64_t disk_errors_ = 0;
};

}  // namespace kawara::comms
