// Bytes as a stream (framing must not depend on the split) and as one payload with a good CRC (so
// that the decoder behind the CRC is reached too).
#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include "drivers/crc24q.hpp"
#include "drivers/rtcm3.hpp"

namespace {

using kawara::drivers::Rtcm3Framer;
using kawara::drivers::Rtcm3Message;

void Check(bool good) {
  if (!good) std::abort();
}

Rtcm3Framer::Stats Run(std::span<const std::uint8_t> bytes, std::size_t piece,
                       std::vector<std::uint8_t>& frames) {
  Rtcm3Framer framer;
  std::uint64_t fed = 0;
  while (!bytes.empty()) {
    auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    fed += part.size();
    while (const auto frame = framer.Next(part)) {
      frames.insert(frames.end(), frame->begin(), frame->end());
      (void)kawara::drivers::DecodeRtcm3(kawara::drivers::Rtcm3Payload(*frame));
    }
    const auto& s = framer.stats();
    Check(s.frame_bytes + s.skipped_bytes + framer.pending_bytes() == fed);
  }
  return framer.stats();
}

void Decode(std::span<const std::uint8_t> payload) {
  const Rtcm3Message m = kawara::drivers::DecodeRtcm3(payload);
  Check(m.length == payload.size());
  if (const auto* o = std::get_if<kawara::drivers::Rtcm3Observations>(&m.body)) {
    Check(o->satellites <= 64 && o->observations <= 64);
    (void)kawara::drivers::EpochOf(*o, kawara::core::GpsTime::FromNs(1'400'000'000'000'000'000));
  } else if (const auto* t = std::get_if<kawara::drivers::Rtcm3Text>(&m.body)) {
    Check(t->utf8.size() <= payload.size());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  std::vector<std::uint8_t> whole, pieces;
  const auto a = Run(bytes, SIZE_MAX, whole);
  const auto b = Run(bytes, 1 + size % 17, pieces);
  Check(whole == pieces && a.frames == b.frames && a.bad_crc == b.bad_crc &&
        a.skipped_bytes == b.skipped_bytes);
  Decode(bytes.first(std::min<std::size_t>(size, 1023)));
  return 0;
}
