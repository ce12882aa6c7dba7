#include "sim/instruments/serial_line.hpp"

#include <algorithm>
#include <array>

namespace kawara::sim {
namespace {

constexpr core::Duration kFifoPeriod = core::Milliseconds(1);

}  // namespace

core::Expected<void> SerialLine::Service(core::MonoTime now, const Faults& faults) {
  if (faults.unplugged && port_->plugged()) port_->Unplug();
  if (!faults.unplugged && !port_->plugged()) {
    core::Expected<void> replugged = port_->Replug();
    if (!replugged) return replugged;
    ++counters_.replugs;
  }
  const HostPort::HostSide host = port_->host();
  TakeInput(now, host);
  instrument_.Advance(now);
  GiveOutput(now, host, faults);
  return {};
}

void SerialLine::TakeInput(core::MonoTime now, const HostPort::HostSide& host) {
  std::array<std::uint8_t, 512> buffer;
  while (const std::size_t n = port_->Read(buffer)) {
    if (host.baud_bps == instrument_.transmitter().baud_bps() && !host.parity) {
      instrument_.Receive(now, std::span(buffer).first(n));
    } else {
      counters_.ignored_input_bytes += n;
    }
  }
}

void SerialLine::GiveOutput(core::MonoTime now, const HostPort::HostSide& host,
                            const Faults& faults) {
  for (;;) {
    UartTransmitter::Chunk chunk = instrument_.transmitter().TakeSent(now);
    if (chunk.bytes.empty()) return;
    last_output_ = now;
    if (!host.open || faults.silent) {
      counters_.unheard_bytes += chunk.bytes.size();
      continue;
    }
    if (faults.stuck) {
      std::fill(chunk.bytes.begin(), chunk.bytes.end(), last_good_byte_);
    } else {
      last_good_byte_ = chunk.bytes.back();
    }
    if (faults.garbage) {
      for (std::uint8_t& byte : chunk.bytes) byte = static_cast<std::uint8_t>(dice_.Next() >> 56);
    }
    if (host.baud_bps != chunk.baud_bps) {
      counters_.wrong_baud_bytes += chunk.bytes.size();
      chunk.bytes = host.baud_bps == 0
                        ? std::vector<std::uint8_t>{}
                        : ReceiveAtWrongBaud(chunk.bytes, chunk.baud_bps, host.baud_bps);
    }
    const std::size_t taken = port_->Write(chunk.bytes);
    counters_.sent_bytes += taken;
    counters_.overrun_bytes += chunk.bytes.size() - taken;
  }
}

core::MonoTime SerialLine::NextService() const {
  const core::MonoTime sent = instrument_.transmitter().NextSent();
  return sent.IsSet() ? std::max(sent, last_output_ + kFifoPeriod) : instrument_.NextEvent();
}

}  // namespace kawara::sim
