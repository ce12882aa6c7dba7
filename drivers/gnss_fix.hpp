#pragma once
#include <optional>

#include "core/measurements.hpp"
#include "drivers/ashtech.hpp"
#include "drivers/ashtech_binary.hpp"
#include "drivers/nmea.hpp"
#include "drivers/receiver_profile.hpp"
#include "drivers/ubx.hpp"

namespace kawara::drivers {

/// All that one epoch's sentences said.
struct EpochParts {
  std::optional<NmeaGga> gga;
  std::optional<NmeaRmc> rmc;
  std::optional<NmeaVtg> vtg;
  std::optional<NmeaGst> gst;
  std::optional<NmeaHeading> heading;
  std::optional<AshtechPos> pos;
  std::optional<AshtechCbn> cbn;
  std::optional<AshtechLatency> latency;
  std::optional<AshtechPbn> pbn;
  std::optional<UbxNavPvt> pvt;
};

/// Merges them into one fix; time and arrival are left to the caller.
/// Position and RTK state: the first of CBN, POS, GGA, NAV-PVT, PBN that has a position with a
/// height. Covariance: CBN, NAV-PVT or GST; else PositionSigma(). Velocity: CBN, NAV-PVT, PBN, POS,
/// RMC, VTG; its vertical part is zero with a large deviation where nobody told it. Real-time safe,
/// any thread.
core::GnssFix MakeFix(const EpochParts& parts, ReceiverProfile profile);

struct HorizontalVertical {
  double horizontal_m = 0.0;
  double vertical_m = 0.0;
};
/// One sigma by kind of solution, for receivers that do not state theirs, scaled by the horizontal
/// dilution where it is worse than 1. Open-sky figures: RTK fixed 1 cm + antenna and set-up errors;
/// float within a few decimetres; code differential about 1 m; autonomous with ionosphere about 3
/// m.
HorizontalVertical PositionSigma(core::RtkState state, double hdop);

}  // namespace kawara::drivers
