#pragma once
#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "drivers/ahrs400.hpp"
#include "tests/unit/drivers/ahrs400_bytes.hpp"

namespace kawara::drivers::testing {

/// Keeps all a decoder hands out.
struct Collector : Ahrs400Sink {
  std::vector<core::AhrsSample> samples;
  std::vector<Ahrs400Mode> modes;
  std::vector<Ahrs400Voltages> voltages;
  std::vector<std::string> versions;
  std::vector<std::uint32_t> serials;
  int frozen = 0;
  void OnSample(const core::AhrsSample& s, Ahrs400Mode m) override {
    samples.push_back(s);
    modes.push_back(m);
  }
  void OnVoltages(const Ahrs400Voltages& v) override { voltages.push_back(v); }
  void OnFrozen(core::MonoTime, Ahrs400Mode) override { ++frozen; }
  void OnVersion(std::string_view t) override { versions.emplace_back(t); }
  void OnSerialNumber(std::uint32_t n) override { serials.push_back(n); }
  std::vector<std::uint16_t> Counters() const {
    std::vector<std::uint16_t> all;
    for (const auto& s : samples) all.push_back(s.counter);
    return all;
  }
};

inline const core::MonoTime kStart = core::MonoTime::FromNs(5'000'000'000);

/// Feeds pieces of `step` bytes, dated as the wire would.
inline Collector Decode(const Bytes& bytes, std::size_t step = 1U << 20,
                        const Ahrs400Config& config = {}, Ahrs400Stats* stats = nullptr) {
  Collector sink;
  Ahrs400Decoder decoder(config);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    const std::size_t n = std::min(step, bytes.size() - at);
    decoder.Feed(kStart + static_cast<std::int64_t>(at) * config.byte_time,
                 std::span(bytes).subspan(at, n), sink);
  }
  decoder.Finish(sink);
  if (stats != nullptr) *stats = decoder.stats();
  return sink;
}

}  // namespace kawara::drivers::testing
