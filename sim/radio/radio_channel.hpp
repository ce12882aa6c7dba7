#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/time.hpp"
#include "sim/dice.hpp"

namespace kawara::sim {

/// What one direction of a packet radio does to datagrams. All zero: a perfect wire. IP cuts a
/// datagram that is longer than `mtu_bytes` into packets, of which none may be lost: LCM's 64 kB
/// datagrams are 45 packets on Ethernet or Wi-Fi.
struct RadioOptions {
  double rate_bps = 0.0;  ///< of the air, headers included; 0: without limit
  double delay_s = 0.0;   ///< from the last bit sent to delivery
  double jitter_s = 0.0;  ///< mean of an exponential delay on top; order is kept
  double loss = 0.0;      ///< share of packets lost one by one, in [0, 1]
  /// Share of packets lost because they meet a fade, in [0, 1), and the mean number of packets a
  /// fade takes. Source: E. N. Gilbert, "Capacity of a Burst-Noise Channel", Bell Syst. Tech. J. 39
  /// (1960): a chain of a good state that loses nothing and a bad one that loses everything.
  double burst_loss = 0.0;
  double burst_length = 20.0;
  std::size_t queue_bytes = 262'144;  ///< waits before a slow air; what comes then is dropped
  std::size_t mtu_bytes = 1500;       ///< of an IP packet
};

/// What is wrong with the radio at the moment, over and above its options.
struct RadioFaults {
  bool down = false;                   ///< nothing comes through
  std::optional<double> loss{};        ///< instead of RadioOptions::loss, if that is smaller
  std::optional<double> burst_loss{};  ///< likewise
  std::optional<double> rate_bps{};    ///< the air is not faster than this
  std::optional<double> delay_s{};     ///< on top
};

/// One direction of the radio link: says when each datagram arrives, or that it does not. Keeps the
/// order. What is lost in the air has used the air all the same. No I/O and no clock of its own;
/// what happens to the n-th packet is drawn from the seed and n alone, so that loss does not depend
/// on timing. One thread.
class RadioChannel {
 public:
  static constexpr std::size_t kIpHeaderBytes = 20;  ///< of every packet
  static constexpr std::size_t kUdpHeaderBytes = 8;  ///< of every datagram

  RadioChannel(const RadioOptions& options, std::uint64_t seed) : options_(options), dice_(seed) {}

  /// A datagram of `payload_bytes` is handed over at `now`, which never goes back.
  std::optional<core::MonoTime> Offer(core::MonoTime now, std::size_t payload_bytes,
                                      const RadioFaults& faults);

  struct Counters {
    std::uint64_t offered = 0;        ///< datagrams, here and below
    std::uint64_t offered_bytes = 0;  ///< payload
    std::uint64_t packets = 0;
    std::uint64_t delivered = 0;
    std::uint64_t delivered_bytes = 0;
    std::uint64_t lost = 0;            ///< for a packet lost alone
    std::uint64_t lost_in_bursts = 0;  ///< for a fade
    std::uint64_t lost_while_down = 0;
    std::uint64_t dropped = 0;  ///< the queue was full
  };
  const Counters& counters() const { return counters_; }

 private:
  bool Fades(double burst_loss);

  RadioOptions options_;
  Dice dice_;
  bool fading_ = false;
  core::MonoTime air_free_{};  ///< when the last datagram handed over has left
  core::MonoTime last_arrival_{};
  Counters counters_;
};

}  // namespace kawara::sim
