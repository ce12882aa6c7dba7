#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "core/time.hpp"
#include "onboard/input.hpp"
#include "sim/virtual/virtual_port.hpp"

namespace kawara::sim {

/// The host's end of a VirtualPort as drivers::ReconnectingPort is of a real one: opens it and
/// looks for it again, dates the first byte of what it reads as over a wire, and has the same to
/// tell. One thread.
class VirtualLink {
 public:
  /// `port` must outlive it.
  VirtualLink(onboard::PortId id, std::string device, int baud_bps, VirtualPort& port);

  /// Opens when due, notices loss and silence. What there is to tell goes to `tell`.
  void Service(core::MonoTime now, const std::function<void(const onboard::PortNote&)>& tell);
  /// Bytes that are here; dated by first_byte().
  std::span<const std::uint8_t> Read(core::MonoTime now);
  core::MonoTime first_byte() const { return first_byte_; }
  void Write(core::MonoTime now, std::span<const std::uint8_t> bytes) {
    port_.HostWrite(now, bytes);
  }
  void SetBaud(int baud_bps);

 private:
  void Opened(core::MonoTime now, const std::function<void(const onboard::PortNote&)>& tell);
  void Note(core::Severity severity, bool changed, const std::string& text,
            const std::function<void(const onboard::PortNote&)>& tell) const;

  onboard::PortId id_;
  std::string device_;
  int baud_bps_;
  VirtualPort& port_;
  bool was_open_ = false;
  bool silent_ = false;
  bool was_silent_ = false;
  core::MonoTime next_try_, missing_told_, last_byte_, line_empty_at_, first_byte_;
  core::Duration backoff_;
  std::array<std::uint8_t, 2048> buffer_{};
};

}  // namespace kawara::sim
