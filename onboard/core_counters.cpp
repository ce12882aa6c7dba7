#include "onboard/core_counters.hpp"

namespace kawara::onboard {
namespace {

std::int64_t I(std::uint64_t n) { return static_cast<std::int64_t>(n); }

}  // namespace

CoreCounters::CoreCounters(core::Counters& c)
    : gps_good_(c.Register("gps.messages")),
      gps_bad_checksum_(c.Register("gps.bad_checksum")),
      gps_skipped_bytes_(c.Register("gps.skipped_bytes")),
      gps_fixes_(c.Register("gps.fixes")),
      gps_timed_out_(c.Register("gps.epochs_timed_out")),
      gps_rejected_times_(c.Register("gps.times_rejected")),
      gps_undated_(c.Register("gps.epochs_undated")),
      ahrs_good_(c.Register("ahrs.packets")),
      ahrs_bad_checksum_(c.Register("ahrs.bad_checksum")),
      ahrs_skipped_bytes_(c.Register("ahrs.skipped_bytes")),
      ahrs_frozen_(c.Register("ahrs.frozen")),
      pulses_used_(c.Register("pps.used")),
      pulses_refused_(c.Register("pps.refused")),
      pulses_missing_(c.Register("pps.missing")),
      rtcm_forwarded_(c.Register("corrections.forwarded")),
      rtcm_bad_(c.Register("corrections.bad")),
      rtcm_refused_(c.Register("corrections.refused")),
      rtcm_dropped_(c.Register("corrections.dropped")),
      triggers_(c.Register("camera.triggers")),
      triggers_skipped_(c.Register("camera.triggers_too_late")),
      paired_(c.Register("camera.paired")),
      missed_(c.Register("camera.missed")),
      stray_(c.Register("camera.stray")),
      doubled_(c.Register("camera.doubled")),
      disagreed_(c.Register("camera.disagreed")),
      marked_(c.Register("camera.marked")),
      mark_missing_(c.Register("camera.marks_missing")),
      mark_stray_(c.Register("camera.marks_stray")),
      lead_(c.Register("camera.lead_us")),
      stamp_error_(c.Register("camera.stamp_error_us")),
      pictures_(c.Register("phase1.ordered")),
      busy_(c.Register("phase1.skipped_busy")),
      blind_(c.Register("phase1.poses_extrapolated")),
      nav_fixes_used_(c.Register("nav.fixes_used")),
      nav_fixes_refused_(c.Register("nav.fixes_refused")),
      nav_wrong_fixes_(c.Register("nav.wrong_fix_episodes")),
      nav_resets_(c.Register("nav.resets")),
      nav_outages_(c.Register("nav.outages")),
      nav_late_(c.Register("nav.late_fused")),
      nav_too_late_(c.Register("nav.too_late")),
      nav_imu_refused_(c.Register("nav.imu_refused")) {}

void CoreCounters::Set(const drivers::GnssStreamDecoder::Stats& stream,
                       const drivers::GnssEpochAssembler::Stats& epochs) {
  gps_good_.Set(I(stream.good));
  gps_bad_checksum_.Set(I(stream.bad_checksum));
  gps_skipped_bytes_.Set(I(stream.skipped_bytes));
  gps_fixes_.Set(I(epochs.fixes));
  gps_timed_out_.Set(I(epochs.timed_out));
  gps_rejected_times_.Set(I(epochs.rejected_times));
  gps_undated_.Set(I(epochs.undated));
}

void CoreCounters::Set(const drivers::Ahrs400Stats& ahrs) {
  ahrs_good_.Set(I(ahrs.Good()));
  ahrs_bad_checksum_.Set(I(ahrs.bad_checksum));
  ahrs_skipped_bytes_.Set(I(ahrs.skipped_bytes));
  ahrs_frozen_.Set(I(ahrs.frozen));
}

void CoreCounters::Set(const drivers::CorrectionForwarder::Stats& corrections) {
  rtcm_forwarded_.Set(I(corrections.forwarded));
  rtcm_bad_.Set(I(corrections.bad_crc + corrections.parity_errors));
  rtcm_refused_.Set(I(corrections.refused));
  rtcm_dropped_.Set(I(corrections.dropped));
}

void CoreCounters::Set(const PulseChain::Stats& pulses) {
  pulses_used_.Set(pulses.used);
  pulses_refused_.Set(pulses.refused);
  pulses_missing_.Set(pulses.missing);
}

void CoreCounters::Set(const PictureChain& pictures) {
  triggers_.Set(pictures.stats().triggers);
  triggers_skipped_.Set(pictures.skipped_triggers());
  paired_.Set(pictures.pairing().paired);
  missed_.Set(pictures.pairing().missed);
  stray_.Set(pictures.pairing().stray);
  doubled_.Set(pictures.pairing().doubled);
  disagreed_.Set(pictures.pairing().disagreed);
  marked_.Set(pictures.marks().used);
  mark_missing_.Set(pictures.marks().missing);
  mark_stray_.Set(pictures.marks().stray);
  lead_.Set(pictures.shutter().lead().mean.count() / 1000);
  stamp_error_.Set(pictures.shutter().stamp().mean.count() / 1000);
  pictures_.Set(pictures.stats().pictures);
  busy_.Set(pictures.stats().skipped_busy);
  blind_.Set(pictures.stats().blind_poses);
}

void CoreCounters::Set(const estimation::NavigationReport& report,
                       const estimation::NavigationStats& navigation) {
  nav_fixes_used_.Set(report.fixes_used);
  nav_fixes_refused_.Set(report.fixes_refused);
  nav_wrong_fixes_.Set(report.wrong_fix_episodes);
  nav_resets_.Set(report.resets);
  nav_outages_.Set(navigation.outages);
  nav_late_.Set(navigation.late_fused);
  nav_too_late_.Set(navigation.too_late);
  nav_imu_refused_.Set(navigation.imu_backwards + navigation.imu_duplicates +
                       navigation.imu_invalid + navigation.imu_spikes);
}

}  // namespace kawara::onboard
