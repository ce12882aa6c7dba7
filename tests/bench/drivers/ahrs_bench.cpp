// Attitude unit and laser on the real-time path: cost a byte of good data, and of the worst input
// there is, random garbage (a unit at the wrong baud rate). Allocations are counted in the unit
// tests.
#include <benchmark/benchmark.h>

#include <random>
#include <vector>

#include "drivers/ahrs400.hpp"
#include "drivers/sick.hpp"

namespace kawara::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes Garbage(std::size_t n) {
  std::mt19937 random(1);
  Bytes bytes(n);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
  return bytes;
}

/// Packets as a unit nearly at rest sends them: small numbers of both signs, so many header bytes
/// inside.
Bytes AnglePackets(int count) {
  std::mt19937 random(2);
  std::normal_distribution<double> small(0.0, 200.0);
  Bytes bytes;
  std::uint16_t counter = 0;
  for (int i = 0; i < count; ++i) {
    Bytes payload;
    counter = static_cast<std::uint16_t>(counter - 21097);
    for (int w = 0; w < 14; ++w) {
      const std::uint16_t word =
          w == 13   ? counter
          : w == 12 ? std::uint16_t{1500}
                    : static_cast<std::uint16_t>(static_cast<std::int16_t>(small(random)));
      payload.push_back(static_cast<std::uint8_t>(word >> 8));
      payload.push_back(static_cast<std::uint8_t>(word & 0xFFU));
    }
    bytes.push_back(kAhrs400Header);
    bytes.insert(bytes.end(), payload.begin(), payload.end());
    bytes.push_back(Ahrs400Checksum(payload));
  }
  return bytes;
}

Bytes Scans(int count) {
  Bytes bytes;
  for (int s = 0; s < count; ++s) {
    Bytes t{kSickStx, 0x80, 0xD6, 0x02, 0xB0, 0x69, 0x01};
    for (int i = 0; i < 361; ++i) {
      t.push_back(static_cast<std::uint8_t>(i * 7 + s));
      t.push_back(static_cast<std::uint8_t>(i % 16));
    }
    t.push_back(0x10);
    const std::uint16_t crc = SickCrc(t);
    t.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    t.push_back(static_cast<std::uint8_t>(crc >> 8));
    bytes.insert(bytes.end(), t.begin(), t.end());
  }
  return bytes;
}

/// Feeds all of `bytes` in chunks as a serial port hands them out; reports bytes/s and ns a byte.
template <class Decoder, class Sink>
void Run(benchmark::State& state, const Bytes& bytes, std::size_t chunk) {
  Decoder decoder;
  Sink sink;
  core::MonoTime now = core::MonoTime::FromNs(1'000'000'000);
  for (auto _ : state) {
    for (std::size_t at = 0; at < bytes.size(); at += chunk) {
      const std::size_t n = std::min(chunk, bytes.size() - at);
      decoder.Feed(now, std::span(bytes).subspan(at, n), sink);
      now += core::Nanoseconds(static_cast<std::int64_t>(n) * 260'417);
    }
  }
  const auto total = state.iterations() * static_cast<std::int64_t>(bytes.size());
  state.SetBytesProcessed(total);
  state.counters["per_byte"] = benchmark::Counter(
      static_cast<double>(total), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void AhrsPackets(benchmark::State& state) {
  Run<Ahrs400Decoder, Ahrs400Sink>(state, AnglePackets(2000),
                                   static_cast<std::size_t>(state.range(0)));
}
BENCHMARK(AhrsPackets)->Arg(1)->Arg(16)->Arg(4096);

void AhrsGarbage(benchmark::State& state) {
  Run<Ahrs400Decoder, Ahrs400Sink>(state, Garbage(1U << 22),
                                   static_cast<std::size_t>(state.range(0)));
}
BENCHMARK(AhrsGarbage)->Arg(16)->Arg(4096);

void AhrsHeadersOnly(benchmark::State& state) {
  Run<Ahrs400Decoder, Ahrs400Sink>(state, Bytes(1U << 20, kAhrs400Header),
                                   static_cast<std::size_t>(state.range(0)));
}
BENCHMARK(AhrsHeadersOnly)->Arg(4096);

void SickScans(benchmark::State& state) {
  Run<SickDecoder, SickSink>(state, Scans(50), static_cast<std::size_t>(state.range(0)));
}
BENCHMARK(SickScans)->Arg(1)->Arg(64)->Arg(4096);

void SickGarbage(benchmark::State& state) {
  Run<SickDecoder, SickSink>(state, Garbage(1U << 22), static_cast<std::size_t>(state.range(0)));
}
BENCHMARK(SickGarbage)->Arg(64)->Arg(4096);

}  // namespace
}  // namespace kawara::drivers
