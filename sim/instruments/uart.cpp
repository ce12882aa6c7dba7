#include "sim/instruments/uart.hpp"

#include <algorithm>

namespace kawara::sim {
namespace {

constexpr int kBitsPerByte = 10;  // start, eight data, stop

core::Duration ByteTime(int bits_per_byte, int baud_bps) {
  return core::Nanoseconds(std::int64_t{bits_per_byte} * 1000000000 / baud_bps);
}

}  // namespace

UartTransmitter::UartTransmitter(int baud_bps, std::size_t buffer_bytes, int bits_per_byte)
    : baud_bps_(baud_bps), buffer_bytes_(buffer_bytes), bits_per_byte_(bits_per_byte) {}

bool UartTransmitter::Send(core::MonoTime at, std::span<const std::uint8_t> message) {
  if (queue_.size() + message.size() > buffer_bytes_) {
    ++dropped_messages_;
    return false;
  }
  line_free_ = std::max(line_free_, at);
  for (const std::uint8_t value : message) {
    line_free_ += ByteTime(bits_per_byte_, baud_bps_);
    queue_.push_back({line_free_, baud_bps_, value});
  }
  return true;
}

UartTransmitter::Chunk UartTransmitter::TakeSent(core::MonoTime now) {
  Chunk chunk;
  while (!queue_.empty() && queue_.front().sent <= now) {
    if (!chunk.bytes.empty() && queue_.front().baud_bps != chunk.baud_bps) break;
    chunk.baud_bps = queue_.front().baud_bps;
    chunk.bytes.push_back(queue_.front().value);
    queue_.pop_front();
  }
  return chunk;
}

void UartTransmitter::Clear() {
  queue_.clear();
  line_free_ = core::MonoTime{};
}

std::vector<std::uint8_t> ReceiveAtWrongBaud(std::span<const std::uint8_t> sent, int send_baud_bps,
                                             int receive_baud_bps) {
  // Time in bits of the sender; the line idles high before and after.
  const double total = static_cast<double>(sent.size()) * kBitsPerByte;
  const auto level = [&](double t) {
    if (t < 0.0 || t >= total) return true;
    const auto bit = static_cast<std::size_t>(t);
    const std::size_t in_byte = bit % kBitsPerByte;
    if (in_byte == 0) return false;
    if (in_byte == kBitsPerByte - 1) return true;
    return ((sent[bit / kBitsPerByte] >> (in_byte - 1)) & 1U) != 0;
  };
  const double step = static_cast<double>(send_baud_bps) / receive_baud_bps;
  std::vector<std::uint8_t> received;
  double t = 0.0;
  while (t < total) {
    // Edges fall on whole bits of the sender only: high at t, then the next low bit.
    if (!level(t)) {
      const bool was_high = level(t - 0.5) || t == 0.0;
      if (!was_high) {
        t = static_cast<double>(static_cast<std::size_t>(t) + 1);
        continue;
      }
    } else {
      t = static_cast<double>(static_cast<std::size_t>(t) + 1);
      if (level(t)) continue;
      if (t >= total) break;
    }
    if (level(t + 0.5 * step)) {  // too short for a start bit at this rate: noise
      t += std::max(0.5 * step, 0.5);
      continue;
    }
    unsigned value = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if (level(t + (1.5 + bit) * step)) value |= 1U << bit;
    }
    received.push_back(static_cast<std::uint8_t>(value));
    t += 9.5 * step;  // middle of the stop bit: from there on the next start edge counts
  }
  return received;
}

}  // namespace kawara::sim
