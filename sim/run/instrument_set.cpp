#include "sim/run/instrument_set.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace kawara::sim {
namespace {

/// Which faults are a scanner's own.
struct ScannerFaults {
  FaultKind unplug, silent, garbage, stuck, power;
};
constexpr std::array<ScannerFaults, 2> kScannerFaults{
    {{FaultKind::kLaser1Unplug, FaultKind::kLaser1Silent, FaultKind::kLaser1Garbage,
      FaultKind::kLaser1Stuck, FaultKind::kLaser1Power},
     {FaultKind::kLaser2Unplug, FaultKind::kLaser2Silent, FaultKind::kLaser2Garbage,
      FaultKind::kLaser2Stuck, FaultKind::kLaser2Power}}};

}  // namespace

/// A laser scanner and its cable.
struct InstrumentSet::Scanner {
  Scanner(const ScannerSetup& setup, std::unique_ptr<HostPort> port, const MeasuredMotion& motion,
          const SimClock& clock)
      : instrument(setup.cast, clock, motion.begin, motion.end, setup.options),
        line(std::move(port), instrument, setup.options.seed + 1) {}
  SickScanner instrument;
  SerialLine line;
};

InstrumentSet::InstrumentSet(const InstrumentSetup& setup, const MeasuredMotion& motion,
                             const SimClock& clock, core::MonoTime begin, Ports ports,
                             TruthLog& truth)
    : motion_(motion),
      clock_(clock),
      begin_(begin),
      truth_(truth),
      faults_(setup.faults),
      gps_(motion.recording, clock, motion.begin, motion.end, setup.gps),
      ahrs_(motion.trace, clock, motion.begin, motion.end, setup.ahrs),
      gps_line_(std::move(ports.gps), gps_, setup.gps.seed + 2),
      ahrs_line_(std::move(ports.ahrs), ahrs_, setup.gps.seed + 3),
      pulse_line_(setup.pulses),
      on_pulse_(std::move(ports.pulses)) {
  for (std::size_t i = 0; i < motion.scanners.size(); ++i) {
    scanners_.push_back(
        std::make_unique<Scanner>(motion.scanners[i], std::move(ports.scanners[i]), motion, clock));
  }
  const auto& fixes = motion.recording.fixes;
  while (next_true_fix_ < fixes.size() && fixes[next_true_fix_].time < motion.begin) {
    ++next_true_fix_;
  }
}

InstrumentSet::~InstrumentSet() = default;

core::Expected<void> InstrumentSet::Service(core::MonoTime now) {
  SetFaults(now);
  if (auto healthy = ServiceLines(now); !healthy) return healthy;
  ServicePulses(now);
  WriteTruth(now);
  return {};
}

void InstrumentSet::SetFaults(core::MonoTime now) {
  gps_.SetFaults({.no_fix = Active(FaultKind::kGpsNoFix, now),
                  .bad_checksum = Active(FaultKind::kGpsBadSum, now),
                  .power_off = Active(FaultKind::kGpsPower, now),
                  .clock_step = Active(FaultKind::kGpsClockStep, now),
                  .no_pps = Active(FaultKind::kGpsNoPps, now)});
  ahrs_.SetClockStep(Active(FaultKind::kAhrsClockStep, now));
  for (std::size_t i = 0; i < std::min(scanners_.size(), kScannerFaults.size()); ++i) {
    scanners_[i]->instrument.SetPower(now, !Active(kScannerFaults[i].power, now));
  }
  const auto share = [this, now](FaultKind kind) {
    return faults_.Value(kind, now - begin_).value_or(0.0);
  };
  const std::lock_guard lock(camera_faults_mutex_);
  camera_faults_ = {.hang = Active(FaultKind::kCameraHang, now),
                    .miss = share(FaultKind::kCameraMiss),
                    .doubled = share(FaultKind::kCameraDouble),
                    .late = Active(FaultKind::kCameraLate, now),
                    .dark = Active(FaultKind::kCameraDark, now),
                    .disconnected = Active(FaultKind::kCameraDisconnect, now)};
}

