#include "sim/instruments/ahrs400.hpp"

#include <algorithm>
#include <cmath>

namespace kawara::sim {
namespace {

constexpr double kTick_s = 0.79e-6;
constexpr std::uint64_t kClockStepTicks = 20000;
constexpr std::string_view kVersionText = "AHRS400CC-100 SIM 1.0";
constexpr std::string_view kVersionText200 = "AHRS400CD-200 SIM 1.0";

}  // namespace

Ahrs400::Ahrs400(const std::vector<AhrsState>& trace, const SimClock& clock, core::GpsTime begin,
                 core::GpsTime end, const Ahrs400Options& options)
    : trace_(trace),
      clock_(clock),
      end_(end),
      options_(options),
      encoder_(options.ranges),
      transmitter_(options.baud_bps),
      continuous_(options.already_streaming),
      next_(static_cast<std::size_t>(
          std::lower_bound(trace.begin(), trace.end(), begin,
                           [](const AhrsState& state, core::GpsTime t) { return state.time < t; }) -
          trace.begin())) {}

std::uint16_t Ahrs400::CounterAt(core::MonoTime t) const {
  // A double of seconds since boot still resolves 4 ns after a year.
  const double rate = (1.0 + options_.counter_skew_ppm * 1e-6) / kTick_s;
  const auto ticks =
      static_cast<std::uint64_t>(std::floor(core::ToSeconds(t - core::MonoTime{}) * rate)) +
      (clock_step_ ? kClockStepTicks : 0U);
  return static_cast<std::uint16_t>(0xFFFFU - (ticks & 0xFFFFU));
}

void Ahrs400::Reply(core::MonoTime now, char byte) {
  const auto value = static_cast<std::uint8_t>(byte);
  transmitter_.Send(now, {&value, 1});
}

void Ahrs400::SendPacket(core::MonoTime at, std::size_t index) {
  const std::vector<std::uint8_t> packet = encoder_.Packet(
      output_, trace_[index], options_.temperature_degc, CounterAt(SampledAt(index)));
  if (transmitter_.Send(at, packet)) ++counters_.packets;
}

void Ahrs400::Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) {
  for (const std::uint8_t byte : bytes) Obey(now, byte);
}

void Ahrs400::Obey(core::MonoTime now, std::uint8_t command) {
  ++counters_.commands;
  switch (command) {
    case 'R':
      continuous_ = false;  // observed on a real unit: after a ping it is in polled mode
      Reply(now, 'H');
      break;
    case 'r':
      output_ = Ahrs400Output::kVoltage;
      Reply(now, 'R');
      break;
    case 'c':
      output_ = Ahrs400Output::kScaled;
      Reply(now, 'C');
      break;
    case 'a':
      output_ = Ahrs400Output::kAngle;
      Reply(now, 'A');
      break;
    case 'b':
      Reply(now, 'B');
      break;
    case 'P':
      continuous_ = false;
      break;
    case 'C':
      continuous_ = true;
      break;
    case 'G':
      continuous_ = false;
      if (newest_) {
        SendPacket(now, *newest_);
      } else {
        polled_ = true;
      }
      break;
    case 'v': {
      const std::vector<std::uint8_t> reply = Ahrs400Encoder::Version(
          options_.ranges.rate_degps > 150.0 ? kVersionText200 : kVersionText);
      transmitter_.Send(now, reply);
      break;
    }
    case 'S':
      transmitter_.Send(now, Ahrs400Encoder::SerialNumber(options_.serial_number));
      break;
    default:
      --counters_.commands;
      ++counters_.unknown_bytes;
  }
}

void Ahrs400::Advance(core::MonoTime now) {
  const core::Duration processing = core::DurationFromSeconds(options_.processing_s);
  for (; next_ < trace_.size() && trace_[next_].time <= end_; ++next_) {
    const core::MonoTime at = SampledAt(next_) + processing;
    if (at > now) return;
    newest_ = next_;
    ++counters_.samples;
    if (!continuous_ && !polled_) continue;
    if (transmitter_.FreeAt(at) > at) {
      ++counters_.skipped;
      continue;
    }
    polled_ = false;
    SendPacket(at, next_);
  }
}

core::MonoTime Ahrs400::NextEvent() const {
  if (next_ >= trace_.size() || trace_[next_].time > end_) return {};
  return SampledAt(next_) + core::DurationFromSeconds(options_.processing_s);
}

}  // namespace kawara::sim
