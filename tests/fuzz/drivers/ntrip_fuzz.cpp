// An answer of a caster: payload, state and failure must not depend on the split.
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "drivers/ntrip_decoder.hpp"

namespace {

using namespace kawara::drivers;

void Check(bool good) {
  if (!good) std::abort();
}

struct Result {
  std::vector<std::uint8_t> payload;
  NtripState state;
  NtripFailure failure;
  std::size_t sources;
  std::string explanation;
  bool operator==(const Result&) const = default;
};

Result Run(std::span<const std::uint8_t> bytes, std::size_t piece, bool wants_table) {
  Result r{};
  NtripDecoder decoder(wants_table);
  while (!bytes.empty()) {
    auto part = bytes.first(std::min(piece, bytes.size()));
    bytes = bytes.subspan(part.size());
    while (const auto payload = decoder.Next(part)) {
      Check(!payload->empty());
      r.payload.insert(r.payload.end(), payload->begin(), payload->end());
    }
    Check(part.empty());
  }
  decoder.OnClosed();
  Check(decoder.state() == NtripState::kDone);
  NtripRequest request;
  request.host = "host";
  request.mountpoint = "MOUNT";
  r.state = decoder.state();
  r.failure = decoder.failure();
  r.sources = decoder.sources().size();
  r.explanation = decoder.Explain(request).message;
  return r;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const bool wants_table = (data[0] & 1) != 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  const Result whole = Run(bytes, SIZE_MAX, wants_table);
  Check(whole == Run(bytes, 1 + size % 11, wants_table));
  Check(whole == Run(bytes, 1, wants_table));
  return 0;
}
