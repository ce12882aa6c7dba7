// Any bytes in any split into the SICK decoder; with an odd first byte the CRCs of what looks like
// telegrams are made right first, so that what lies behind the check is reached.
#include <cstdint>
#include <vector>

#include "core/check.hpp"
#include "drivers/sick.hpp"

namespace {

using namespace kawara;
using namespace kawara::drivers;

struct Sink : SickSink {
  std::vector<std::uint32_t> seen;
  void OnScan(const SickScan& scan) override {
    CORE_CHECK(scan.size <= kSickMaxPoints);
    double sum = 0.0;
    for (std::size_t i = 0; i < scan.size; ++i)
      sum += scan.RangeM(i) + scan.AngleRad(i) + scan.Flags(i);
    CORE_CHECK(sum >= 0.0);
    seen.push_back(static_cast<std::uint32_t>(scan.size));
  }
  void OnMessage(const SickMessage& message) override {
    seen.push_back(0x10000U | message.command);
  }
  void OnAcknowledge(core::MonoTime, bool accepted) override {
    seen.push_back(accepted ? 0x20000U : 0x30000U);
  }
};

void MendCrcs(std::vector<std::uint8_t>& bytes) {
  for (std::size_t at = 0; at + kSickOverheadBytes < bytes.size(); ++at) {
    if (bytes[at] != kSickStx || (bytes[at + 1] & 0x7FU) != 0) continue;
    const std::size_t body = 4U + bytes[at + 2] + 256U * bytes[at + 3];
    if (body <= 4 || at + body + 2 > bytes.size()) continue;
    const std::uint16_t crc = SickCrc(std::span(bytes).subspan(at, body));
    bytes[at + body] = static_cast<std::uint8_t>(crc & 0xFFU);
    bytes[at + body + 1] = static_cast<std::uint8_t>(crc >> 8);
    at += body + 1;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::size_t step = 1U + data[1];
  SickConfig config;
  config.decode_requests = (data[0] & 2U) != 0;
  config.range_bits = 13 + ((data[0] >> 2) & 3);
  std::vector<std::uint8_t> bytes(data + 2, data + size);
  if ((data[0] & 1U) != 0) MendCrcs(bytes);

  SickDecoder split(config), whole(config);
  Sink split_sink, whole_sink;
  const core::MonoTime now = core::MonoTime::FromNs(1'000'000'000);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    split.Feed(now,
               std::span<const std::uint8_t>(bytes).subspan(at, std::min(step, bytes.size() - at)),
               split_sink);
  }
  split.Finish(split_sink);
  whole.Feed(now, bytes, whole_sink);
  whole.Finish(whole_sink);
  CORE_CHECK(split_sink.seen == whole_sink.seen);
  const SickStats& s = split.stats();
  CORE_CHECK(s.telegram_bytes + s.acks + s.naks + s.skipped_bytes == bytes.size());
  return 0;
}
