// Any bytes in any split, with any arrival times, into the AHRS400 decoder and its dialogue.
// Checked beside crashes: every byte is accounted for, stamps rise, and the split does not change
// what comes out.
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "core/check.hpp"
#include "drivers/ahrs400.hpp"
#include "drivers/ahrs400_dialogue.hpp"

namespace {

using namespace kawara;
using namespace kawara::drivers;

struct Sink : Ahrs400Sink {
  std::vector<std::uint16_t> counters;
  core::MonoTime last;
  Ahrs400Dialogue* dialogue = nullptr;
  core::MonoTime now;
  void OnSample(const core::AhrsSample& sample, Ahrs400Mode mode) override {
    counters.push_back(sample.counter);
    if (dialogue != nullptr) dialogue->OnPacket(now, mode, &sample);
  }
  void OnVersion(std::string_view text) override {
    counters.push_back(static_cast<std::uint16_t>(text[0]));
  }
};

std::uint64_t Accounted(const Ahrs400Stats& s) {
  return s.packets[0] * 30 + (s.packets[1] + s.packets[2]) * 24 + s.versions * 26 +
         s.serial_numbers * 6 + s.skipped_bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 2) return 0;
  const std::size_t step = 1U + data[0];
  const std::uint8_t pace = data[1];
  const std::span<const std::uint8_t> bytes(data + 2, size - 2);

  Ahrs400Decoder split, whole;
  Ahrs400Dialogue dialogue{Ahrs400DialogueConfig{}};
  Sink split_sink, whole_sink;
  split_sink.dialogue = &dialogue;
  core::MonoTime now = core::MonoTime::FromNs(1'000'000'000);
  dialogue.Start(now);
  for (std::size_t at = 0; at < bytes.size(); at += step) {
    const auto chunk = bytes.subspan(at, std::min(step, bytes.size() - at));
    now += core::Milliseconds(pace);
    split_sink.now = now;
    dialogue.OnBytes(now, chunk);
    split.Feed(now, chunk, split_sink);
    dialogue.Tick(now);
    for (Ahrs400Action action; dialogue.TryPopAction(action);) continue;
  }
  split.Finish(split_sink);
  whole.Feed(now, bytes, whole_sink);
  whole.Finish(whole_sink);
  CORE_CHECK(split_sink.counters == whole_sink.counters);
  CORE_CHECK(Accounted(split.stats()) == bytes.size());
  CORE_CHECK(Accounted(whole.stats()) == bytes.size());
  return 0;
}
