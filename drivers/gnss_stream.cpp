#include "drivers/gnss_stream.hpp"

#include <algorithm>
#include <cstring>

namespace kawara::drivers {
namespace {

constexpr std::uint8_t kUbxLead = 0xB5;

constexpr std::array<bool, 256> MakeLeads() {
  std::array<bool, 256> leads{};
  leads['$'] = leads[kRtcm3Preamble] = leads[kUbxLead] = true;
  return leads;
}
constexpr std::array<bool, 256> kLeads = MakeLeads();

/// Bytes before the first one that may begin a message (RTCM 2 aside, which has no such byte).
std::size_t BytesBeforeLead(std::span<const std::uint8_t> bytes) {
  std::size_t n = 0;
  while (n < bytes.size() && !kLeads[bytes[n]]) ++n;
  return n;
}

/// Whether a whole text sentence with the right checksum lies behind the first byte. By chance that
/// happens to binary data less than once in a billion headers.
bool HoldsSentence(std::span<const std::uint8_t> bytes) {
  for (std::size_t at = 1; at < bytes.size(); ++at) {
    const void* dollar = std::memchr(bytes.data() + at, '$', bytes.size() - at);
    if (dollar == nullptr) return false;
    at = static_cast<std::size_t>(static_cast<const std::uint8_t*>(dollar) - bytes.data());
    if (NmeaProbe(bytes.subspan(at)).match == NmeaMatch::kSentence) return true;
  }
  return false;
}

/// Message numbers that RTCM 3 has given out: standard, and proprietary ones from 4001 on.
bool KnownRtcm3Type(std::span<const std::uint8_t> payload) {
  if (payload.size() < 2) return false;
  const unsigned type = static_cast<unsigned>(payload[0]) << 4 | payload[1] >> 4;
  return (type >= 1001 && type <= 1304) || type >= 4001;
}

}  // namespace

void GnssStreamDecoder::Feed(core::MonoTime arrival, std::span<const std::uint8_t> bytes,
                             GnssStreamSink& sink) {
  if (bytes.empty()) return;
  AddMark(arrival);
  while (!bytes.empty()) {
    if (begin_ > 0) {
      std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
      end_ -= begin_;
      begin_ = 0;
    }
    const std::size_t n = std::min(bytes.size(), kCapacity - end_);
    std::memcpy(buffer_.data() + end_, bytes.data(), n);
    end_ += n;
    bytes = bytes.subspan(n);
    Process(false, sink);
  }
}

void GnssStreamDecoder::Finish(GnssStreamSink& sink) {
  Process(true, sink);
  rtcm2_.Reset();
  closing_ = Closing::kNone;
  boundary_ = bad_until_ = offset_;
  marks_begin_ = marks_end_ = 0;
}

void GnssStreamDecoder::Process(bool final, GnssStreamSink& sink) {
  while (begin_ < end_) {
    if (closing_ != Closing::kNone) {
      TakeClosing();
      continue;
    }
    const std::size_t before = BytesBeforeLead(Held());
    if (before > 0) {
      Skip(before, sink);
      continue;
    }
    bool decided = false;
    switch (buffer_[begin_]) {
      case '$':
        decided = TryText(final, sink);
        break;
      case kRtcm3Preamble:
        decided = TryRtcm3(final, sink);
        break;
      default:
        decided = TryUbx(final, sink);
        break;
    }
    if (!decided) return;
  }
}

/// After a message: an optional CR, then an optional LF, are its end.
void GnssStreamDecoder::TakeClosing() {
  const std::uint8_t byte = buffer_[begin_];
  const bool cr = byte == '\r' && closing_ == Closing::kCrLf;
  const bool lf = byte == '\n';
  closing_ = cr ? Closing::kLf : Closing::kNone;
  if (!cr && !lf) return;
  ++(closing_is_good_ ? stats_.good_bytes : stats_.bad_bytes);
  Advance(1);
  boundary_ = offset_;
}

// The Try functions look at the lead byte at begin_. False: more bytes are needed.

bool GnssStreamDecoder::TryText(bool final, GnssStreamSink& sink) {
  GnssMessage message;
  const AshtechBinaryProbeResult record = AshtechBinaryProbe(Held());
  switch (record.match) {
    case AshtechBinaryMatch::kNeedMore:
      if (!final) return false;
      break;
    case AshtechBinaryMatch::kRecord: {
      const std::string_view type(record.type.data(), record.type.size());
      if (type == "PBN") {
        message.body = DecodePbn(record.structure);
      } else {
        message.body = AshtechRecord{type};
      }
      Accept(record.length, message, sink);
      return true;
    }
    case AshtechBinaryMatch::kBadChecksum:
      RejectFrame(record.length, sink);
      return true;
    case AshtechBinaryMatch::kNoMatch:
      break;
  }
  const NmeaProbeResult text = NmeaProbe(Held());
  switch (text.match) {
    case NmeaMatch::kNeedMore:
      if (!final) return false;
      Skip(1, sink);
      return true;
    case NmeaMatch::kNoMatch:
      Skip(1, sink);
      return true;
    case NmeaMatch::kBadChecksum:
      // Text to its end: no other message can begin inside.
      ++stats_.bad_checksum;
      stats_.bad_bytes += text.length;
      Advance(text.length);
      boundary_ = offset_;
      closing_ = Closing::kCrLf;
      closing_is_good_ = false;
      return true;
    case NmeaMatch::kSentence:
      break;
  }
  message.sentence = text.sentence;
  if (text.sentence.address == "PASHR" || text.sentence.address == "GPRRE") {
    message.body = ParseAshtech(text.sentence);
  } else {
    message.body = ParseNmea(text.sentence);
  }
  Accept(text.length, message, sink);
  return true;
}

bool GnssStreamDecoder::TryRtcm3(bool final, GnssStreamSink& sink) {
  const auto held = Held();
  if (held.size() < kRtcm3HeaderBytes) {
    if (!final) return false;
    Skip(1, sink);
    return true;
  }
  const bool trusted = rtcm3_seen_ || AtBoundary();
  const bool reserved_bits = (held[1] & 0xFCU) != 0;
  if (reserved_bits && !trusted) {
    Skip(1, sink);
    return true;
  }
  const std::size_t claimed = kRtcm3HeaderBytes +
                              (static_cast<std::size_t>(held[1] & 0x03U) << 8 | held[2]) +
                              kRtcm3CrcBytes;
  if (HoldsSentence(held.first(std::min(claimed, held.size())))) {
    Skip(1, sink);
    return true;
  }
  const Rtcm3ProbeResult probe = Rtcm3Probe(held);
  if (probe.match == Rtcm3Match::kNeedMore && !final) return false;
  if (probe.match == Rtcm3Match::kFrame) {
    const auto payload = Rtcm3Payload(held.first(probe.length));
    if (trusted || KnownRtcm3Type(payload)) {
      rtcm3_seen_ = true;
      GnssMessage message;
      message.body = DecodeRtcm3(payload);
      Accept(probe.length, message, sink);
      return true;
    }
  }
  if (probe.match == Rtcm3Match::kBadCrc && AtBoundary() && !reserved_bits) {
    RejectFrame(probe.length, sink);
  } else {
    Skip(1, sink);
  }
  return true;
}

bool GnssStreamDecoder::TryUbx(bool final, GnssStreamSink& sink) {
  const auto held = Held();
  const UbxProbeResult probe = UbxProbe(held);
  if (probe.match == UbxMatch::kNoMatch ||
      HoldsSentence(held.first(std::min(probe.length, held.size())))) {
    Skip(1, sink);
    return true;
  }
  if (probe.match == UbxMatch::kNeedMore && !final) return false;
  if (probe.match == UbxMatch::kFrame) {
    GnssMessage message;
    message.body = DecodeUbx(held.first(probe.length));
    Accept(probe.length, message, sink);
  } else if (probe.match == UbxMatch::kBadChecksum && AtBoundary()) {
    RejectFrame(probe.length, sink);
  } else {
    Skip(1, sink);
  }
  return true;
}

/// A frame that was expected here and is damaged. The search goes on one byte later; what is found
/// inside is good, the rest of it bad.
void GnssStreamDecoder::RejectFrame(std::size_t bytes, GnssStreamSink& sink) {
  ++stats_.bad_checksum;
  bad_until_ = std::max(bad_until_, offset_ + bytes);
  Skip(1, sink);
}

void GnssStreamDecoder::Accept(std::size_t bytes, GnssMessage& message, GnssStreamSink& sink) {
  message.arrival = ArrivalOf(offset_);
  message.offset = offset_;
  message.bytes = Held().first(bytes);
  stats_.good_bytes += bytes;
  Deliver(message, sink);
  Advance(bytes);
  boundary_ = offset_;
}

void GnssStreamDecoder::Deliver(GnssMessage& message, GnssStreamSink& sink) {
  ++stats_.good;
  if (IsInvalid(message)) ++stats_.invalid;
  closing_ = Closing::kCrLf;
  closing_is_good_ = true;
  sink.OnMessage(message);
}

/// Bytes that begin no message of the other kinds may be RTCM 2. Takes at least one of them; ends
/// early where an RTCM 2 message is complete.
void GnssStreamDecoder::Skip(std::size_t bytes, GnssStreamSink& sink) {
  for (std::size_t taken = 0; taken == 0;) {
    auto rest = Held().first(bytes);
    const Rtcm2Message* rtcm2 = rtcm2_.Next(rest);
    taken = bytes - rest.size();
    const std::uint64_t bad =
        bad_until_ > offset_ ? std::min<std::uint64_t>(bad_until_ - offset_, taken) : 0;
    stats_.bad_bytes += bad;
    stats_.skipped_bytes += taken - bad;
    Advance(taken);
    // A bad frame ends where the next message is expected.
    if (offset_ == bad_until_) boundary_ = offset_;
    const std::uint64_t lost = rtcm2_.stats().parity_errors - stats_.rtcm2_parity_errors;
    stats_.rtcm2_parity_errors += lost;
    stats_.bad_checksum += lost;
    if (rtcm2 != nullptr) DeliverRtcm2(*rtcm2, sink);
  }
}

void GnssStreamDecoder::DeliverRtcm2(const Rtcm2Message& rtcm2, GnssStreamSink& sink) {
  // Its bytes were counted as skipped when nobody could know better.
  const std::uint64_t known = std::min<std::uint64_t>(rtcm2.stream_bytes, stats_.skipped_bytes);
  stats_.skipped_bytes -= known;
  stats_.good_bytes += known;
  GnssMessage message;
  message.arrival = ArrivalOf(offset_ - std::min<std::uint64_t>(offset_, 1));
  const std::uint64_t behind = rtcm2_.stats().bytes - rtcm2.stream_end + rtcm2.stream_bytes;
  message.offset = offset_ - std::min(offset_, behind);
  message.body = &rtcm2;
  Deliver(message, sink);
  boundary_ = offset_;
}

void GnssStreamDecoder::AddMark(core::MonoTime arrival) {
  if (marks_begin_ != marks_end_ && marks_[(marks_end_ - 1) % kCapacity].arrival == arrival) return;
  // All held bytes may have come one at a time; marks before the first held byte are of no use any
  // more.
  ArrivalOf(offset_);
  marks_[marks_end_++ % kCapacity] = {offset_ + pending_bytes(), arrival};
}

core::MonoTime GnssStreamDecoder::ArrivalOf(std::uint64_t offset) {
  while (marks_end_ - marks_begin_ > 1 && marks_[(marks_begin_ + 1) % kCapacity].offset <= offset)
    ++marks_begin_;
  return marks_begin_ == marks_end_ ? core::MonoTime{} : marks_[marks_begin_ % kCapacity].arrival;
}

}  // namespace kawara::drivers
