#pragma once
#include <cstdio>
#include <string>
#include <vector>

#include "drivers/gnss_epoch.hpp"
#include "tests/support/gnss_recording.hpp"

namespace kawara::testing {

/// Stream decoder and assembler behind each other, as on the robot.
class Chain : public drivers::GnssStreamSink, public drivers::GnssFixSink {
 public:
  explicit Chain(const drivers::GnssEpochConfig& config = {}) : assembler(config) {}

  void Feed(std::int64_t arrival_ms, const Bytes& bytes) {
    decoder_.Feed(core::MonoTime() + core::Milliseconds(arrival_ms), bytes, *this);
  }
  void Feed(std::int64_t arrival_ms, const std::string& body) {
    Feed(arrival_ms, ToBytes(Sentence(body)));
  }
  void Tick(std::int64_t now_ms) {
    assembler.Tick(core::MonoTime() + core::Milliseconds(now_ms), *this);
  }
  void Finish() {
    decoder_.Finish(*this);
    assembler.Finish(*this);
  }
  void OnMessage(const drivers::GnssMessage& m) override { assembler.OnMessage(m, *this); }
  void OnFix(const core::GnssFix& fix) override { fixes.push_back(fix); }

  drivers::GnssEpochAssembler assembler;
  std::vector<core::GnssFix> fixes;

 private:
  drivers::GnssStreamDecoder decoder_;
};

inline std::vector<core::GnssFix> FixesOf(const std::string& recording,
                                          const drivers::GnssEpochConfig& config = {}) {
  Chain chain(config);
  chain.Feed(0, LoadRecording(recording));
  chain.Finish();
  return chain.fixes;
}

inline std::string Hms(std::int64_t tenths) {
  char text[16];
  std::snprintf(text, sizeof(text), "%02d%02d%02d.%d0", static_cast<int>(tenths / 36000 % 24),
                static_cast<int>(tenths / 600 % 60), static_cast<int>(tenths / 10 % 60),
                static_cast<int>(tenths % 10));
  return text;
}
constexpr std::int64_t kNoon = 12 * 36000;

inline std::string Gga(std::int64_t tenths, const std::string& quality = "4") {
  return "GPGGA," + Hms(tenths) + ",3510.0000000,N,13658.0000000,E," + quality +
         ",09,0.9,50.000,M,37.500,M,1.0,0001";
}
inline std::string Rmc(std::int64_t tenths, const std::string& date = "200626") {
  return "GPRMC," + Hms(tenths) + ",A,3510.0000000,N,13658.0000000,E,2.00,090.0," + date + ",,,A";
}
inline std::string Gst(std::int64_t tenths) {
  return "GPGST," + Hms(tenths) + ",0.01,0.030,0.010,45.0,0.022,0.022,0.040";
}

/// GPS time of a civil UTC time in 2026.
inline core::GpsTime Utc(int month, int day, int hour, int minute, int second,
                         int millisecond = 0) {
  return core::ToGps(
      core::FromCivil({2026, month, day, hour, minute, second, millisecond * 1'000'000}));
}

}  // namespace kawara::testing
