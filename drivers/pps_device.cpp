#include "drivers/pps_device.hpp"

#include <fcntl.h>
#include <linux/pps.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <fstream>
#include <utility>

#include "drivers/serial_diagnosis.hpp"

namespace kawara::drivers {
namespace {

constexpr int kReadings = 5;
/// The kernel waits in whole ticks; less than one is not worth a call.
constexpr core::Duration kTick = core::Milliseconds(10);

std::int64_t NsOf(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return t.tv_sec * 1'000'000'000LL + t.tv_nsec;
}

/// What the driver calls itself, e.g. "pps_parport" or "serial0"; empty if sysfs does not say.
std::string NameInSysfs(std::uint64_t rdev) {
  std::ifstream file("/sys/dev/char/" + std::to_string(major(rdev)) + ":" +
                     std::to_string(minor(rdev)) + "/name");
  std::string name;
  std::getline(file, name);
  return name;
}

}  // namespace

ClockPair ClockPair::Read() {
  ClockPair best;
  std::int64_t narrowest = INT64_MAX;
  for (int i = 0; i < kReadings; ++i) {
    const std::int64_t before = NsOf(CLOCK_MONOTONIC);
    const std::int64_t realtime = NsOf(CLOCK_REALTIME);
    const std::int64_t after = NsOf(CLOCK_MONOTONIC);
    if (after - before >= narrowest) continue;
    narrowest = after - before;
    best = {realtime, core::MonoTime::FromNs(before + (after - before) / 2)};
  }
  return best;
}

std::optional<core::MonoTime> OnMonotonic(std::int64_t stamp_realtime_ns, const ClockPair& before,
                                          const ClockPair& now) {
  const core::Duration moved(now.offset_ns() - before.offset_ns());
  if (std::chrono::abs(moved) > kClockStep) return std::nullopt;
  if (stamp_realtime_ns > now.realtime_ns) return std::nullopt;
  return now.mono - core::Duration(now.realtime_ns - stamp_realtime_ns);
}

KernelPps::~KernelPps() {
  if (fd_ >= 0) close(fd_);
}

tl::unexpected<core::Error> KernelPps::Lose(core::Error why) {
  close(std::exchange(fd_, -1));
  return tl::unexpected(std::move(why));
}

core::Expected<void> KernelPps::CheckIsPulse() {
  const auto refuse = [this](const std::string& why) {
    return core::Fail(core::ErrorCode::kInvalidArgument, "pulses of " + device_ + ": " + why);
  };
  int capabilities = 0;
  if (ioctl(fd_, PPS_GETCAP, &capabilities) != 0) {
    return refuse(
        "not a PPS device (those are /dev/pps0, ...; `ldattach PPS TTY` makes one of the "
        "carrier-detect wire of a serial port)");
  }
  if (NameInSysfs(rdev_).find("ktimer") != std::string::npos) {
    return refuse("the kernel's own timer, not a receiver's pulse (module pps-ktimer)");
  }
  const int wanted = edge_ == PulseEdge::kRising ? PPS_CAPTUREASSERT : PPS_CAPTURECLEAR;
  if ((capabilities & wanted) == 0) {
    return refuse(edge_ == PulseEdge::kRising
                      ? "its driver does not stamp rising edges (gps.pps.edge: falling)"
                      : "its driver does not stamp falling edges (gps.pps.edge: rising)");
  }
  pps_kparams params{};
  if (ioctl(fd_, PPS_GETPARAMS, &params) != 0 || (params.mode & wanted) == 0) {
    params.api_version = PPS_API_VERS;
    params.mode |= wanted | PPS_TSFMT_TSPEC;
    // Setting needs CAP_SYS_TIME; drivers capture all they can until somebody else sets them.
    if (ioctl(fd_, PPS_SETPARAMS, &params) != 0) {
      return refuse("this edge is not captured, and may not be switched on (CAP_SYS_TIME needed)");
    }
  }
  return {};
}

core::Expected<void> KernelPps::Open() {
  fd_ = open(device_.c_str(), O_RDWR | O_CLOEXEC);
  // Fetching needs reading only.
  if (fd_ < 0 && errno == EACCES) fd_ = open(device_.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd_ < 0) {
    const int error = errno;
    if (error == ENOENT) {
      return core::Fail(core::ErrorCode::kNotFound,
                        "pulses of " + device_ +
                            ": no such device (is its driver loaded: pps-gpio, pps_parport, or "
                            "ldattach for a serial line?)");
    }
    return tl::unexpected(OpenError(device_, error));
  }
  struct stat info {};
  fstat(fd_, &info);
  inode_ = info.st_ino;
  rdev_ = info.st_rdev;
  if (auto pulse = CheckIsPulse(); !pulse) return Lose(pulse.error());
  const auto latest = Fetch({});
  if (!latest) return Lose(latest.error());
  last_sequence_ = latest->sequence;
  ++stats_.opened;
  return {};
}

core::Expected<KernelPps::Latest> KernelPps::Fetch(core::Duration timeout) {
  pps_fdata data{};
  data.timeout.sec = timeout.count() / 1'000'000'000;
  data.timeout.nsec = static_cast<__s32>(timeout.count() % 1'000'000'000);
  if (ioctl(fd_, PPS_FETCH, &data) != 0 && errno != ETIMEDOUT && errno != EINTR) {
    return tl::unexpected(core::ErrnoError("pulses of " + device_, errno));
  }
  const bool rising = edge_ == PulseEdge::kRising;
  // Nothing is copied out by a call that timed out.
  if (data.info.current_mode == 0 && data.info.assert_sequence == 0 &&
      data.info.clear_sequence == 0) {
    return Latest{last_sequence_, 0};
  }
  const pps_ktime& stamp = rising ? data.info.assert_tu : data.info.clear_tu;
  return Latest{rising ? data.info.assert_sequence : data.info.clear_sequence,
                stamp.sec * 1'000'000'000LL + stamp.nsec};
}

bool KernelPps::IsStillThere() const {
  struct stat info {};
  return stat(device_.c_str(), &info) == 0 && info.st_ino == inode_ && info.st_rdev == rdev_;
}

core::Expected<std::optional<PpsEdge>> KernelPps::Next(core::Duration timeout) {
  if (fd_ < 0) {
    if (auto opened = Open(); !opened) return tl::unexpected(opened.error());
  }
  const core::MonoTime deadline = core::MonoNow() + timeout;
  for (;;) {
    const ClockPair before = ClockPair::Read();
    // One that came since the last call is here already; the kernel waits only for another.
    auto latest = Fetch({});
    if (latest && latest->sequence == last_sequence_ && before.mono + kTick < deadline) {
      latest = Fetch(deadline - before.mono);
    }
    if (!latest) return Lose(latest.error());
    if (latest->sequence != last_sequence_) {
      last_sequence_ = latest->sequence;
      ++stats_.edges;
      if (const auto mono = OnMonotonic(latest->realtime_ns, before, ClockPair::Read())) {
        return PpsEdge{latest->sequence, *mono};
      }
      ++stats_.clock_steps;
    }
    if (core::MonoNow() + kTick < deadline) continue;
    if (!IsStillThere()) {
      return Lose({core::ErrorCode::kUnavailable, "pulses of " + device_ + ": unplugged"});
    }
    return std::nullopt;
  }
}

}  // namespace kawara::drivers
