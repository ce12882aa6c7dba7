#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/geodesy.hpp"
#include "core/measurements.hpp"
#include "core/time.hpp"

namespace kawara::sim {

/// How GGA field 6 tells the RTK state; the two families do not agree.
enum class GgaQuality {
  kAshtechLegacy,  ///< 1 autonomous, 2 code differential and float, 3 fixed
  kNmea23,         ///< 1, 2, 5 float, 4 fixed
};

/// What the receiver has worked out for one epoch: all that its sentences print.
struct GpsSolution {
  core::GpsTime time;
  core::RtkState rtk =
      core::RtkState::kNone;  ///< kNone: sentences go out with empty position fields or not at all
  core::Geodetic antenna;
  Eigen::Vector3d sd_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_sd_ned_mps = Eigen::Vector3d::Zero();
  int satellites = 0;
  double geoid_m = 0.0;
  double pdop = 0.0, hdop = 0.0, vdop = 0.0, tdop = 0.0;
  std::optional<double> correction_age_s;  ///< empty field if unknown
  int latency_ms = 0;
  bool fast_cpd = true;
};

/// The sentences of one epoch, complete with checksum and CR LF; empty where the receiver would
/// stay silent. Latitude and longitude in minutes with seven decimals (0.2 mm). UTC in GGA, RMC,
/// GST, ZDA, POS and CBN; hundredths of a second, thousandths if the epoch needs them. Sources:
/// NMEA 0183 2.3; Z-Family Technical Reference Manual, tables of POS (6.106), CBN (6.60), LTN.
std::string GgaSentence(const GpsSolution& s, GgaQuality encoding);
std::string RmcSentence(const GpsSolution& s);
std::string VtgSentence(const GpsSolution& s);
std::string GstSentence(const GpsSolution& s);
/// Identities of the satellites are not recorded: their fields stay empty.
std::string GsaSentence(const GpsSolution& s);
std::string ZdaSentence(const GpsSolution& s);
/// Speed in knots, vertical velocity (up) in decimetres per second, altitude above the ellipsoid.
std::string PosSentence(const GpsSolution& s);
/// Velocities and their deviations in the order east, north, up.
std::string CbnSentence(const GpsSolution& s);
std::string LtnSentence(const GpsSolution& s);

/// $PASHR,PTT and $PASHR,TTT: day of week (Sunday 1) and time of day on the GPS scale to 100 ns.
std::string PttSentence(core::GpsTime pulse);
std::string TttSentence(core::GpsTime event);

}  // namespace kawara::sim