core::Expected<void> InstrumentSet::ServiceLines(core::MonoTime now) {
  auto healthy = gps_line_.Service(now, {.unplugged = Active(FaultKind::kGpsUnplug, now),
                                         .silent = Active(FaultKind::kGpsSilent, now),
                                         .garbage = Active(FaultKind::kGpsGarbage, now),
                                         .stuck = Active(FaultKind::kGpsStuck, now)});
  if (healthy) {
    healthy = ahrs_line_.Service(now, {.unplugged = Active(FaultKind::kAhrsUnplug, now),
                                       .silent = Active(FaultKind::kAhrsSilent, now),
                                       .garbage = Active(FaultKind::kAhrsGarbage, now),
                                       .stuck = Active(FaultKind::kAhrsStuck, now)});
  }
  for (std::size_t i = 0; i < scanners_.size() && healthy; ++i) {
    SerialLine::Faults faults;
    if (i < kScannerFaults.size()) {
      const ScannerFaults& own = kScannerFaults[i];
      faults = {.unplugged = Active(own.unplug, now),
                .silent = Active(own.silent, now),
                .garbage = Active(own.garbage, now),
                .stuck = Active(own.stuck, now)};
    }
    healthy = scanners_[i]->line.Service(now, faults);
  }
  return healthy;
}

void InstrumentSet::ServicePulses(core::MonoTime now) {
  for (const core::MonoTime edge : gps_.TakeEdges()) {
    pulse_line_.OnEdge(edge, {.lost = Active(FaultKind::kPpsLost, edge),
                              .jittery = Active(FaultKind::kPpsJitter, edge),
                              .doubled = Active(FaultKind::kPpsDouble, edge)});
  }
  for (const drivers::PpsEdge& edge : pulse_line_.Take(now)) on_pulse_(edge);
}

/// The fixes that have become true, and the exposures made since the last call, one line each.
void InstrumentSet::WriteTruth(core::MonoTime now) {
  const auto& fixes = motion_.recording.fixes;
  for (; next_true_fix_ < fixes.size() && fixes[next_true_fix_].time <= motion_.end;
       ++next_true_fix_) {
    const RecordedFix& fix = fixes[next_true_fix_];
    const core::MonoTime mono = clock_.MonoAt(fix.time);
    if (mono > now) break;
    truth_.Epoch(fix.time, mono, motion_.antenna_at(fix.time),
                 fix.rtk == core::RtkState::kFixed ? 1 : 2);
  }
  std::vector<TriggeredCamera::Exposure> exposures;
  {
    const std::lock_guard lock(exposures_mutex_);
    exposures.swap(exposures_);
  }
  for (const TriggeredCamera::Exposure& e : exposures) {
    truth_.Exposure(e.trigger_sequence, e.frame_sequence, e.gps, e.mono, motion_.antenna_at(e.gps),
                    motion_.yaw_at(e.gps));
  }
  truth_.Advance(std::min(clock_.GpsAt(now), motion_.end));
}

core::Expected<void> InstrumentSet::FinishTruth(core::MonoTime now) {
  return truth_.Close(std::min(clock_.GpsAt(now), motion_.end));
}

core::MonoTime InstrumentSet::NextService() const {
  core::MonoTime next;
  const auto consider = [&next](core::MonoTime due) {
    if (due.IsSet() && (!next.IsSet() || due < next)) next = due;
  };
  consider(gps_line_.NextService());
  consider(ahrs_line_.NextService());
  consider(gps_.NextEdge());
  consider(pulse_line_.NextDue());
  for (const auto& scanner : scanners_) consider(scanner->line.NextService());
  return next;
}

void InstrumentSet::Take(core::MonoTime now, const FaultOrder& order) {
  faults_ = Applied(faults_, order, now - begin_);
}

TriggeredCamera::Faults InstrumentSet::camera_faults() const {
  const std::lock_guard lock(camera_faults_mutex_);
  return camera_faults_;
}

void InstrumentSet::OnExposure(const TriggeredCamera::Exposure& exposure) {
  const std::lock_guard lock(exposures_mutex_);
  exposures_.push_back(exposure);
}

InstrumentSet::Counters InstrumentSet::counters() const {
  Counters c;
  c.gps = gps_.counters();
  c.gps_line = gps_line_.counters();
  c.gps_dropped_messages = gps_.dropped_messages();
  c.ahrs = ahrs_.counters();
  c.ahrs_line = ahrs_line_.counters();
  c.ahrs_saturated = ahrs_.saturated();
  c.pulses = pulse_line_.edges();
  for (const auto& scanner : scanners_) c.scanners.push_back(scanner->instrument.counters());
  return c;
}

std::string InstrumentSet::DevicesText() const {
  std::string text = "gps " + gps_line_.port().device() + "\nahrs " + ahrs_line_.port().device();
  for (std::size_t i = 0; i < scanners_.size(); ++i) {
    text += "\n" + motion_.scanners[i].port + " " + scanners_[i]->line.port().device();
  }
  return text + "\n";
}

}  // namespace kawara::sim
