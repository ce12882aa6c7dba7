#include "sim/virtual/virtual_port.hpp"

#include <algorithm>

namespace kawara::sim {
namespace {

constexpr std::size_t kDriverBuffer = 4096;  ///< as Linux keeps for a terminal nobody reads

}  // namespace

void VirtualPort::Unplug() {
  device_.clear();
  open_ = false;
  to_host_.clear();
  transmitter_.Clear();
}

core::Expected<void> VirtualPort::Replug() {
  device_ = name_;
  return {};
}

std::size_t VirtualPort::Write(std::span<const std::uint8_t> bytes) {
  const std::size_t n = std::min(bytes.size(), kDriverBuffer - to_host_.size());
  to_host_.insert(to_host_.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(n));
  return n;
}

std::size_t VirtualPort::Read(std::span<std::uint8_t> bytes) {
  // Never more than fits: the rest stays in the transmitter's queue for the next call.
  std::size_t n = 0;
  while (n < bytes.size() && transmitter_.NextSent().IsSet() && transmitter_.NextSent() <= now_) {
    const core::MonoTime one = transmitter_.NextSent();
    for (const std::uint8_t byte : transmitter_.TakeSent(one).bytes) bytes[n++] = byte;
  }
  return n;
}

bool VirtualPort::Open(int baud_bps) {
  if (!plugged()) return false;
  open_ = true;
  to_host_.clear();
  SetBaud(baud_bps);
  return true;
}

void VirtualPort::SetBaud(int baud_bps) {
  baud_bps_ = baud_bps;
  transmitter_.SetBaud(baud_bps);
}

std::size_t VirtualPort::HostRead(std::span<std::uint8_t> bytes) {
  const std::size_t n = std::min(bytes.size(), to_host_.size());
  const auto end = to_host_.begin() + static_cast<std::ptrdiff_t>(n);
  std::copy(to_host_.begin(), end, bytes.begin());
  to_host_.erase(to_host_.begin(), end);
  return n;
}

void VirtualPort::HostWrite(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  if (open_) transmitter_.Send(now, bytes);
}

}  // namespace kawara::sim
