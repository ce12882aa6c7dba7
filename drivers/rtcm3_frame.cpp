#include "drivers/rtcm3_frame.hpp"

#include <algorithm>
#include <cstring>

#include "drivers/crc24q.hpp"

namespace kawara::drivers {

Rtcm3ProbeResult Rtcm3Probe(std::span<const std::uint8_t> head) noexcept {
  if (head.empty() || head[0] != kRtcm3Preamble) return {};
  if (head.size() < kRtcm3HeaderBytes) return {Rtcm3Match::kNeedMore, kRtcm3HeaderBytes};
  const std::size_t payload = (static_cast<std::size_t>(head[1] & 0x03U) << 8) | head[2];
  const std::size_t length = kRtcm3HeaderBytes + payload + kRtcm3CrcBytes;
  if (head.size() < length) return {Rtcm3Match::kNeedMore, length};
  // The CRC of a frame together with its own CRC bytes is zero.
  const bool good = Crc24q(head.first(length)) == 0;
  return {good ? Rtcm3Match::kFrame : Rtcm3Match::kBadCrc, length};
}

std::optional<std::span<const std::uint8_t>> Rtcm3Framer::Next(
    std::span<const std::uint8_t>& bytes) noexcept {
  for (;;) {
    if (begin_ == end_) {
      begin_ = end_ = 0;
      const auto preamble = std::find(bytes.begin(), bytes.end(), kRtcm3Preamble);
      const auto skip = static_cast<std::size_t>(preamble - bytes.begin());
      stats_.skipped_bytes += skip;
      bytes = bytes.subspan(skip);
      if (bytes.empty()) return std::nullopt;
      // Whole frames inside the caller's bytes need no copy.
      const Rtcm3ProbeResult direct = Rtcm3Probe(bytes);
      if (direct.match == Rtcm3Match::kBadCrc) {
        ++stats_.bad_crc;
        ++stats_.skipped_bytes;
        bytes = bytes.subspan(1);
        continue;
      }
      if (direct.match == Rtcm3Match::kFrame) {
        ++stats_.frames;
        stats_.frame_bytes += direct.length;
        const auto frame = bytes.first(direct.length);
        bytes = bytes.subspan(direct.length);
        return frame;
      }
    }
    const std::span<const std::uint8_t> held(held_.data() + begin_, end_ - begin_);
    const Rtcm3ProbeResult result = held.empty()
                                        ? Rtcm3ProbeResult{Rtcm3Match::kNeedMore, kRtcm3HeaderBytes}
                                        : Rtcm3Probe(held);
    switch (result.match) {
      case Rtcm3Match::kFrame:
        ++stats_.frames;
        stats_.frame_bytes += result.length;
        begin_ += result.length;
        return held.first(result.length);
      case Rtcm3Match::kNeedMore: {
        if (bytes.empty()) return std::nullopt;
        if (begin_ + result.length > held_.size()) {
          std::memmove(held_.data(), held.data(), held.size());
          begin_ = 0;
          end_ = held.size();
        }
        const std::size_t take = std::min(result.length - held.size(), bytes.size());
        std::memcpy(held_.data() + end_, bytes.data(), take);
        end_ += take;
        bytes = bytes.subspan(take);
        break;
      }
      case Rtcm3Match::kBadCrc:
        ++stats_.bad_crc;
        [[fallthrough]];
      case Rtcm3Match::kNoMatch: {
        // Resume one byte later: at the next preamble among the bytes held.
        const auto next = std::find(held.begin() + 1, held.end(), kRtcm3Preamble);
        const auto skip = static_cast<std::size_t>(next - held.begin());
        stats_.skipped_bytes += skip;
        begin_ += skip;
        break;
      }
    }
  }
}

void Rtcm3Framer::Reset() noexcept {
  stats_.skipped_bytes += end_ - begin_;
  begin_ = end_ = 0;
}

}  // namespace kawara::drivers
