#include "comms/recorder.hpp"

#include <sys/time.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "comms/bus.hpp"
#include "comms/codec.hpp"
#include "comms/event_log.hpp"
#include "comms/message_ring.hpp"
#include "comms/recorder_disk.hpp"

namespace kawara::comms {
namespace {

// The writer looks for work this often rather than being woken: a caller's Write never touches the
// scheduler.
constexpr auto kIdle = std::chrono::milliseconds(5);
// Pictures in smaller helpings: navigation is never behind more than these.
constexpr std::array<int, 2> kMaxBatch{256, 4};
constexpr core::Duration kStopPatience = core::Seconds(5);
constexpr core::Duration kSlowDisk = core::Milliseconds(500);
constexpr core::Duration kReportInterval = core::Seconds(1);
constexpr std::size_t kMaxPendingEvents = 64;

std::int64_t WallTimeUs() {
  timeval now{};
  ::gettimeofday(&now, nullptr);
  return std::int64_t{now.tv_sec} * 1'000'000 + now.tv_usec;
}

std::int64_t Milliseconds(core::Duration d) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(d).count();
}

}  // namespace

event_t ToMessage(const RecorderEvent& event) {
  event_t message{};
  message.robot = event.robot;
  message.mission = event.mission;
  message.mono_ns = event.mono.ns();
  message.severity = static_cast<std::int8_t>(event.severity);
  message.name = event.name;
  message.text = event.text;
  return message;
}

bool IsRecorderEvent(const event_t& event) { return event.name.starts_with("recorder."); }

RecordClass RecordClassOf(std::string_view channel) {
  return channel == "FRAME" || channel == "PHASE1" ? RecordClass::kPictures
                                                   : RecordClass::kNavigation;
}

class Recorder::Impl {
 public:
  Impl(const RecorderConfig& config, std::span<const std::uint8_t> config_message,
       std::function<void(const RecorderEvent&)> on_event, FileSystem& file_system)
      : robot_(config.robot),
        mission_(config.mission),
        on_event_(std::move(on_event)),
        rings_{MessageRing(config.navigation_queue_bytes), MessageRing(config.picture_queue_bytes)},
        disk_(
            config, {config_message.begin(), config_message.end()},
            [this](int severity, const std::string& name, const std::string& text) {
              Announce(severity, name, text);
            },
            file_system) {}

  core::Expected<void> Start() {
    if (auto ok = disk_.Open(core::MonoNow()); !ok) return ok;
    thread_ = std::thread([this] { Run(); });
    return {};
  }

  bool Write(std::string_view channel, std::span<const std::uint8_t> data,
             std::int64_t time_utc_us) noexcept {
    if (!IsChannelName(channel) || data.size() > kLogMaxDataBytes) return false;
    const auto content = static_cast<std::size_t>(RecordClassOf(channel));
    MessageRing::Slot* slot = nullptr;
    {
      const std::lock_guard lock(reserving_);
      // A dropped message takes its number with it, so that the gap shows in the log.
      slot = rings_[content].Reserve(next_number_++, time_utc_us, channel.size(), data.size());
    }
    if (slot == nullptr) {
      dropped_events_[content].fetch_add(1, std::memory_order_relaxed);
      dropped_bytes_[content].fetch_add(data.size(), std::memory_order_relaxed);
      return false;
    }
    events_[content].fetch_add(1, std::memory_order_relaxed);
    MessageRing::Commit(slot, channel, data);
    return true;
  }

  bool Flush(core::Duration timeout) {
    const core::MonoTime deadline = core::MonoNow() + timeout;
    const std::array<std::uint64_t, 2> until{rings_[0].head(), rings_[1].head()};
    while (rings_[0].tail() < until[0] || rings_[1].tail() < until[1]) {
      if (core::MonoNow() >= deadline) return false;
      std::this_thread::sleep_for(kIdle);
    }
    const std::uint64_t request = flush_requested_.fetch_add(1) + 1;
    while (flush_done_.load() < request) {
      if (core::MonoNow() >= deadline) return false;
      std::this_thread::sleep_for(kIdle);
    }
    return flush_succeeded_.load();
  }

  void Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  RecorderStats Stats() const {
    RecorderStats stats;
    {
      const std::lock_guard lock(stats_mutex_);
      stats = disk_stats_;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      stats.events[i] = events_[i].load(std::memory_order_relaxed);
      stats.dropped_events[i] += dropped_events_[i].load(std::memory_order_relaxed);
      stats.dropped_bytes[i] += dropped_bytes_[i].load(std::memory_order_relaxed);
      stats.queued_bytes[i] = rings_[i].queued_bytes();
    }
    return stats;
  }

  const std::filesystem::path& folder() const { return disk_.folder(); }

 private:
  void Run() {
    core::MonoTime next_report = core::MonoNow() + kReportInterval;
    core::MonoTime last_progress = core::MonoNow();
    bool last_report = false;
    while (true) {
      const core::MonoTime begin = core::MonoNow();
      bool progress = false;
      for (const RecordClass content : {RecordClass::kNavigation, RecordClass::kPictures}) {
        progress |= Drain(content);
      }
      disk_.Service(core::MonoNow());
      Measure(core::MonoNow() - begin);
      AnswerFlush();
      const core::MonoTime now = core::MonoNow();
      if (now >= next_report || (stop_ && !last_report)) {
        last_report = stop_;  // losses of the last second stand in the log too
        next_report = now + kReportInterval;
        Report();
      }
      SendPendingEvents();
      UpdateStats();
      if (progress) last_progress = now;
      const bool idle =
          rings_[0].queued_bytes() == 0 && rings_[1].queued_bytes() == 0 && pending_.empty();
      if (last_report && (idle || now - last_progress > kStopPatience)) break;
      if (!progress) std::this_thread::sleep_for(kIdle);
    }
    Finish();
  }

