#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "sim/camera/triggered_camera.hpp"
#include "sim/faults/fault_orders.hpp"
#include "sim/faults/faults.hpp"
#include "sim/instruments/ahrs400.hpp"
#include "sim/instruments/gps_receiver.hpp"
#include "sim/instruments/pulse_line.hpp"
#include "sim/instruments/serial_line.hpp"
#include "sim/instruments/sick_scanner.hpp"
#include "sim/motion/ahrs_trace.hpp"
#include "sim/motion/recording.hpp"
#include "sim/run/truth_log.hpp"
#include "sim/sim_clock.hpp"

namespace kawara::sim {

/// One laser scanner beside the other instruments.
struct ScannerSetup {
  std::string port;  ///< name of its link in the run-dir: "laser1", "laser2"
  RangeCaster cast;
  SickScannerOptions options;
};

/// What the instruments measure, and the truth of it. Everything referred to must outlive the run.
struct MeasuredMotion {
  const Recording& recording;
  const std::vector<AhrsState>& trace;
  core::GpsTime begin, end;  ///< the part that is played
  std::function<core::Geodetic(core::GpsTime)> antenna_at;
  std::function<double(core::GpsTime)> yaw_at;  ///< true heading [rad]
  std::vector<ScannerSetup> scanners = {};      ///< faults laser1 and laser2 hit the first two
  const SiteWorld* world = nullptr;             ///< null: a recorded drive
};

/// What the instruments are.
struct InstrumentSetup {
  GpsReceiverOptions gps;
  Ahrs400Options ahrs;
  PulseOptions pulses;
  std::vector<Fault> faults;
};

/// All instruments of one simulated robot with their cables, what goes wrong with them, and the
/// truth of what they measure. Time is what the caller says: the clock of the wall (RunInstruments)
/// or one that goes as fast as the computer can. One thread owns it; the camera, which may live on
/// a thread of its own, has the calls marked so.
class InstrumentSet {
 public:
  struct Ports {
    std::unique_ptr<HostPort> gps, ahrs;
    std::vector<std::unique_ptr<HostPort>> scanners;      ///< as many as the motion has
    std::function<void(const drivers::PpsEdge&)> pulses;  ///< called by Service()
  };
  /// `motion`, `clock` and `truth` must outlive it. Faults count from `begin`.
  InstrumentSet(const InstrumentSetup& setup, const MeasuredMotion& motion, const SimClock& clock,
                core::MonoTime begin, Ports ports, TruthLog& truth);
  ~InstrumentSet();
  InstrumentSet(const InstrumentSet&) = delete;
  InstrumentSet& operator=(const InstrumentSet&) = delete;

  /// Does everything that is due by `now`, which never goes back. Error: replugging failed.
  core::Expected<void> Service(core::MonoTime now);
  /// When Service() will next have something to do of its own accord; unset: never. The hosts'
  /// bytes come besides.
  core::MonoTime NextService() const;

  /// From now on these happen too, or none any more. Those that are over are forgotten.
  void Take(core::MonoTime now, const FaultOrder& order);
  std::size_t planned_faults() const { return faults_.faults().size(); }

  /// The three for the camera. Any thread: what is wrong with it, as of the last Service().
  TriggeredCamera::Faults camera_faults() const;
  /// Any thread: its signal line is wired to the receiver's event input.
  void OnCameraSignal(core::MonoTime pulse) { gps_.AddEvent(pulse); }
  /// Any thread: an exposure for the truth; written down by the next Service().
  void OnExposure(const TriggeredCamera::Exposure& exposure);

  struct Counters {
    GpsReceiver::Counters gps;
    SerialLine::Counters gps_line;
    std::uint64_t gps_dropped_messages = 0;
    Ahrs400::Counters ahrs;
    SerialLine::Counters ahrs_line;
    std::uint64_t ahrs_saturated = 0;
    std::uint64_t pulses = 0;
    std::vector<SickScanner::Counters> scanners;
  };
  /// After the last Service(): the truth is whole. Error: it could not be written.
  core::Expected<void> FinishTruth(core::MonoTime now);
  Counters counters() const;
  /// "gps /dev/pts/7\n" and so on: where the ports are.
  std::string DevicesText() const;

 private:
  struct Scanner;
  void SetFaults(core::MonoTime now);
  core::Expected<void> ServiceLines(core::MonoTime now);
  void ServicePulses(core::MonoTime now);
  void WriteTruth(core::MonoTime now);
  bool Active(FaultKind kind, core::MonoTime now) const {
    return faults_.Active(kind, now - begin_);
  }

  const MeasuredMotion& motion_;
  const SimClock& clock_;
  core::MonoTime begin_;
  TruthLog& truth_;
  FaultPlan faults_;
  GpsReceiver gps_;
  Ahrs400 ahrs_;
  SerialLine gps_line_;
  SerialLine ahrs_line_;
  PulseLine pulse_line_;
  std::function<void(const drivers::PpsEdge&)> on_pulse_;
  std::vector<std::unique_ptr<Scanner>> scanners_;
  std::size_t next_true_fix_ = 0;

  mutable std::mutex camera_faults_mutex_;
  TriggeredCamera::Faults camera_faults_;
  std::mutex exposures_mutex_;
  std::vector<TriggeredCamera::Exposure> exposures_;
};

}  // namespace kawara::sim
