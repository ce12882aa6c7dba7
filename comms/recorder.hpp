#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <kawara/event_t.hpp>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "comms/file_system.hpp"
#include "core/expected.hpp"
#include "core/time.hpp"

namespace kawara::comms {

/// Navigation (raw bytes, decoded samples, events) is never given up for pictures.
enum class RecordClass : std::uint8_t { kNavigation, kPictures };
/// FRAME and PHASE1 are pictures, everything else is navigation.
RecordClass RecordClassOf(std::string_view channel);

struct RecorderConfig {
  std::filesystem::path folder = "log";  ///< holds one folder a mission
  std::string robot{};                   ///< whose events those of the recorder are
  std::string mission{};  ///< "20260708T063000Z"; taken already: "-1", "-2", ... is added
  std::uint64_t segment_bytes = 256U << 20;
  core::Duration segment_duration = std::chrono::minutes(10);
  core::Duration navigation_sync = core::Milliseconds(100);  ///< what a power cut may cost
  core::Duration picture_sync = core::Seconds(1);
  /// What may wait for a slow disk. 32 MiB is minutes of navigation, 128 MiB over 20 s of 2 Mpx
  /// JPEGs at 5 Hz.
  std::size_t navigation_queue_bytes = 32U << 20;
  std::size_t picture_queue_bytes = 128U << 20;
  /// Below this much free disk the oldest picture segments (of all missions in `folder`) are
  /// deleted.
  std::uint64_t disk_reserve_bytes = std::uint64_t{1} << 30;
  /// Set aside at start, given to navigation when the disk is full for good.
  std::uint64_t navigation_reserve_bytes = 64U << 20;
};

/// Something the operator should know. The recorder puts it into the log itself, as ToMessage() of
/// it on EVENT, as soon as there is room.
struct RecorderEvent {
  std::string robot{};
  std::string mission{};
  core::MonoTime mono;
  int severity = 0;  ///< as event_t: 0 info, 1 warn-low, 2 warn-high, 3 fatal
  std::string name;  ///< "recorder.disk_slow"; all begin with "recorder."
  std::string text;
};
/// GPS time 0: a recorder does not know it.
event_t ToMessage(const RecorderEvent& event);
/// Of a log's EVENTs those that the recorder itself put there: nothing else that is recorded gives
/// them again.
bool IsRecorderEvent(const event_t& event);

struct RecorderStats {
  std::uint64_t events[2] = {0, 0};          ///< taken in, by RecordClass
  std::uint64_t dropped_events[2] = {0, 0};  ///< no room in the queue: lost, and said so in the log
  std::uint64_t dropped_bytes[2] = {0, 0};
  std::uint64_t synced_events[2] = {0, 0};  ///< on the medium
  std::uint64_t bytes_written = 0;
  std::uint64_t segments = 0;
  std::uint64_t deleted_segments = 0;  ///< picture segments that gave way
  std::uint64_t deleted_bytes = 0;
  std::uint64_t disk_errors = 0;
  std::size_t queued_bytes[2] = {0, 0};
  core::Duration longest_stall{};  ///< of one disk call
};

/// Records everything of a mission into a folder of LCM event logs, navigation-NNNNNN.lcmlog and
/// pictures-NNNNNN.lcmlog, numbered through both: EventLogReader on the folder gives back the one
/// order. Every segment opens with CONFIG. Disk full: oldest pictures are deleted, then pictures
/// are not recorded, then navigation gets its reserve, then it waits in memory, then it is lost and
/// counted. Disk errors: a new segment takes over what was not on the medium yet.
class Recorder {
 public:
  /// `config_message` is an encoded config_t. `on_event` runs on the writer's thread, the first
  /// ones already inside Start().
  /// Errors: the mission's folder or its first segment cannot be made.
  [[nodiscard]] static core::Expected<std::unique_ptr<Recorder>> Start(
      const RecorderConfig& config, std::span<const std::uint8_t> config_message,
      std::function<void(const RecorderEvent&)> on_event = {},
      FileSystem& file_system = PosixFileSystem());
  ~Recorder();  ///< Stop()

  /// Takes a message in. Any thread; a bounded copy, no disk, no allocation, a lock held for a few
  /// instructions. False: no room (counted) or not a channel name. Order of recording = order of
  /// the calls.
  bool Write(std::string_view channel, std::span<const std::uint8_t> data,
             std::int64_t time_utc_us) noexcept;
  /// Everything taken in so far is on the medium, or the time is up (false) or the disk refuses
  /// (false).
  bool Flush(core::Duration timeout);
  /// Writes out what is queued (giving up after a few seconds of a dead disk) and closes the
  /// segments.
  void Stop();

  RecorderStats stats() const;  ///< any thread
  const std::filesystem::path& mission_folder() const;

 private:
  class Impl;
  explicit Recorder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::comms