  bool Drain(RecordClass content) {
    MessageRing& ring = rings_[static_cast<std::size_t>(content)];
    int taken = 0;
    while (taken < kMaxBatch[static_cast<std::size_t>(content)]) {
      const auto message = ring.Front();
      if (!message || !disk_.Take(content, *message, core::MonoNow())) break;
      ring.Pop();
      ++taken;
    }
    return taken > 0;
  }

  void Measure(core::Duration took) {
    longest_stall_ = std::max(longest_stall_, took);
    reported_stall_ = std::max(reported_stall_, took);
  }

  // Once a second: what was lost and how slow the disk was, since the last time.
  void Report() {
    if (reported_stall_ >= kSlowDisk) {
      Announce(1, "recorder.disk_slow",
               "the disk took " + std::to_string(Milliseconds(reported_stall_)) +
                   " ms for one round of writing");
    }
    reported_stall_ = {};
    for (std::size_t i = 0; i < 2; ++i) {
      const std::uint64_t dropped = Stats().dropped_events[i];
      if (dropped == reported_drops_[i]) continue;
      Announce(2, i == 0 ? "recorder.navigation_dropped" : "recorder.pictures_dropped",
               std::to_string(dropped - reported_drops_[i]) + " events not recorded (" +
                   std::to_string(dropped) + " in all)");
      reported_drops_[i] = dropped;
    }
  }

  void Announce(int severity, std::string name, std::string text) {
    RecorderEvent event{robot_,   mission_,        core::MonoNow(),
                        severity, std::move(name), std::move(text)};
    if (on_event_) on_event_(event);
    if (pending_.size() < kMaxPendingEvents) pending_.push_back(std::move(event));
  }

  // Through the queue like everything else, so that they stand in the log at their time; they wait
  // if it is full.
  void SendPendingEvents() {
    while (!pending_.empty()) {
      const auto bytes = Encode(ToMessage(pending_.front()));
      if (bytes && rings_[0].queued_bytes() > 0 && !HasRoomForEvent(bytes->size())) return;
      if (bytes) (void)Write("EVENT", *bytes, WallTimeUs());
      pending_.pop_front();
    }
  }
  bool HasRoomForEvent(std::size_t bytes) const {
    return rings_[0].queued_bytes() + 2 * bytes + 4096 < rings_[0].capacity_bytes();
  }

  void AnswerFlush() {
    const std::uint64_t requested = flush_requested_.load();
    if (flush_done_.load() == requested) return;
    flush_succeeded_ = disk_.Sync(core::MonoNow());
    flush_done_ = requested;
  }

  void UpdateStats() {
    RecorderStats stats;
    disk_.AddTo(stats);
    stats.longest_stall = longest_stall_;
    const std::lock_guard lock(stats_mutex_);
    disk_stats_ = stats;
  }

  void Finish() {
    for (std::size_t i = 0; i < 2; ++i) {
      while (const auto message = rings_[i].Front()) {
        dropped_events_[i].fetch_add(1, std::memory_order_relaxed);
        dropped_bytes_[i].fetch_add(message->data.size(), std::memory_order_relaxed);
        rings_[i].Pop();
      }
    }
    disk_.Close(core::MonoNow());
    UpdateStats();
    AnswerFlush();
  }

  const std::string robot_;
  const std::string mission_;
  std::function<void(const RecorderEvent&)> on_event_;
  std::array<MessageRing, 2> rings_;
  std::mutex reserving_;          ///< number and place in a ring, together
  std::int64_t next_number_ = 1;  ///< 0 is CONFIG
  std::array<std::atomic<std::uint64_t>, 2> events_{};
  std::array<std::atomic<std::uint64_t>, 2> dropped_events_{};
  std::array<std::atomic<std::uint64_t>, 2> dropped_bytes_{};
  std::atomic<std::uint64_t> flush_requested_{0};
  std::atomic<std::uint64_t> flush_done_{0};
  std::atomic<bool> flush_succeeded_{true};
  std::atomic<bool> stop_{false};
  mutable std::mutex stats_mutex_;
  RecorderStats disk_stats_;
  // Writer's thread only.
  RecorderDisk disk_;
  std::deque<RecorderEvent> pending_;
  core::Duration longest_stall_{};
  core::Duration reported_stall_{};
  std::array<std::uint64_t, 2> reported_drops_{};
  std::thread thread_;
};

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recorder::~Recorder() { impl_->Stop(); }

core::Expected<std::unique_ptr<Recorder>> Recorder::Start(
    const RecorderConfig& config, std::span<const std::uint8_t> config_message,
    std::function<void(const RecorderEvent&)> on_event, FileSystem& file_system) {
  auto impl = std::make_unique<Impl>(config, config_message, std::move(on_event), file_system);
  if (auto ok = impl->Start(); !ok) return tl::unexpected(std::move(ok.error()));
  return std::unique_ptr<Recorder>(new Recorder(std::move(impl)));
}

bool Recorder::Write(std::string_view channel, std::span<const std::uint8_t> data,
                     std::int64_t time_utc_us) noexcept {
  return impl_->Write(channel, data, time_utc_us);
}
bool Recorder::Flush(core::Duration timeout) { return impl_->Flush(timeout); }
void Recorder::Stop() { impl_->Stop(); }
RecorderStats Recorder::stats() const { return impl_->Stats(); }
const std::filesystem::path& Recorder::mission_folder() const { return impl_->folder(); }

}  // namespace kawara::comms
