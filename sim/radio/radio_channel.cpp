#include "sim/radio/radio_channel.hpp"

#include <algorithm>

namespace kawara::sim {

bool RadioChannel::Fades(double burst_loss) {
  // The chain's long-run share of the bad state is in / (in + out).
  const double out = 1.0 / std::max(options_.burst_length, 1.0);
  const double draw = dice_.Uniform();
  if (burst_loss <= 0.0) return fading_ = false;
  const double in = out * burst_loss / std::max(1.0 - burst_loss, 1e-9);
  fading_ = fading_ ? draw > out : draw <= in;
  return fading_;
}

std::optional<core::MonoTime> RadioChannel::Offer(core::MonoTime now, std::size_t payload_bytes,
                                                  const RadioFaults& faults) {
  ++counters_.offered;
  counters_.offered_bytes += payload_bytes;
  const std::size_t room = std::max(options_.mtu_bytes, kIpHeaderBytes + 8) - kIpHeaderBytes;
  const std::size_t packets = (payload_bytes + kUdpHeaderBytes + room - 1) / room;
  counters_.packets += packets;
  // Every packet throws the same number of dice, whatever becomes of it.
  bool fades = false, lost = false;
  for (std::size_t i = 0; i < packets; ++i) {
    fades |= Fades(std::max(options_.burst_loss, faults.burst_loss.value_or(0.0)));
    lost |= dice_.Uniform() <= std::max(options_.loss, faults.loss.value_or(0.0));
  }
  const double jitter_s = options_.jitter_s * dice_.Exponential();

  double rate_bps = options_.rate_bps;
  if (faults.rate_bps) {
    rate_bps = rate_bps > 0.0 ? std::min(rate_bps, *faults.rate_bps) : *faults.rate_bps;
  }
  const core::MonoTime start = std::max(now, air_free_);
  if (rate_bps > 0.0) {
    const double waiting_bytes = core::ToSeconds(start - now) * rate_bps / 8.0;
    if (waiting_bytes + static_cast<double>(payload_bytes) >
        static_cast<double>(options_.queue_bytes)) {
      ++counters_.dropped;
      return std::nullopt;
    }
    air_free_ =
        start +
        core::DurationFromSeconds(
            static_cast<double>((payload_bytes + kUdpHeaderBytes + packets * kIpHeaderBytes) * 8) /
            rate_bps);
  } else {
    air_free_ = start;
  }
  if (faults.down) {
    ++counters_.lost_while_down;
    return std::nullopt;
  }
  if (fades) {
    ++counters_.lost_in_bursts;
    return std::nullopt;
  }
  if (lost) {
    ++counters_.lost;
    return std::nullopt;
  }
  ++counters_.delivered;
  counters_.delivered_bytes += payload_bytes;
  last_arrival_ = std::max(
      last_arrival_, air_free_ + core::DurationFromSeconds(
                                     options_.delay_s + faults.delay_s.value_or(0.0) + jitter_s));
  return last_arrival_;
}

}  // namespace kawara::sim
