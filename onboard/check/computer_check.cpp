#include "onboard/check/computer_check.hpp"

#include <sched.h>
#include <sys/mman.h>
#include <sys/timex.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <system_error>
#include <thread>

#include "comms/lcm_bus.hpp"
#include "core/time.hpp"
#include "onboard/realtime.hpp"

namespace kawara::onboard {
namespace {

namespace fs = std::filesystem;

/// What a burst of pictures needs of LCM's socket.
constexpr std::int64_t kReceiveBufferBytes = 2'097'152;
/// Nobody's clock is honestly before this program was written.
constexpr std::int64_t kEarliestClockS = 1'767'225'600;  // 2026-01-01
/// Pictures of about an hour.
constexpr double kRoomMb = 2048.0;

std::string FirstLine(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

Finding CheckPriority(const RealtimeConfig& realtime) {
  const char* const subject = "real-time priority";
  if (realtime.priority == 0) return Weak(subject, "switched off (realtime.priority: 0)");
  RealtimeComplaints complaints;
  std::thread([&] { complaints = BecomeRealtime("rt-check", realtime.priority); }).join();
  if (!complaints.empty()) return Weak(subject, complaints.front());
  return Good(subject, "SCHED_FIFO " + std::to_string(realtime.priority) + " is granted");
}

Finding CheckLockedMemory(const RealtimeConfig& realtime) {
  const char* const subject = "locked memory";
  if (!realtime.lock_memory) return Weak(subject, "switched off (realtime.lock_memory: false)");
  const RealtimeComplaints complaints = LockMemory();
  if (!complaints.empty()) return Weak(subject, complaints.front());
  munlockall();
  return Good(subject, "is granted");
}

Finding CheckKernel(const fs::path& system) {
  const bool preempts = FirstLine(system / "sys/kernel/realtime") == "1";
  return Good("kernel", preempts ? "PREEMPT_RT"
                                 : "not PREEMPT_RT: late by up to some milliseconds under load "
                                   "(Debian package linux-image-rt-amd64)");
}

std::optional<Finding> CheckGovernor(const fs::path& system) {
  const char* const subject = "processor governor";
  std::string slow;
  bool any = false;
  std::error_code error;
  for (fs::directory_iterator it(system / "sys/devices/system/cpu", error), end;
       !error && it != end; it.increment(error)) {
    const std::string governor = FirstLine(it->path() / "cpufreq/scaling_governor");
    if (governor.empty()) continue;
    any = true;
    if (governor != "performance") slow = governor;
  }
  if (!any) return std::nullopt;
  if (slow.empty()) return Good(subject, "performance");
  return Weak(subject, slow +
                           ": wakes late from low clocks; mend: echo performance | sudo tee "
                           "/sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
}

Finding CheckReceiveBuffer(const fs::path& system) {
  const char* const subject = "socket buffers";
  const std::string text = FirstLine(system / "proc/sys/net/core/rmem_max");
  const std::int64_t bytes = std::strtoll(text.c_str(), nullptr, 10);
  if (bytes >= kReceiveBufferBytes) return Good(subject, text + " bytes");
  return Weak(subject, "net.core.rmem_max is " + text + ": pictures are lost on the bus; mend: " +
                           "sudo sysctl -w net.core.rmem_max=2097152, and the same line in " +
                           "/etc/sysctl.d/90-kawaraban.conf");
}

Finding CheckBus(const std::string& url) {
  const auto bus = comms::LcmBus::Open({.url = url});
  if (!bus) return Wrong("LCM bus", bus.error().message);
  for (const std::string& warning : (*bus)->warnings()) {
    if (warning.find("rmem_max") == std::string::npos) return Weak("LCM bus", warning);
  }
  return Good("LCM bus", url.empty() ? "LCM's default group" : url);
}

Finding CheckClock() {
  const char* const subject = "system clock";
  timex state{};
  const int answer = adjtimex(&state);
  if (core::UtcTime::FromNs(state.time.tv_sec * 1'000'000'000LL) <
      core::UtcTime::FromNs(kEarliestClockS * 1'000'000'000LL)) {
    return Wrong(subject,
                 "is years behind: the mission's folder and the receiver's date would be wrong; "
                 "mend: sudo date -s ..., or the battery of the computer's clock");
  }
  if (answer == TIME_ERROR) {
    return Weak(subject,
                "nothing keeps it right (poses do not need it; names of folders do): chrony or "
                "systemd-timesyncd");
  }
  return Good(subject, "is kept right");
}

Finding CheckRecording(const RecordConfig& record) {
  const std::string subject = "recording " + record.folder;
  if (!record.enabled) return Weak(subject, "switched off (record.enabled: false)");
  fs::path there = fs::absolute(record.folder);
  std::error_code error;
  while (!fs::exists(there, error) && there != there.parent_path()) there = there.parent_path();
  if (!fs::is_directory(there, error)) {
    return Wrong(subject, there.string() + " is not a folder; mend record.folder");
  }
  if (access(there.c_str(), W_OK | X_OK) != 0) {
    return Wrong(subject, "this user may not write into " + there.string() +
                              "; mend: sudo chown $USER " + there.string());
  }
  const fs::space_info space = fs::space(there, error);
  const double free_mb = static_cast<double>(space.available) / 1e6;
  char text[160];
  std::snprintf(text, sizeof text, "%.0f MB free", free_mb);
  if (free_mb < record.disk_reserve_mb + kRoomMb) {
    std::snprintf(text, sizeof text,
                  "%.0f MB free, of which %.0f are the reserve (record.disk_reserve_mb): under an "
                  "hour of pictures; make room",
                  free_mb, record.disk_reserve_mb);
    return free_mb < record.disk_reserve_mb ? Wrong(subject, text) : Weak(subject, text);
  }
  return Good(subject, text);
}

}  // namespace

Findings CheckComputer(const OnboardConfig& config, const fs::path& system) {
  Findings findings{CheckPriority(config.realtime), CheckLockedMemory(config.realtime),
                    CheckKernel(system)};
  if (auto governor = CheckGovernor(system)) findings.push_back(std::move(*governor));
  findings.push_back(CheckReceiveBuffer(system));
  findings.push_back(CheckBus(config.lcm_url));
  findings.push_back(CheckClock());
  findings.push_back(CheckRecording(config.record));
  return findings;
}

}  // namespace kawara::onboard
