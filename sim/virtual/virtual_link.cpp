#include "sim/virtual/virtual_link.hpp"

#include <algorithm>
#include <utility>

#include "drivers/reconnecting_port.hpp"
#include "drivers/serial_port.hpp"

namespace kawara::sim {
namespace {

constexpr int kBitsPerByte = 10;

std::string Tenths(core::Duration d) {
  const std::int64_t tenths = (d.count() + 50'000'000) / 100'000'000;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10);
}

/// The rules of the real port.
const drivers::ReconnectConfig& Rules() {
  static const drivers::ReconnectConfig rules;
  return rules;
}

}  // namespace

VirtualLink::VirtualLink(onboard::PortId id, std::string device, int baud_bps, VirtualPort& port)
    : id_(id),
      device_(std::move(device)),
      baud_bps_(baud_bps),
      port_(port),
      backoff_(Rules().backoff_min) {}

void VirtualLink::SetBaud(int baud_bps) {
  baud_bps_ = baud_bps;
  if (port_.open()) port_.SetBaud(baud_bps);
}

void VirtualLink::Note(core::Severity severity, bool changed, const std::string& text,
                       const std::function<void(const onboard::PortNote&)>& tell) const {
  tell({.port = id_, .open = port_.open(), .changed = changed, .severity = severity, .text = text});
}

void VirtualLink::Service(core::MonoTime now,
                          const std::function<void(const onboard::PortNote&)>& tell) {
  if (was_open_ && !port_.open()) {
    was_open_ = false;
    backoff_ = Rules().backoff_min;
    next_try_ = now + backoff_;
    missing_told_ = {};
    Note(core::Severity::kWarnHigh, true,
         "lost " + device_ + ": the device is gone (looking for it every " +
             Tenths(Rules().backoff_min) + ".." + Tenths(Rules().backoff_max) + " s)",
         tell);
  }
  if (!was_open_) {
    if (next_try_.IsSet() && now < next_try_) return;
    if (port_.Open(baud_bps_)) return Opened(now, tell);
    next_try_ = now + backoff_;
    backoff_ = std::min(2 * backoff_, Rules().backoff_max);
    if (missing_told_.IsSet() && now - missing_told_ < Rules().reminder) return;
    missing_told_ = now;
    return Note(core::Severity::kWarnHigh, false, "open " + device_ + ": no such device", tell);
  }
  if (std::exchange(was_silent_, silent_) && !silent_) {
    Note(core::Severity::kInfo, false, device_ + ": bytes again", tell);
  }
  if (!silent_ && now - last_byte_ > Rules().silence) {
    silent_ = was_silent_ = true;
    Note(core::Severity::kWarnHigh, false,
         device_ + ": open, but no byte for " + Tenths(now - last_byte_) +
             " s (switched on? cable? baud rate " + std::to_string(port_.baud_bps()) + "?)",
         tell);
  }
}

void VirtualLink::Opened(core::MonoTime now,
                         const std::function<void(const onboard::PortNote&)>& tell) {
  was_open_ = true;
  silent_ = was_silent_ = false;
  backoff_ = Rules().backoff_min;
  last_byte_ = line_empty_at_ = now;
  Note(core::Severity::kInfo, true, "opened " + device_ + ": " + std::to_string(baud_bps_) + " 8N1",
       tell);
}

std::span<const std::uint8_t> VirtualLink::Read(core::MonoTime now) {
  const std::size_t behind = port_.waiting();
  const std::size_t n = was_open_ ? port_.HostRead(buffer_) : 0;
  if (n == 0) {
    line_empty_at_ = now;
    return {};
  }
  const core::Duration spacing =
      core::Nanoseconds(std::int64_t{kBitsPerByte} * 1'000'000'000 / std::max(port_.baud_bps(), 1));
  first_byte_ = drivers::DateFirstByte(behind, line_empty_at_, now, now, spacing);
  line_empty_at_ = n < buffer_.size() ? now : first_byte_ + static_cast<std::int64_t>(n) * spacing;
  last_byte_ = now;
  silent_ = false;
  return std::span<const std::uint8_t>(buffer_).first(n);
}

}  // namespace kawara::sim
