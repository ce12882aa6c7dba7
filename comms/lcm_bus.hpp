#pragma once
#include <memory>
#include <string>
#include <vector>

#include "comms/bus.hpp"

namespace kawara::comms {

struct LcmBusConfig {
  /// Empty: the environment's LCM_DEFAULT_URL, else LCM's own group. "memq://" stays inside this
  /// process.
  std::string url{};
  /// Used if the URL does not say. A 1 MB message comes in 16 datagrams that must wait here: with
  /// the kernel's default of 208 KiB none of them ever arrives whole.
  int receive_buffer_bytes = 2 << 20;
  /// Messages that may wait for HandleFor per subscription (LCM's own default is 30); the newest is
  /// dropped beyond.
  int queue_capacity = 400;
};

/// The live bus: LCM, normally UDP multicast that stays on this machine (ttl 0 unless the URL says
/// otherwise). Receives on a thread of LCM's own, which inherits the scheduling of the thread that
/// opens the bus.
class LcmBus : public Bus {
 public:
  /// Checks the way the messages will take before LCM does (its own self-test takes 10 s to fail).
  /// Errors: kUnavailable, no multicast on this machine: the message has the commands that mend it;
  /// kInvalidArgument, the URL.
  [[nodiscard]] static core::Expected<std::unique_ptr<LcmBus>> Open(
      const LcmBusConfig& config = {});
  ~LcmBus() override;

  core::Expected<void> Publish(std::string_view channel,
                               std::span<const std::uint8_t> data) override;
  core::Expected<void> Subscribe(const std::string& channel, Handler handler) override;
  core::Expected<int> HandleFor(core::Duration timeout) override;
  int fd() const override;

  /// What is not as it should be although the bus works, one line each with the cure:
  /// "net.core.rmem_max is 212992, ... : sysctl -w net.core.rmem_max=2097152".
  const std::vector<std::string>& warnings() const;
  /// The URL in use, completed.
  const std::string& url() const;

 private:
  struct Impl;
  explicit LcmBus(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::comms
