// Lines of sentence bodies, each given its checksum and an arrival time: fixes only forward in
// time, finite, with a covariance that is one. A line "~" lets a second pass.
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "core/check.hpp"
#include "drivers/gnss_epoch.hpp"
#include "drivers/gnss_stream.hpp"

namespace {

using namespace kawara;

struct Checker : drivers::GnssStreamSink, drivers::GnssFixSink {
  void OnMessage(const drivers::GnssMessage& m) override { assembler.OnMessage(m, *this); }
  void OnFix(const core::GnssFix& fix) override {
    const std::uint64_t steps = assembler.stats().time_steps;
    CORE_CHECK(!last.IsSet() || fix.time > last || steps != last_steps);
    last = fix.time;
    last_steps = steps;
    if (fix.has_position) {
      CORE_CHECK(std::isfinite(fix.antenna.lat_rad) && std::isfinite(fix.antenna.lon_rad));
      CORE_CHECK(std::isfinite(fix.antenna.h_ellipsoidal_m));
      CORE_CHECK(fix.position_cov_enu_m2.allFinite() &&
                 fix.position_cov_enu_m2.diagonal().minCoeff() > 0.0);
    }
    CORE_CHECK(!fix.has_velocity || fix.velocity_enu_mps.allFinite());
    CORE_CHECK(!fix.has_heading || std::abs(fix.heading_rad) <= core::kPi);
  }
  drivers::GnssEpochAssembler assembler{{}};
  core::GpsTime last;
  std::uint64_t last_steps = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  const auto decoder = std::make_unique<drivers::GnssStreamDecoder>();
  Checker checker;
  core::MonoTime now = core::MonoTime::FromNs(1);
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    if (line == "~") {
      now += core::Seconds(1);
      checker.assembler.Tick(now, checker);
      continue;
    }
    now += core::Milliseconds(10);
    constexpr std::string_view kHex = "0123456789ABCDEF";
    const std::uint8_t sum = drivers::NmeaChecksum(line);
    const std::string text =
        "$" + std::string(line) + "*" + kHex[sum >> 4] + kHex[sum & 15U] + "\r\n";
    decoder->Feed(now, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}, checker);
  }
  decoder->Finish(checker);
  checker.assembler.Finish(checker);
  return 0;
}
