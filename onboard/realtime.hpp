#pragma once
#include <string>
#include <vector>

namespace kawara::onboard {

/// What the calling thread asked of the system and did not get, each with its cure, one line each.
/// Empty: everything was granted.
using RealtimeComplaints = std::vector<std::string>;

/// Locks all memory, present and future (no page fault on the real-time path).
RealtimeComplaints LockMemory();

/// Makes the calling thread SCHED_FIFO with this priority (1..99) and names it. Refusal degrades,
/// never stops: the thread goes on under normal scheduling.
RealtimeComplaints BecomeRealtime(const char* thread_name, int priority);

/// Makes the calling thread give way to everything else: nice 10 for comms helpers, SCHED_IDLE for
/// the mapper.
void BecomeBackground(const char* thread_name, int nice_level);

}  // namespace kawara::onboard
