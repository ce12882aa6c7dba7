// Cost of GNSS decoding on the real-time path, against RTKLIB on the same bytes in the same run,
// and on noise.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <cstring>
#include <ctime>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

#include "drivers/gnss_epoch.hpp"
#include "drivers/gnss_stream.hpp"

#ifdef KAWARA_HAVE_RTKLIB
// Debian's librtklib-dev has the library without a header: the four symbols used, as RTKLIB 2.4.3
// declares them. The two structures are only ever handed through, in room that is larger than they
// are.
extern "C" {
struct gtime_t {
  time_t time;
  double sec;
};
void initsolbuf(void* solbuf, int cyclic, int nmax);
void freesolbuf(void* solbuf);
int inputsol(std::uint8_t data, gtime_t ts, gtime_t te, double tint, int qflag, const void* opt,
             void* solbuf);
// What the library wants from its application: progress reports, here ignored.
int showmsg(const char*, ...) { return 0; }
void settspan(gtime_t, gtime_t) {}
void settime(gtime_t) {}
}
#endif

namespace {

using namespace kawara;
using Bytes = std::vector<std::uint8_t>;

Bytes Recording(const std::string& name) {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/data/gnss/" + name, std::ios::binary);
  Bytes bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::size_t begin = 0;
  while (begin < bytes.size() && bytes[begin] == '#') {
    while (begin < bytes.size() && bytes[begin] != '\n') ++begin;
    ++begin;
  }
  return {bytes.begin() + static_cast<std::ptrdiff_t>(begin), bytes.end()};
}

struct Ignore : drivers::GnssStreamSink, drivers::GnssFixSink {
  void OnMessage(const drivers::GnssMessage& m) override { benchmark::DoNotOptimize(&m); }
  void OnFix(const core::GnssFix& f) override { benchmark::DoNotOptimize(&f); }
};

void Report(benchmark::State& state, std::size_t bytes, std::size_t messages) {
  state.SetBytesProcessed(static_cast<std::int64_t>(bytes) * state.iterations());
  state.SetItemsProcessed(static_cast<std::int64_t>(messages) * state.iterations());
}

constexpr const char* kNmea = "ublox-rtk-fixed.nmea";
constexpr std::size_t kNmeaSentences = 240;

void BM_NmeaKawara(benchmark::State& state) {
  const Bytes bytes = Recording(kNmea);
  drivers::GnssStreamDecoder decoder;
  Ignore sink;
  for (auto _ : state) decoder.Feed(core::MonoTime::FromNs(1), bytes, sink);
  if (decoder.stats().good != kNmeaSentences * static_cast<std::uint64_t>(state.iterations()))
    state.SkipWithError("messages lost");
  Report(state, bytes.size(), kNmeaSentences);
}
BENCHMARK(BM_NmeaKawara);

void BM_NmeaKawaraByteByByte(benchmark::State& state) {
  const Bytes bytes = Recording(kNmea);
  drivers::GnssStreamDecoder decoder;
  Ignore sink;
  for (auto _ : state) {
    for (const std::uint8_t& b : bytes) decoder.Feed(core::MonoTime::FromNs(1), {&b, 1}, sink);
  }
  Report(state, bytes.size(), kNmeaSentences);
}
BENCHMARK(BM_NmeaKawaraByteByByte);

void BM_NmeaKawaraToFixes(benchmark::State& state) {
  const Bytes bytes = Recording(kNmea);
  struct Chain : Ignore {
    void OnMessage(const drivers::GnssMessage& m) override { assembler.OnMessage(m, *this); }
    drivers::GnssEpochAssembler assembler{{}};
  };
  drivers::GnssStreamDecoder decoder;
  for (auto _ : state) {
    Chain chain;
    decoder.Feed(core::MonoTime::FromNs(1), bytes, chain);
    chain.assembler.Finish(chain);
    if (chain.assembler.stats().fixes != kNmeaSentences / 2) state.SkipWithError("fixes lost");
  }
  Report(state, bytes.size(), kNmeaSentences);
}
BENCHMARK(BM_NmeaKawaraToFixes);

#ifdef KAWARA_HAVE_RTKLIB
void BM_NmeaRtklib(benchmark::State& state) {
  const Bytes bytes = Recording(kNmea);
  std::vector<std::uint64_t> solution_buffer(16 * 1024);  // solbuf_t has some 8.5 KB
  std::vector<std::uint64_t> options(1024);               // solopt_t has some 400 bytes
  constexpr int kNmeaFormat = 3;                          // SOLF_NMEA; `posf` is the first member
  std::memcpy(options.data(), &kNmeaFormat, sizeof(kNmeaFormat));
  int solutions = 0;
  for (auto _ : state) {
    state.PauseTiming();
    initsolbuf(solution_buffer.data(), 0, 0);
    state.ResumeTiming();
    int n = 0;
    for (const std::uint8_t b : bytes)
      n += inputsol(b, {}, {}, 0.0, 0, options.data(), solution_buffer.data()) > 0 ? 1 : 0;
    solutions = n;
    state.PauseTiming();
    freesolbuf(solution_buffer.data());
    state.ResumeTiming();
  }
  if (solutions < 100) state.SkipWithError("RTKLIB found no solutions");
  state.counters["solutions"] = solutions;
  Report(state, bytes.size(), kNmeaSentences);
}
BENCHMARK(BM_NmeaRtklib);
#endif

/// The mixed binary and text stream of an Ashtech receiver.
void BM_Ac12(benchmark::State& state) {
  const Bytes bytes = Recording("ac12_binary.log");
  drivers::GnssStreamDecoder decoder;
  Ignore sink;
  for (auto _ : state) decoder.Feed(core::MonoTime::FromNs(1), bytes, sink);
  Report(state, bytes.size(), 64);
}
BENCHMARK(BM_Ac12);

/// Noise through all probes at once: NMEA, PBN, u-blox, RTCM 3 and RTCM 2.
void BM_Noise(benchmark::State& state) {
  std::mt19937 random(1);
  Bytes bytes(16U << 20);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  Ignore sink;
  for (auto _ : state) {
    drivers::GnssStreamDecoder decoder;
    decoder.Feed(core::MonoTime::FromNs(1), bytes, sink);
    if (decoder.stats().good != 0) state.SkipWithError("noise taken for a message");
  }
  Report(state, bytes.size(), 0);
}
BENCHMARK(BM_Noise)->Unit(benchmark::kMillisecond);

/// Noise after RTCM 3 was seen: every 0xD3 costs a CRC over half a kilobyte.
void BM_NoiseAfterRtcm3(benchmark::State& state) {
  const Bytes rtcm3 = Recording("rtcm3.log");
  std::mt19937 random(1);
  Bytes bytes(16U << 20);
  for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random());
  drivers::GnssStreamDecoder decoder;
  Ignore sink;
  decoder.Feed(core::MonoTime::FromNs(1), rtcm3, sink);
  for (auto _ : state) decoder.Feed(core::MonoTime::FromNs(1), bytes, sink);
  Report(state, bytes.size(), 0);
}
BENCHMARK(BM_NoiseAfterRtcm3)->Unit(benchmark::kMillisecond);

}  // namespace
