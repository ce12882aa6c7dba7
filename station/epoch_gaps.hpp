#pragma once
#include <cstdint>
#include <set>

namespace kawara::station {

/// Finds lost packets by the holes in a sequence that counts up by one from wherever we joined it.
/// A packet that fills a hole later is late, not lost. Remembers at most 4096 single holes (older
/// ones stay lost).
class EpochGaps {
 public:
  /// False: this number has been here before (or left a hole too long ago to know).
  bool Take(std::int64_t number);
  std::int64_t missing() const { return missing_; }
  std::int64_t late() const { return late_; }

 private:
  std::int64_t next_ = 0;  ///< 0: nothing seen yet
  std::int64_t missing_ = 0;
  std::int64_t late_ = 0;
  std::set<std::int64_t> holes_;
};

}  // namespace kawara::station
