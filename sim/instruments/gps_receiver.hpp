#pragma once
#include <array>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/rtcm2_decoder.hpp"
#include "drivers/rtcm3_frame.hpp"
#include "sim/dice.hpp"
#include "sim/instruments/ashtech_settings.hpp"
#include "sim/instruments/gps_sentences.hpp"
#include "sim/instruments/serial_line.hpp"
#include "sim/motion/recording.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

struct GpsReceiverOptions {
  char port = 'A';      ///< which of the receiver's ports our cable is in
  int baud_bps = 9600;  ///< as saved in the receiver before the run
  bool streaming =
      false;  ///< saved with everything on and CPD working; else all output off, CPD off
  GgaQuality gga_quality = GgaQuality::kAshtechLegacy;
  double latency_s = 0.035;  ///< epoch to the first bit of the answer, least
  double latency_jitter_s =
      0.003;  ///< mean of what comes on top; one epoch in a hundred is 5 times this later
  /// The recorded RTK state holds only while corrections come in: without for `fix_age_s` float,
  /// beyond RTC,MAX autonomous. Off: the recording's own state, as if corrections came by another
  /// port.
  bool needs_corrections = false;
  double fix_age_s = 10.0;
  double refix_s = 0.0;  ///< float for so long once corrections come (again)
  std::uint64_t seed = 1;
};

/// A Z-Xtreme-like receiver that lives through a recorded drive: obeys the Ashtech commands, sends
/// its sentences for the recorded epochs with a latency, time-tags PPS pulses and camera triggers.
/// Without working CPD (see AshtechSettings::cpd_works) it gives an autonomous or code differential
/// solution: the recorded position plus slowly wandering errors of that size. Accepts RTCM 2.x and,
/// unlike the real one, RTCM 3 on its corrections port.
///
/// What the recording lacks is modelled: dilutions of precision from the number of satellites. One
/// thread, except AddEvent().
class GpsReceiver final : public SerialInstrument {
 public:
  /// `recording` and `clock` must outlive the receiver; epochs outside [begin, end] are not sent.
  GpsReceiver(const Recording& recording, const SimClock& clock, core::GpsTime begin,
              core::GpsTime end, const GpsReceiverOptions& options);

  UartTransmitter& transmitter() override { return transmitter_; }
  void Receive(core::MonoTime now, std::span<const std::uint8_t> bytes) override;
  void Advance(core::MonoTime now) override;
  core::MonoTime NextEvent() const override;

  /// A pulse at the event input (camera shutter). Any thread. Only the first one between two epochs
  /// counts.
  void AddEvent(core::MonoTime pulse);

  /// Edges of the PPS output since the last call: the exact instants of its seconds.
  std::vector<core::MonoTime> TakeEdges() { return std::exchange(edges_, {}); }
  /// When the next one comes; unset: none.
  core::MonoTime NextEdge() const;

  struct Faults {
    bool no_fix = false;
    bool bad_checksum = false;
    bool power_off = false;
    bool clock_step = false;  ///< time tags one second ahead
    bool no_pps = false;      ///< pulses are not reported
  };
  void SetFaults(const Faults& faults);

  struct Counters {
    std::uint64_t epochs = 0;  ///< passed, whether anything was switched on or not
    std::uint64_t sentences = 0;
    std::uint64_t commands = 0;
    std::uint64_t refused = 0;  ///< commands answered by NAK
    std::uint64_t rtcm_messages = 0;
    std::uint64_t events_suppressed = 0;
  };
  const Counters& counters() const { return counters_; }
  const AshtechSettings& settings() const { return settings_; }
  std::uint64_t dropped_messages() const { return transmitter_.dropped_messages(); }

 private:
  struct Pulse {
    core::MonoTime send_at;
    core::GpsTime time;
  };
  std::size_t own_port() const { return static_cast<std::size_t>(options_.port - 'A'); }
  bool IsOn(AshtechMessage message) const;
  AshtechSettings SavedAtStart() const;
  void ScheduleEpoch();
  /// The first one after that instant; empty: switched off, or the run is over.
  std::optional<core::GpsTime> PulseAfter(core::GpsTime after) const;
  void ScheduleReportOfPulse(core::GpsTime after);
  void RaiseEdges(core::MonoTime now);
  void TakeByte(core::MonoTime now, std::uint8_t byte);
  void Obey(core::MonoTime now, std::string_view line);
  void TakeCorrections(core::MonoTime now, std::span<const std::uint8_t> bytes);
  void TakePulses();
  core::GpsTime TimeTag(core::GpsTime t) const {
    return faults_.clock_step ? t + core::Seconds(1) : t;
  }
  core::RtkState StateNow(core::RtkState recorded, core::MonoTime now);
  GpsSolution Solve(const RecordedFix& fix, core::MonoTime now);
  void SendEpoch(core::MonoTime now);
  std::string Sentence(AshtechMessage message, const GpsSolution& solution) const;
  void Send(core::MonoTime now, std::string text);

  const Recording& recording_;
  const SimClock& clock_;
  core::GpsTime end_;
  GpsReceiverOptions options_;
  AshtechSettings settings_, saved_;
  UartTransmitter transmitter_;
  Dice dice_;
  Faults faults_;
  Counters counters_;

  std::size_t next_fix_ = 0;
  core::MonoTime epoch_due_{};  ///< unset: no more epochs
  core::Duration epoch_latency_{};
  std::int64_t last_nmea_slot_ = -1, last_raw_slot_ = -1;
  Eigen::Vector3d wander_ = Eigen::Vector3d::Zero();  ///< unit errors north, east, down
  std::optional<GpsSolution> last_;
  std::optional<Pulse> pps_;  ///< to be reported
  core::GpsTime last_edge_;
  std::vector<core::MonoTime> edges_;

  std::string line_;
  drivers::Rtcm2Decoder rtcm2_;
  drivers::Rtcm3Framer rtcm3_;
  core::MonoTime last_corrections_{};
  core::MonoTime fixes_again_{};  ///< unset: corrections are missing

  std::mutex pulses_mutex_;
  std::vector<core::MonoTime> pulses_;  ///< handed over by AddEvent
  std::deque<Pulse> events_;
  std::size_t last_event_interval_ = 0;
};

}  // namespace kawara::sim
