#pragma once
#include <cstddef>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "sim/faults/faults.hpp"

namespace kawara::sim {

/// What somebody wants to go wrong while a run is on its way.
struct FaultOrder {
  bool clear = false;  ///< ends what is wrong and takes back what was to come
  std::vector<Fault> faults;
};

/// "gps.unplug 5s" (from now), "t=30 gps.unplug 5s" (from the start of the run), several separated
/// by ';', or "clear". `since_start` is now. The text may be anything; it is quoted in errors with
/// what cannot be printed replaced. Errors: kInvalidArgument, in one line: what was found and what
/// is possible, or that it would be over already.
core::Expected<FaultOrder> ParseFaultOrder(std::string_view text, core::Duration since_start);

/// "t=12.345 gps.unplug 5s; ..." or "clear": what was understood.
std::string ToString(const FaultOrder& order);

/// The plan after an order that is taken at `since_start`; what is over by then is forgotten.
FaultPlan Applied(const FaultPlan& plan, const FaultOrder& order, core::Duration since_start);

/// Hands orders to the one thread that owns the instruments. Any thread posts.
class FaultOrderInbox {
 public:
  static constexpr std::size_t kMostFaults = 1000;
  /// False: so many faults are under way already that this is no test of anything any more.
  bool Post(FaultOrder order);
  /// The owner's: takes what has come; `planned` is how many faults it holds.
  std::vector<FaultOrder> Take(std::size_t planned);

 private:
  std::mutex mutex_;
  std::vector<FaultOrder> orders_;
  std::size_t planned_ = 0;  ///< as of the last Take(), and those waiting
};

}  // namespace kawara::sim
