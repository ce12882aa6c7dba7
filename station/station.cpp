#include "station/station.hpp"

#include <cmath>
#include <cstdio>
#include <thread>
#include <utility>

#include "comms/typed_bus.hpp"

namespace kawara::station {
namespace {

/// A log is committed in batches of this many pictures or rows: the log itself is the safe copy.
constexpr std::size_t kLogBatchPictures = 32;
constexpr std::size_t kLogBatchItems = 2000;
/// Live, what one commit takes at most: bounds how long a picture waits for those before it.
constexpr std::size_t kLiveBatchBytes = std::size_t{16} << 20;

std::size_t Megabytes(double mb) { return static_cast<std::size_t>(mb * 1e6); }

}  // namespace

Station::Station(const StationConfig& config, StoreFeeder feeder, Say say)
    : config_(config),
      say_(std::move(say)),
      feeder_(std::move(feeder)),
      queue_(Megabytes(config.queue_mb)),
      intake_(config, [this](Item item) {
        if (direct_) {
          feeder_.Put(std::move(item));
        } else {
          queue_.Push(std::move(item));
        }
      }) {}

core::Expected<void> Station::Subscribe(comms::Bus& bus) {
  const auto on = [this, &bus](const char* channel, auto type, auto handle) {
    using Message = decltype(type);
    return comms::Subscribe<Message>(
        bus, channel, [this, handle](const Message& message, const comms::MessageMeta&) {
          now_ = core::MonoNow();
          last_heard_ = now_;
          handle(message);
        });
  };
  auto done = on("PHASE1", phase1_t{}, [this](const phase1_t& m) { intake_.OnPhase1(m, now_); });
  if (done)
    done = on("POSE", robot_pose_t{},
              [this](const robot_pose_t& m) { intake_.OnPose(m, false, now_); });
  if (done)
    done = on("POSE\\.EPOCH", robot_pose_t{},
              [this](const robot_pose_t& m) { intake_.OnPose(m, true, now_); });
  if (done) done = on("EVENT", event_t{}, [this](const event_t& m) { intake_.OnEvent(m, now_); });
  if (done)
    done = on("COUNTERS", counters_t{}, [this](const counters_t& m) { intake_.OnCounters(m); });
  if (done)
    done = on("OBJECT", changed_object_t{},
              [this](const changed_object_t& m) { intake_.OnObject(m, now_); });
  if (done)
    done = on("OBJECT\\.TEXTURE", object_texture_t{},
              [this](const object_texture_t& m) { intake_.OnTexture(m, now_); });
  if (done)
    done = on("ROAD", road_stations_t{},
              [this](const road_stations_t& m) { intake_.OnRoad(m, now_); });
  return done;
}

core::Expected<void> Station::CommitPatiently(bool finish) {
  const core::MonoTime start = core::MonoNow();
  for (;;) {
    auto done = finish ? feeder_.Finish() : feeder_.Commit();
    if (done || core::MonoNow() - start > core::DurationFromSeconds(config_.give_up_s)) return done;
    std::this_thread::sleep_for(core::DurationFromSeconds(config_.retry_period_s));
  }
}

void Station::WriteUntilStopped(const std::atomic<bool>& stopping) {
  const core::Duration period = core::DurationFromSeconds(config_.commit_period_s);
  core::MonoTime last_commit = core::MonoNow();
  bool trouble = false;
  while (!stopping) {
    if (trouble) {  // what waits stays in the queue, whose bound drops the oldest
      std::this_thread::sleep_for(core::DurationFromSeconds(config_.retry_period_s));
    } else {
      for (Item& item : queue_.Pop(period, kLiveBatchBytes)) feeder_.Put(std::move(item));
    }
    const bool due = feeder_.pending_pictures() > 0 || core::MonoNow() - last_commit >= period;
    if (!due) continue;
    trouble = !feeder_.Commit();
    last_commit = core::MonoNow();
  }
}

core::Expected<void> Station::RunLive(comms::Bus& bus, const RunLimits& limits,
                                      const std::atomic<bool>& stop) {
  if (auto subscribed = Subscribe(bus); !subscribed) return subscribed;
  std::atomic<bool> stopping{false};
  std::thread writer([this, &stopping] { WriteUntilStopped(stopping); });
  const core::MonoTime start = core::MonoNow();
  last_heard_ = start;
  core::Expected<void> result;
  const auto over = [](core::MonoTime since, double limit_s) {
    return limit_s > 0.0 && core::MonoNow() - since > core::DurationFromSeconds(limit_s);
  };
  while (!stop && !over(start, limits.duration_s) && !over(last_heard_, limits.idle_exit_s)) {
    const auto handled = bus.HandleFor(core::Milliseconds(100));
    if (!handled && !stop) {  // a signal interrupts the wait: that is no error
      result = tl::unexpected(handled.error());
      break;
    }
  }
  stopping = true;
  queue_.Stop();
  writer.join();
  for (Item& item : queue_.Pop(core::Duration(0), Megabytes(config_.queue_mb)))
    feeder_.Put(std::move(item));
  bad_messages_ = bus.bad_messages();
  bus_trouble_ = bus.last_bad_message();
  const auto finished = CommitPatiently(true);
  return result ? finished : result;
}

core::Expected<void> Station::RunLog(comms::Bus& bus, const std::atomic<bool>& stop) {
  direct_ = true;
  if (auto subscribed = Subscribe(bus); !subscribed) return subscribed;
  while (!stop && !bus.AtEnd()) {
    if (const auto handled = bus.HandleFor(core::Milliseconds(100)); !handled)
      return tl::unexpected(handled.error());
    if (feeder_.pending_pictures() < kLogBatchPictures && feeder_.pending() < kLogBatchItems)
      continue;
    if (auto done = CommitPatiently(false); !done) return done;
  }
  bad_messages_ = bus.bad_messages();
  bus_trouble_ = bus.last_bad_message();
  return CommitPatiently(true);
}

namespace {

/// Empty if there are none.
std::string ObjectsText(const ObjectCounts& counts) {
  if (counts.revisions + counts.textures + counts.stations + counts.known + counts.orphans == 0)
    return {};
  return std::to_string(counts.revisions) + " revisions of changed objects, " +
         std::to_string(counts.textures) + " with pictures of their sides, and " +
         std::to_string(counts.stations) + " road stations registered; ";
}

}  // namespace

std::string Station::Summary() const {
  const IntakeStats& in = intake_.stats();
  const gis::StoreStats stored = feeder_.stats();
  const auto n = [](auto value) { return std::to_string(value); };
  std::string text = n(stored.panoramas) + " pictures (" + n(in.pictures) + " full and " +
                     n(in.previews) + " preview packets), " + n(stored.poses) + " poses of " +
                     n(in.poses) + ", " + n(stored.events) + " events stored; " +
                     ObjectsText(feeder_.objects()) + "pictures missing " +
                     n(intake_.missing_pictures()) + ", late " + n(intake_.late_pictures()) +
                     "; packets repeated " + n(stored.duplicates) + ", refused " +
                     n(in.refused + feeder_.refused() + static_cast<std::int64_t>(bad_messages_)) +
                     ", dropped " + n(queue_.dropped_pictures() + queue_.dropped_rows());
  if (feeder_.pending() > 0) text += ", NOT STORED " + n(feeder_.pending());
  const double median_s = feeder_.LatencyQuantileS(0.5);
  if (!direct_ && std::isfinite(median_s)) {
    std::array<char, 96> latency{};
    std::snprintf(latency.data(), latency.size(), "; packet to disk median %.1f ms, p99 %.1f ms",
                  median_s * 1e3, feeder_.LatencyQuantileS(0.99) * 1e3);
    text += latency.data();
  }
  if (!in.last_refusal.empty()) text += "; last refusal: " + in.last_refusal;
  if (!bus_trouble_.empty()) text += "; last bad message: " + bus_trouble_;
  if (in.leap_mismatch > 0)
    text += "; GPS - UTC of the robot differs from this program's table (update it)";
  const std::string losses = intake_.RobotLosses();
  if (!losses.empty()) text += "; the robot reports " + losses;
  return text;
}

}  // namespace kawara::station
