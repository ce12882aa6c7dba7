#pragma once
#include <netinet/in.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "core/expected.hpp"
#include "sim/radio/radio_channel.hpp"

namespace kawara::sim {

/// One side of the radio as its neighbours see it: an LCM bus on UDP multicast.
struct RadioSide {
  in_addr group{};
  std::uint16_t port = 0;
  int ttl = 0;
};
/// "udpm://239.255.76.67:7667?ttl=0", as LCM writes it (other options are passed over). Errors:
/// kInvalidArgument.
core::Expected<RadioSide> ParseRadioSide(const std::string& url);

struct RadioRelayOptions {
  std::string robot_url = "udpm://239.255.76.67:7667?ttl=0";
  std::string base_url = "udpm://239.255.76.67:7668?ttl=0";
  RadioOptions down{};  ///< robot to base
  RadioOptions up{};    ///< base to robot
  std::uint64_t seed = 1;
};

struct RadioSummary {
  RadioChannel::Counters down;
  RadioChannel::Counters up;
  std::string ToText() const;  ///< one line
};

/// Carries the datagrams of two LCM buses across a simulated radio, both ways. It works below LCM:
/// a large message is many datagrams and needs each of them, as on the air. Every sender on one
/// side has a socket of its own on the other, because LCM tells the fragments of two senders apart
/// by their address.
class RadioRelay {
 public:
  /// Errors: the URLs; the same bus on both sides; no multicast (say how to mend it).
  static core::Expected<std::unique_ptr<RadioRelay>> Open(const RadioRelayOptions& options);
  ~RadioRelay();
  RadioRelay(const RadioRelay&) = delete;
  RadioRelay& operator=(const RadioRelay&) = delete;

  /// Carries until `stop` (looked at 20 times a second) or `end`, if that is set. `faults` says
  /// what is wrong at a moment. What is still in the air is lost. Blocks; one thread.
  RadioSummary Run(const std::function<RadioFaults(core::MonoTime)>& faults, core::MonoTime end,
                   const std::atomic<bool>& stop);

 private:
  struct Impl;
  explicit RadioRelay(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace kawara::sim
