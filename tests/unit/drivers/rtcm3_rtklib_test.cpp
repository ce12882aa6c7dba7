// Observation counts and epochs against RTKLIB's own decoder, loaded at run time (Debian:
// librtklib-dev, which has no header: the few leading members of its rtcm_t that are used here are
// declared below).
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <ctime>
#include <memory>

#include "corrections_data.hpp"
#include "drivers/ntrip_decoder.hpp"
#include "drivers/rtcm2_decoder.hpp"
#include "drivers/rtcm3.hpp"

namespace kawara::drivers {
namespace {

struct RtklibTime {
  std::time_t seconds;  ///< of GPS time, counted as UNIX time
  double fraction;
};
struct RtklibState {
  int station, height, sequence, output;
  RtklibTime time, sent;
  int observations, observations_max;
  void* data;
};
constexpr std::size_t kStateBytes = std::size_t{64} << 20;  // far more than any version needs
constexpr std::time_t kGpsEpochAsUnix = 315964800;
constexpr int kObservations = 1, kStation = 5;  // what input_rtcm3 returns

class Rtklib : public ::testing::Test {
 protected:
  void SetUp() override {
    library_ = ::dlopen("libRTKLib.so.1", RTLD_LAZY | RTLD_LOCAL);
    if (library_ == nullptr) GTEST_SKIP() << "librtklib1 is not installed";
    memory_.reset(static_cast<RtklibState*>(std::calloc(1, kStateBytes)));
    using Init = int (*)(void*);
    ASSERT_EQ(reinterpret_cast<Init>(::dlsym(library_, "init_rtcm"))(memory_.get()), 1);
  }
  void TearDown() override {
    if (library_ == nullptr) return;
    using Free = void (*)(void*);
    reinterpret_cast<Free>(::dlsym(library_, "free_rtcm"))(memory_.get());
  }
  using Input = int (*)(void*, unsigned char);
  Input Function(const char* name) { return reinterpret_cast<Input>(::dlsym(library_, name)); }
  void SetTime(core::GpsTime t) {
    memory_->time.seconds = kGpsEpochAsUnix + t.ns() / 1'000'000'000;
  }
  core::GpsTime Time() const {
    return core::GpsTime::FromNs((memory_->time.seconds - kGpsEpochAsUnix) * 1'000'000'000 +
                                 std::llround(memory_->time.fraction * 1e9));
  }

  struct FreeMemory {
    void operator()(void* p) const { std::free(p); }
  };
  void* library_ = nullptr;
  std::unique_ptr<RtklibState, FreeMemory> memory_;
};

struct Epoch {
  core::GpsTime time;
  int satellites = 0;
  bool operator==(const Epoch&) const = default;
};
std::ostream& operator<<(std::ostream& os, const Epoch& e) {
  return os << e.time.ns() << ":" << e.satellites;
}

/// Ours: satellites of all messages up to the one that says no more follow.
std::vector<Epoch> OurEpochs(const testing::Bytes& stream, core::GpsTime reference, int* stations) {
  std::vector<Epoch> epochs;
  Epoch open;
  std::span<const std::uint8_t> rest(stream);
  Rtcm3Framer framer;
  while (const auto frame = framer.Next(rest)) {
    const Rtcm3Message m = DecodeRtcm3(Rtcm3Payload(*frame));
    *stations += std::holds_alternative<Rtcm3Station>(m.body) ? 1 : 0;
    const auto* o = std::get_if<Rtcm3Observations>(&m.body);
    if (o == nullptr) continue;
    open.time = EpochOf(*o, reference).value();
    open.satellites += o->satellites;
    if (o->more_follow) continue;
    epochs.push_back(open);
    open = {};
  }
  return epochs;
}

TEST_F(Rtklib, EpochsAndSatellitesOfTestglo) {
  const auto stream = testing::ReadRecording("testglo.rtcm3");
  const core::GpsTime reference = core::FromWeek({1562, core::Seconds(515'400)});
  SetTime(reference);
  std::vector<Epoch> theirs;
  int their_stations = 0;
  const Input input = Function("input_rtcm3");
  for (const std::uint8_t byte : stream) {
    const int what = input(memory_.get(), byte);
    if (what == kObservations) theirs.push_back({Time(), memory_->observations});
    if (what == kStation) ++their_stations;
  }
  int stations = 0;
  EXPECT_EQ(OurEpochs(stream, reference, &stations), theirs);
  EXPECT_EQ(theirs.size(), 186U);
  EXPECT_EQ(stations, their_stations);
}

TEST_F(Rtklib, EpochsAndSatellitesOfMsm7) {
  const auto body = testing::ReadRecording("ntrip_encode_chunked.bin");
  const auto head = std::string(
      "HTTP/1.1 200 OK\r\nContent-Type: gnss/data\r\nTransfer-Encoding: chunked\r\n\r\n");
  testing::Bytes answer(head.begin(), head.end());
  testing::Append(answer, body);
  testing::Bytes stream;
  NtripDecoder ntrip;
  std::span<const std::uint8_t> rest(answer);
  while (const auto payload = ntrip.Next(rest)) testing::Append(stream, *payload);

  const core::GpsTime reference = core::FromWeek({2258, core::Seconds(302'400)});
  SetTime(reference);
  std::vector<Epoch> theirs;
  const Input input = Function("input_rtcm3");
  for (const std::uint8_t byte : stream) {
    if (input(memory_.get(), byte) == kObservations)
      theirs.push_back({Time(), memory_->observations});
  }
  int stations = 0;
  const auto ours = OurEpochs(stream, reference, &stations);
  ASSERT_EQ(ours.size(), theirs.size());
  EXPECT_GE(theirs.size(), 30U);
  EXPECT_EQ(ours, theirs);
}

TEST_F(Rtklib, EpochsOfRtcm2) {
  const auto stream = testing::ReadRecording("testglo.rtcm2");
  const core::GpsTime reference = core::FromWeek({1562, core::Seconds(515'500)});
  SetTime(reference);
  int theirs = 0, ours = 0;
  const Input input = Function("input_rtcm2");
  for (const std::uint8_t byte : stream)
    theirs += input(memory_.get(), byte) == kObservations ? 1 : 0;
  Rtcm2Decoder decoder;
  std::span<const std::uint8_t> rest(stream);
  while (const Rtcm2Message* m = decoder.Next(rest)) {
    const auto* o = std::get_if<Rtcm2Observations>(&m->body);
    ours += o != nullptr && !o->more_follow ? 1 : 0;
  }
  EXPECT_EQ(theirs, 186);
  EXPECT_EQ(ours, theirs);
}

}  // namespace
}  // namespace kawara::drivers
