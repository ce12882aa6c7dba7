#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/events.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"
#include "drivers/ntrip_decoder.hpp"
#include "drivers/ntrip_request.hpp"

namespace kawara::drivers {

struct NtripClientConfig {
  NtripRequest caster;  ///< `gga` is filled in by the client
  bool send_position =
      true;  ///< GGA upload, once there is a valid fix; network solutions do not start without it
  core::Duration position_period = core::Seconds(10);
  core::Duration connect_timeout =
      core::Seconds(10);  ///< for one address, and for the answer's head
  core::Duration silent_timeout = core::Seconds(20);  ///< no byte for so long: connect anew
  core::Duration backoff_first = core::Seconds(1);    ///< doubles with every failure in a row
  core::Duration backoff_max = core::Seconds(60);
  core::Duration backoff_refused =
      core::Seconds(60);  ///< at least this after a refusal: casters ban the impatient
  core::Duration steady_after =
      core::Seconds(30);   ///< a stream that lasted so long makes the back-off start anew
  std::uint64_t seed = 1;  ///< of the jitter, +-25 % of every pause
};

/// Keeps one NTRIP stream flowing: connects, asks, uploads the position, and after any failure
/// connects anew, with exponential back-off and jitter. Every failure is one event with its cure
/// ("ntrip.connect", "ntrip.refused", "ntrip.silent", "ntrip.ended"), and "ntrip.streaming" says
/// that it flows.
///
/// Belongs to the corrections thread, never to the real-time loop: resolving the caster's name
/// (getaddrinfo) may block for seconds while the network is down, and it allocates. Everything
/// after that is non-blocking:
///   for (;;) { client.Wait(core::MonoNow(), core::Milliseconds(200));
///   client.Service(core::MonoNow()); }
/// Hand OnFix() over through a ring. One thread.
class NtripClient {
 public:
  enum class State : std::uint8_t { kPausing, kConnecting, kAsking, kStreaming };
  struct Stats {
    std::uint64_t connects = 0;  ///< TCP connections that came about
    std::uint64_t streams = 0;   ///< of them answered with corrections
    std::uint64_t failures = 0;
    std::uint64_t bytes = 0;  ///< corrections
    std::uint64_t positions_sent = 0;
  };
  /// Takes corrections as they come, any split; call-backs happen inside Service().
  using Output = std::function<void(core::MonoTime now, std::span<const std::uint8_t> bytes)>;

  NtripClient(NtripClientConfig config, core::Events& events, Output output);
  ~NtripClient();
  NtripClient(const NtripClient&) = delete;
  NtripClient& operator=(const NtripClient&) = delete;

  /// Does what can be done now.
  void Service(core::MonoTime now);
  /// Sleeps until the socket wants service, the next deadline or `at_most`.
  void Wait(core::MonoTime now, core::Duration at_most) const;
  /// Newest position of the rover; only fixes with a position are used, and none older than 30 s is
  /// sent.
  void OnFix(const core::GnssFix& fix);

  int fd() const { return fd_; }   ///< -1 while pausing
  short poll_events() const;       ///< for poll()
  core::MonoTime wake_at() const;  ///< call Service() then at the latest
  State state() const { return state_; }
  const Stats& stats() const { return stats_; }
  const std::string& last_error() const {
    return last_error_;
  }  ///< whole, also where the event's was cut

 private:
  struct Address {
    std::array<unsigned char, 128> bytes{};  ///< a sockaddr
    std::uint32_t size = 0;
    int family = 0;
  };

  void Connect(core::MonoTime now);
  void TryNextAddress(core::MonoTime now);
  void OnConnected(core::MonoTime now);
  void Send();
  void Receive(core::MonoTime now);
  void QueuePosition(core::MonoTime now);
  void FailWith(core::MonoTime now, const char* event, core::Severity severity,
                const core::Error& error, bool refused);
  void Close();
  std::string Caster() const;

  const NtripClientConfig config_;
  core::Events& events_;
  const Output output_;
  State state_ = State::kPausing;
  int fd_ = -1;
  std::vector<Address> addresses_;
  std::size_t next_address_ = 0;
  std::string connect_errors_;
  NtripDecoder decoder_;
  std::string to_send_;
  core::MonoTime retry_at_;  ///< while pausing
  core::MonoTime deadline_;  ///< of the state: connect, head or silence
  core::MonoTime stream_since_;
  core::MonoTime position_at_;  ///< when the next one is due
  std::optional<core::GnssFix> fix_;
  unsigned failures_in_a_row_ = 0;
  std::uint64_t random_;
  bool position_sent_ = false;
  Stats stats_;
  std::string last_error_;
};

}  // namespace kawara::drivers
