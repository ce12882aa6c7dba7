#pragma once
#include <atomic>
#include <functional>
#include <string>

#include "comms/bus.hpp"
#include "core/expected.hpp"
#include "station/intake.hpp"
#include "station/item_queue.hpp"
#include "station/station_config.hpp"
#include "station/store_feeder.hpp"

namespace kawara::station {

struct RunLimits {
  double duration_s = 0.0;   ///< live: end after this; 0: never
  double idle_exit_s = 0.0;  ///< live: end when the bus has been silent for so long; 0: never
};

/// PHASE1, POSE, POSE.EPOCH and EVENT from a bus into the store, OBJECT, OBJECT.TEXTURE and ROAD
/// into its register of changed objects.
class Station {
 public:
  using Say = std::function<void(const std::string&)>;
  Station(const StationConfig& config, StoreFeeder feeder, Say say);

  /// From the live bus until `stop`: this thread hears, a second one writes, between them a bounded
  /// queue, so that a slow disk or a lost server costs nothing but memory (up to queue_mb, then the
  /// oldest pictures).
  core::Expected<void> RunLive(comms::Bus& bus, const RunLimits& limits,
                               const std::atomic<bool>& stop);
  /// From a log until its end: one thread, nothing dropped, the same log gives the same store.
  core::Expected<void> RunLog(comms::Bus& bus, const std::atomic<bool>& stop);

  /// "120 pictures (120 full), 240 poses, 3 events in store.gpkg; missing 0, late 0, ..."
  std::string Summary() const;

 private:
  core::Expected<void> Subscribe(comms::Bus& bus);
  void WriteUntilStopped(const std::atomic<bool>& stopping);
  core::Expected<void> CommitPatiently(bool finish);

  StationConfig config_;
  Say say_;
  StoreFeeder feeder_;
  ItemQueue queue_;
  bool direct_ = false;  ///< from a log: without the queue
  Intake intake_;
  core::MonoTime now_;  ///< arrival of the message in hand
  core::MonoTime last_heard_;
  std::string bus_trouble_;
  std::uint64_t bad_messages_ = 0;
};

}  // namespace kawara::station
