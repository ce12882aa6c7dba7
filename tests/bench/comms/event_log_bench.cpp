// The log reader and writer against liblcm's own, on the same file in the same run.
#include <benchmark/benchmark.h>
#include <lcm/eventlog.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <random>

#include "comms/crc32c.hpp"
#include "comms/event_log_reader.hpp"
#include "comms/event_log_writer.hpp"

namespace {

using namespace kawara;
using Blob = std::vector<std::uint8_t>;

// A drive's mixture: 100 small messages for every picture of `picture_bytes`.
std::filesystem::path WriteLog(const std::filesystem::path& path, std::size_t total_bytes,
                               std::size_t picture_bytes, bool crc) {
  std::filesystem::remove(path);
  std::mt19937 random(1);
  Blob small(200);
  Blob picture(picture_bytes);
  for (auto* blob : {&small, &picture}) {
    for (auto& byte : *blob) byte = static_cast<std::uint8_t>(random());
  }
  auto writer = comms::EventLogWriter::Create(
      path, {.sync_interval = core::Milliseconds(100), .fdatasync = false, .crc = crc});
  for (std::int64_t i = 0; writer && writer->bytes() < total_bytes; ++i) {
    const bool is_picture = i % 101 == 100;
    if (!writer->Append(i * 1000, is_picture ? "FRAME" : "RAW.AHRS", is_picture ? picture : small,
                        core::MonoTime::FromNs(i * 1'000'000)))
      std::abort();
  }
  if (!writer || !writer->Close()) std::abort();
  return path;
}

struct Files {
  std::filesystem::path folder;
  Files() {
    std::string pattern = (std::filesystem::temp_directory_path() / "kawara-bench-XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    WriteLog(folder / "crc", 256 << 20, 400'000, true);
    WriteLog(folder / "plain", 256 << 20, 400'000, false);
  }
  ~Files() { std::filesystem::remove_all(folder); }
};
const Files& TheFiles() {
  static const Files files;
  return files;
}

void ReadOurs(benchmark::State& state, const char* name) {
  const auto path = TheFiles().folder / name;
  std::int64_t bytes = 0;
  for (auto _ : state) {
    auto reader = comms::EventLogReader::Open({path});
    while (const auto event = reader->Next()) benchmark::DoNotOptimize(event->data.data());
    bytes += static_cast<std::int64_t>(reader->stats().bytes);
  }
  state.SetBytesProcessed(bytes);
}
BENCHMARK_CAPTURE(ReadOurs, with_crc, "crc")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ReadOurs, without_crc, "plain")->Unit(benchmark::kMillisecond);

void ReadLiblcm(benchmark::State& state) {
  const auto path = TheFiles().folder / "plain";
  std::int64_t bytes = 0;
  for (auto _ : state) {
    lcm_eventlog_t* log = lcm_eventlog_create(path.c_str(), "r");
    while (lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log)) {
      benchmark::DoNotOptimize(event->data);
      lcm_eventlog_free_event(event);
    }
    lcm_eventlog_destroy(log);
    bytes += static_cast<std::int64_t>(std::filesystem::file_size(path));
  }
  state.SetBytesProcessed(bytes);
}
BENCHMARK(ReadLiblcm)->Unit(benchmark::kMillisecond);

void WriteOurs(benchmark::State& state, bool crc) {
  for (auto _ : state) WriteLog(TheFiles().folder / "written", 64 << 20, 400'000, crc);
  state.SetBytesProcessed(state.iterations() * (64 << 20));
}
BENCHMARK_CAPTURE(WriteOurs, with_crc, true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(WriteOurs, without_crc, false)->Unit(benchmark::kMillisecond);

void WriteLiblcm(benchmark::State& state) {
  Blob small(200, 1);
  Blob picture(400'000, 2);
  std::string names[2] = {"RAW.AHRS", "FRAME"};
  for (auto _ : state) {
    lcm_eventlog_t* log = lcm_eventlog_create((TheFiles().folder / "written").c_str(), "w");
    std::size_t bytes = 0;
    for (std::int64_t i = 0; bytes < (64 << 20); ++i) {
      const bool is_picture = i % 101 == 100;
      Blob& data = is_picture ? picture : small;
      std::string& name = names[is_picture ? 1 : 0];
      lcm_eventlog_event_t event{};
      event.timestamp = i * 1000;
      event.channellen = static_cast<std::int32_t>(name.size());
      event.datalen = static_cast<std::int32_t>(data.size());
      event.channel = name.data();
      event.data = data.data();
      lcm_eventlog_write_event(log, &event);
      bytes += data.size() + name.size() + 28;
    }
    lcm_eventlog_destroy(log);
  }
  state.SetBytesProcessed(state.iterations() * (64 << 20));
}
BENCHMARK(WriteLiblcm)->Unit(benchmark::kMillisecond);

void Crc(benchmark::State& state, bool portable) {
  const Blob data(1 << 20, 7);
  for (auto _ : state) {
    benchmark::DoNotOptimize(portable ? comms::internal::Crc32cPortable(data, 0)
                                      : comms::Crc32c(data));
  }
  state.SetBytesProcessed(state.iterations() * (1 << 20));
}
BENCHMARK_CAPTURE(Crc, instruction, false);
BENCHMARK_CAPTURE(Crc, portable, true);

// A gigabyte of anything that is no log must not hold anybody up.
void SearchGarbage(benchmark::State& state) {
  const auto path = TheFiles().folder / "garbage";
  if (!std::filesystem::exists(path)) {
    Blob garbage(64 << 20);
    std::mt19937_64 random(3);
    for (std::size_t i = 0; i + 8 <= garbage.size(); i += 8) {
      const std::uint64_t word = random();
      std::memcpy(garbage.data() + i, &word, 8);
    }
    std::filesystem::copy(TheFiles().folder / "plain", path);
    std::FILE* file = std::fopen(path.c_str(), "r+b");
    std::fseek(file, 1000, SEEK_SET);
    std::fwrite(garbage.data(), 1, garbage.size(), file);
    std::fclose(file);
    std::filesystem::resize_file(path, garbage.size());
  }
  for (auto _ : state) {
    auto reader = comms::EventLogReader::Open({path});
    while (reader->Next()) {
    }
  }
  state.SetBytesProcessed(state.iterations() * (64 << 20));
}
BENCHMARK(SearchGarbage)->Unit(benchmark::kMillisecond);

}  // namespace
