#pragma once
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace kawara::core {

/// One number that anybody may watch. Real-time safe, any number of threads.
class Counter {
 public:
  void Add(std::int64_t n = 1) { value_.fetch_add(n, std::memory_order_relaxed); }
  /// For values that are counted elsewhere (a decoder's stats) or are levels rather than counts.
  void Set(std::int64_t value) { value_.store(value, std::memory_order_relaxed); }
  std::int64_t value() const { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> value_{0};
};

/// All counters of one program, by name: what was dropped, refused or repaired, each with a name of
/// its own. Register() and Snapshot() lock and allocate: call them at start and from slow threads
/// only. The Counter that Register() hands out lives as long as this object and is what real-time
/// code keeps.
class Counters {
 public:
  struct Value {
    std::string name;
    std::int64_t value = 0;
    bool operator==(const Value&) const = default;
  };

  /// `name` is dotted lower case, "gps.nmea.bad_checksum" ([a-z0-9_] between dots); anything else
  /// is our bug. The same name again gives the same counter.
  Counter& Register(std::string_view name);
  /// All counters, sorted by name.
  std::vector<Value> Snapshot() const;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Counter>, std::less<>> counters_;
};

}  // namespace kawara::core
