#include "drivers/correction_forwarder.hpp"

#include <algorithm>
#include <optional>

namespace kawara::drivers {

CorrectionForwarder::CorrectionForwarder(const CorrectionForwarderConfig& config,
                                         core::Events& events)
    : config_(config), events_(events), watchdog_(config.watchdog, events) {}

void CorrectionForwarder::Feed(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  stats_.bytes_in += bytes.size();
  if (config_.mode == CorrectionMode::kRaw) {
    for (auto rest = bytes; !rest.empty();) {
      const auto piece = rest.first(std::min(rest.size(), CorrectionQueue::kMaxMessageBytes));
      rest = rest.subspan(piece.size());
      Push(now, piece);
    }
  }
  // Both decoders see every byte; their messages are taken in the order in which they ended in the
  // stream, so that the split of the bytes does not show in the output.
  auto for_rtcm3 = bytes;
  auto for_rtcm2 = bytes;
  auto frame = rtcm3_.Next(for_rtcm3);
  const Rtcm2Message* message = rtcm2_.Next(for_rtcm2);
  while (frame || message != nullptr) {
    if (frame && (message == nullptr || for_rtcm3.size() >= for_rtcm2.size())) {
      OnRtcm3(now, *frame);
      frame = rtcm3_.Next(for_rtcm3);
    } else {
      OnRtcm2(now, *message);
      message = rtcm2_.Next(for_rtcm2);
    }
  }
}

void CorrectionForwarder::Tick(core::MonoTime now) { watchdog_.Tick(now); }

void CorrectionForwarder::Hold() { held_ = true; }
void CorrectionForwarder::Release() { held_ = false; }

void CorrectionForwarder::Restart() {
  rtcm3_.Reset();
  rtcm2_.Reset();
}

std::span<const std::uint8_t> CorrectionForwarder::Output() const {
  if (held_ && !queue_.mid_message()) return {};
  return queue_.Front();
}

void CorrectionForwarder::Consume(std::size_t bytes) {
  const std::size_t out = std::min(bytes, Output().size());
  stats_.bytes_out += out;
  queue_.Consume(out);
}

CorrectionForwarder::Stats CorrectionForwarder::stats() const {
  Stats s = stats_;
  s.bad_crc = rtcm3_.stats().bad_crc;
  s.parity_errors = rtcm2_.stats().parity_errors;
  s.dropped = queue_.dropped();
  return s;
}

void CorrectionForwarder::OnRtcm3(core::MonoTime now, std::span<const std::uint8_t> frame) {
  ++stats_.messages;
  const Rtcm3Message message = DecodeRtcm3(Rtcm3Payload(frame));
  if (config_.receiver_accepts == CorrectionsAccepted::kRtcm2Only) {
    return Refuse(now, CorrectionFormat::kRtcm3, message.type, frame.size());
  }
  watchdog_.OnMessage(now, message);
  if (config_.mode == CorrectionMode::kMessages) Push(now, frame);
}

void CorrectionForwarder::OnRtcm2(core::MonoTime now, const Rtcm2Message& message) {
  ++stats_.messages;
  if (config_.receiver_accepts == CorrectionsAccepted::kRtcm3Only) {
    return Refuse(now, CorrectionFormat::kRtcm2, message.type, message.stream_bytes);
  }
  watchdog_.OnMessage(now, message);
  if (config_.mode == CorrectionMode::kMessages) Push(now, rtcm2_out_.Encode(message));
}

void CorrectionForwarder::Push(core::MonoTime now, std::span<const std::uint8_t> message) {
  ++stats_.forwarded;
  if (queue_.Push(message)) return;
  core::EventText text("correction queue full: ");
  text.Append(queue_.dropped())
      .Append(held_ ? " old messages dropped while the receiver is being configured"
                    : " old messages dropped, the receiver's port is too slow");
  events_.WarnLow(now, "corrections.dropped", text);
}

void CorrectionForwarder::Refuse(core::MonoTime now, CorrectionFormat format, std::uint16_t type,
                                 std::size_t bytes) {
  ++stats_.refused;
  watchdog_.OnRefused(now, format, type, bytes);
  core::EventText text("source sends ");
  text.Append(ToString(format)).Append(" (type ").Append(type);
  text.Append(
      format == CorrectionFormat::kRtcm3
          ? ") but the receiver takes RTCM 2 only: choose a mountpoint with RTCM 2.3 (18/19/3/22)"
          : ") but the receiver takes RTCM 3 only: choose a mountpoint with RTCM 3");
  events_.WarnHigh(now, "corrections.wrong_format", text);
}

}  // namespace kawara::drivers
