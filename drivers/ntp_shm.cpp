#include "drivers/ntp_shm.hpp"

#include <sys/ipc.h>
#include <sys/shm.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <string>

namespace kawara::drivers {
namespace {

constexpr key_t kFirstKey = 0x4e545030;
constexpr std::int64_t kSecond_ns = 1'000'000'000;

core::Error Complain(int unit, int error) {
  const std::string which = "NTP shared memory " + std::to_string(unit) + ": ";
  const std::string line = "`refclock SHM " + std::to_string(unit) + ":perm=0666 refid KWB`";
  if (error == ENOENT) {
    return {core::ErrorCode::kNotFound,
            which + "nobody reads it: " + line + " in chrony.conf, and chronyd running?"};
  }
  if (error == EACCES || error == EPERM) {
    return {core::ErrorCode::kPermission,
            which + "this user may not write it: " + line + " in chrony.conf lets everybody"};
  }
  return {core::ErrorCode::kUnavailable, which + std::strerror(error)};
}

}  // namespace

/// As ntpd and chronyd declare it, in their order.
struct NtpShm::Segment {
  int mode;  ///< 1: a reader takes a sample if `count` was the same before and after
  volatile int count;
  std::time_t utc_s;
  int utc_us;
  std::time_t realtime_s;
  int realtime_us;
  int leap;
  int precision;  ///< log2 of seconds
  int samples;
  volatile int valid;
  unsigned utc_ns;
  unsigned realtime_ns;
  int unused[8];
};

core::Expected<void> NtpShm::Attach() {
  const int id = shmget(kFirstKey + unit_, sizeof(Segment), 0);
  if (id < 0) {
    const int error = errno;
    Detach();
    return tl::unexpected(Complain(unit_, error));
  }
  if (segment_ != nullptr && id == id_) return {};
  Detach();
  void* const memory = shmat(id, nullptr, 0);
  // NOLINTNEXTLINE(performance-no-int-to-ptr): how shmat() says it
  if (memory == reinterpret_cast<void*>(-1)) return tl::unexpected(Complain(unit_, errno));
  segment_ = static_cast<Segment*>(memory);
  id_ = id;
  return {};
}

void NtpShm::Detach() {
  if (segment_ != nullptr) shmdt(segment_);
  segment_ = nullptr;
  id_ = -1;
}

core::Expected<void> NtpShm::Tell(const ClockComparison& comparison) {
  if (auto there = Attach(); !there) return there;
  Segment& s = *segment_;
  const std::int64_t utc_ns = comparison.utc.ns();
  const auto fence = [] { std::atomic_thread_fence(std::memory_order_seq_cst); };
  s.mode = 1;
  s.valid = 0;
  s.count = s.count + 1;
  fence();
  s.utc_s = utc_ns / kSecond_ns;
  s.utc_ns = static_cast<unsigned>(utc_ns % kSecond_ns);
  s.utc_us = static_cast<int>(s.utc_ns / 1000);
  s.realtime_s = comparison.realtime_ns / kSecond_ns;
  s.realtime_ns = static_cast<unsigned>(comparison.realtime_ns % kSecond_ns);
  s.realtime_us = static_cast<int>(s.realtime_ns / 1000);
  s.leap = 0;
  s.precision = std::clamp(static_cast<int>(std::ceil(std::log2(comparison.sigma_s))), -30, 0);
  fence();
  s.count = s.count + 1;
  s.valid = 1;
  return {};
}

}  // namespace kawara::drivers
