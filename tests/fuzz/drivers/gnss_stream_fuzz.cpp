// Any bytes, in one piece and in pieces: the same messages, and every byte accounted for.
#include <cstdint>
#include <vector>

#include "core/check.hpp"
#include "drivers/gnss_stream.hpp"

namespace {

using kawara::core::MonoTime;
using kawara::drivers::GnssMessage;
using kawara::drivers::GnssStreamDecoder;

struct Places : kawara::drivers::GnssStreamSink {
  void OnMessage(const GnssMessage& m) override {
    places.push_back(m.offset);
    places.push_back(m.bytes.size());
    places.push_back(m.body.index());
  }
  std::vector<std::uint64_t> places;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  static GnssStreamDecoder* whole = nullptr;  // large: 200 KB
  static GnssStreamDecoder* pieces = nullptr;
  delete whole;
  delete pieces;
  whole = new GnssStreamDecoder;
  pieces = new GnssStreamDecoder;
  Places a;
  whole->Feed(MonoTime::FromNs(1), bytes, a);
  whole->Finish(a);
  Places b;
  for (std::size_t at = 0; at < size;) {
    const std::size_t n = std::min<std::size_t>(size - at, 1 + data[at] % 16U);
    pieces->Feed(MonoTime::FromNs(1), bytes.subspan(at, n), b);
    at += n;
  }
  pieces->Finish(b);
  CORE_CHECK(a.places == b.places);
  for (const auto* decoder : {whole, pieces}) {
    const auto& s = decoder->stats();
    CORE_CHECK(s.good_bytes + s.bad_bytes + s.skipped_bytes == size);
    CORE_CHECK(decoder->pending_bytes() == 0);
  }
  CORE_CHECK(whole->stats().good == pieces->stats().good);
  CORE_CHECK(whole->stats().bad_checksum == pieces->stats().bad_checksum);
  CORE_CHECK(whole->stats().bad_bytes == pieces->stats().bad_bytes);
  return 0;
}
