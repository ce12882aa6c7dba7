#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kawara::drivers {

/// Frame: 0xD3 | 6 reserved bits | 10-bit length | payload 0..1023 | CRC-24Q over all before it.
/// Source: RTCM 10403, transport layer.
constexpr std::uint8_t kRtcm3Preamble = 0xD3;
constexpr std::size_t kRtcm3HeaderBytes = 3;
constexpr std::size_t kRtcm3CrcBytes = 3;
constexpr std::size_t kRtcm3MaxFrameBytes = kRtcm3HeaderBytes + 1023 + kRtcm3CrcBytes;

enum class Rtcm3Match : std::uint8_t {
  kNoMatch,   ///< head[0] is no preamble, or there is no byte at all
  kNeedMore,  ///< may become a frame: come back when `length` bytes are there
  kFrame,     ///< head[0, length) is a whole frame with the right CRC
  kBadCrc,  ///< head[0, length) is complete but its CRC is wrong: go on ONE byte after the preamble
};
struct Rtcm3ProbeResult {
  Rtcm3Match match = Rtcm3Match::kNoMatch;
  std::size_t length =
      0;  ///< frame bytes known to be needed: 3 until the length field is there; 0 for kNoMatch
};

/// Looks whether a frame begins at head[0]. Pure. The six reserved bits may have any value: they
/// are covered by the CRC, and demanding zero would reject a future use. Real-time safe.
Rtcm3ProbeResult Rtcm3Probe(std::span<const std::uint8_t> head) noexcept;

/// Payload of a frame that Rtcm3Probe called kFrame.
inline std::span<const std::uint8_t> Rtcm3Payload(std::span<const std::uint8_t> frame) {
  return frame.subspan(kRtcm3HeaderBytes, frame.size() - kRtcm3HeaderBytes - kRtcm3CrcBytes);
}

/// Cuts a byte stream that carries RTCM 3 and perhaps other things into frames.
///   while (auto frame = framer.Next(bytes)) Use(*frame);
/// Next() takes bytes off the front of `bytes` until a frame is complete (the span is shortened) or
/// all are used up (no value). Any split of the stream gives the same frames. A false preamble
/// (0xD3 is an ordinary byte in payloads and text) costs nothing but its own byte: the search
/// resumes one byte later over the bytes held. The frame returned is valid until the next call. No
/// allocation. One thread.
class Rtcm3Framer {
 public:
  struct Stats {
    std::uint64_t frames = 0;
    std::uint64_t bad_crc = 0;  ///< preambles whose claimed frame failed; most are false preambles
    std::uint64_t frame_bytes = 0;    ///< bytes inside good frames
    std::uint64_t skipped_bytes = 0;  ///< bytes outside good frames, decided so far
  };

  std::optional<std::span<const std::uint8_t>> Next(std::span<const std::uint8_t>& bytes) noexcept;
  /// Forgets a frame begun (after a gap in the stream); the held bytes count as skipped.
  void Reset() noexcept;
  /// Bytes held that are not yet decided.
  std::size_t pending_bytes() const { return end_ - begin_; }
  const Stats& stats() const { return stats_; }

 private:
  std::array<std::uint8_t, 2 * kRtcm3MaxFrameBytes> held_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  Stats stats_;
};

}  // namespace kawara::drivers
