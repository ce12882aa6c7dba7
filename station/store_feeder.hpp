#pragma once
#include <cstdio>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "gis/store.hpp"
#include "station/item.hpp"
#include "station/object_feeder.hpp"

namespace kawara::station {

/// Brings items into the store and keeps trying: while the store cannot be written (disk full,
/// locked, server down) nothing is acknowledged and nothing is forgotten; one line is printed when
/// the trouble begins, changes or ends. Writes for every picture stage when it became durable to a
/// CSV: epoch,gps_ns,stage,mono_ns,received_mono_ns (CLOCK_MONOTONIC of this machine). One thread
/// only.
class StoreFeeder {
 public:
  using Say = std::function<void(const std::string&)>;
  /// `latency_csv`: path, empty: none.
  static core::Expected<StoreFeeder> Create(gis::StoreConfig config, const std::string& latency_csv,
                                            Say say);

  /// Opens the store if it is not open. Commit() does that too.
  core::Expected<void> Connect();
  /// Takes the item; Commit() makes it durable.
  void Put(Item item);
  /// One attempt. Says what is wrong; the items stay.
  core::Expected<void> Commit();
  /// Commits and closes the store in good order. One attempt.
  core::Expected<void> Finish();

  std::size_t pending() const { return pending_.size() + pending_objects_.size(); }
  std::size_t pending_pictures() const { return pending_pictures_; }
  std::int64_t refused() const { return refused_; }
  const ObjectCounts& objects() const { return objects_.counts(); }
  gis::StoreStats stats() const { return store_ ? store_->stats() : gis::StoreStats{}; }
  /// Packet received to picture durable: the p-th part (0..1) of the latest 100000 [s]; NaN: no
  /// picture yet.
  double LatencyQuantileS(double p) const;

 private:
  StoreFeeder(gis::StoreConfig config, Say say);
  core::Expected<void> Attempt(bool finish);
  /// Objects hold up nothing else: what cannot be registered now waits, bounded.
  core::Expected<void> RegisterObjects(bool finish);
  void Report(const core::Expected<void>& result);
  void Acknowledge();

  struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  gis::StoreConfig config_;
  Say say_;
  std::optional<gis::SpatioTemporalStore> store_;
  ObjectFeeder objects_;
  std::unique_ptr<std::FILE, CloseFile> csv_;
  std::vector<Item> pending_;         ///< not durable yet
  std::deque<Item> pending_objects_;  ///< not registered yet
  std::size_t handed_ = 0;            ///< of pending_, in the hands of store_
  std::size_t pending_pictures_ = 0;
  std::int64_t refused_ = 0;
  std::string trouble_;  ///< what was said last; empty: all is well
  std::string objects_trouble_;
  core::MonoTime trouble_since_;
  std::vector<double> latencies_s_;
  std::size_t next_latency_ = 0;
};

}  // namespace kawara::station
