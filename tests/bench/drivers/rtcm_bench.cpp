// Cost per byte of the RTCM decoders on recorded streams and on noise, and RTKLIB's
// input_rtcm3/input_rtcm2 on the same bytes in the same run (its library is loaded if it is
// installed: librtklib1). RTKLIB decodes observations in full; ours stop at headers and counts, so
// the ratio is the price of what the real-time path needs, not a race.
#include <benchmark/benchmark.h>
#include <dlfcn.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "drivers/crc24q.hpp"
#include "drivers/rtcm2_decoder.hpp"
#include "drivers/rtcm3.hpp"

namespace {

using namespace kawara::drivers;
using Bytes = std::vector<std::uint8_t>;
constexpr std::size_t kRead = 256;  // what a serial read brings at most

Bytes Recording(const std::string& name) {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/data/gnss/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}
Bytes Noise(std::uint8_t keep, std::uint8_t set) {
  Bytes bytes(std::size_t{16} << 20);
  std::uint64_t random = 88172645463325252ULL;
  for (auto& byte : bytes) {
    random ^= random << 13;
    random ^= random >> 7;
    random ^= random << 17;
    byte = static_cast<std::uint8_t>(((random >> 32) & keep) | set);
  }
  return bytes;
}

void RunRtcm3(benchmark::State& state, const Bytes& stream) {
  Rtcm3Framer framer;
  for (auto _ : state) {
    for (std::size_t i = 0; i < stream.size(); i += kRead) {
      auto piece = std::span(stream).subspan(i, std::min(kRead, stream.size() - i));
      while (const auto frame = framer.Next(piece))
        benchmark::DoNotOptimize(DecodeRtcm3(Rtcm3Payload(*frame)));
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
  state.counters["messages"] =
      static_cast<double>(framer.stats().frames) / static_cast<double>(state.iterations());
}
void RunRtcm2(benchmark::State& state, const Bytes& stream) {
  Rtcm2Decoder decoder;
  for (auto _ : state) {
    for (std::size_t i = 0; i < stream.size(); i += kRead) {
      auto piece = std::span(stream).subspan(i, std::min(kRead, stream.size() - i));
      while (const Rtcm2Message* m = decoder.Next(piece)) benchmark::DoNotOptimize(m->type);
    }
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
  state.counters["messages"] =
      static_cast<double>(decoder.stats().messages) / static_cast<double>(state.iterations());
}

void Rtcm3Legacy(benchmark::State& state) { RunRtcm3(state, Recording("testglo.rtcm3")); }
void Rtcm3Msm7(benchmark::State& state) { RunRtcm3(state, Recording("ntrip_encode_chunked.bin")); }
void Rtcm3Noise(benchmark::State& state) { RunRtcm3(state, Noise(0xFF, 0)); }
void Rtcm2Recorded(benchmark::State& state) { RunRtcm2(state, Recording("testglo.rtcm2")); }
void Rtcm2Noise(benchmark::State& state) { RunRtcm2(state, Noise(0xFF, 0)); }
void Rtcm2NoiseAllData(benchmark::State& state) { RunRtcm2(state, Noise(0x3F, 0x40)); }
BENCHMARK(Rtcm3Legacy);
BENCHMARK(Rtcm3Msm7);
BENCHMARK(Rtcm3Noise);
BENCHMARK(Rtcm2Recorded);
BENCHMARK(Rtcm2Noise);
BENCHMARK(Rtcm2NoiseAllData);

void Crc24qOfALongFrame(benchmark::State& state) {
  const Bytes frame(1029, 0x5A);
  for (auto _ : state) benchmark::DoNotOptimize(Crc24q(frame));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(frame.size()));
}
BENCHMARK(Crc24qOfALongFrame);

/// rtcm_t is opaque here but for its first members; 64 MB is more than any version of it needs.
struct RtklibHead {
  int station, height, sequence, output;
  std::time_t seconds;
};
void RunRtklib(benchmark::State& state, const char* function, const std::string& file) {
  void* library = ::dlopen("libRTKLib.so.1", RTLD_LAZY | RTLD_LOCAL);
  if (library == nullptr) return state.SkipWithError("librtklib1 is not installed");
  const std::unique_ptr<void, void (*)(void*)> memory(std::calloc(1, std::size_t{64} << 20),
                                                      &std::free);
  reinterpret_cast<int (*)(void*)>(::dlsym(library, "init_rtcm"))(memory.get());
  static_cast<RtklibHead*>(memory.get())->seconds = 1260403800;  // within the recording's week
  const auto input = reinterpret_cast<int (*)(void*, unsigned char)>(::dlsym(library, function));
  const Bytes stream = Recording(file);
  std::int64_t epochs = 0;
  for (auto _ : state) {
    for (const std::uint8_t byte : stream) epochs += input(memory.get(), byte) == 1 ? 1 : 0;
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(stream.size()));
  state.counters["epochs"] = static_cast<double>(epochs) / static_cast<double>(state.iterations());
  reinterpret_cast<void (*)(void*)>(::dlsym(library, "free_rtcm"))(memory.get());
}
void RtklibRtcm3Legacy(benchmark::State& state) {
  RunRtklib(state, "input_rtcm3", "testglo.rtcm3");
}
void RtklibRtcm2Recorded(benchmark::State& state) {
  RunRtklib(state, "input_rtcm2", "testglo.rtcm2");
}
BENCHMARK(RtklibRtcm3Legacy);
BENCHMARK(RtklibRtcm2Recorded);

}  // namespace
