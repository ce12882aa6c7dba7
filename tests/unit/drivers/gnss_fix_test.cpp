#include "drivers/gnss_fix.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace kawara::drivers {
namespace {

using core::RtkState;

NmeaGga Gga(std::uint8_t quality) {
  NmeaGga gga;
  gga.has_position = true;
  gga.lat_deg = 35.0;
  gga.lon_deg = 137.0;
  gga.altitude_m = 10.0;
  gga.geoid_separation_m = 37.0;
  gga.quality = quality;
  gga.hdop = 0.8;
  return gga;
}

AshtechCbn Cbn() {
  AshtechCbn cbn;
  cbn.has_position = true;
  cbn.lat_deg = 35.1;
  cbn.lon_deg = 137.1;
  cbn.h_ellipsoidal_m = 48.0;
  cbn.lat_sd_m = 0.02;
  cbn.lon_sd_m = 0.01;
  cbn.height_sd_m = 0.03;
  cbn.cross_m2 = {0.0001, -0.0002, 0.0001};
  cbn.flags = {2, 2, 1, 0, 0, 1};
  cbn.east_mps = 1.0;
  cbn.north_mps = 2.0;
  cbn.up_mps = 0.5;
  cbn.east_sd_mps = cbn.north_sd_mps = cbn.up_sd_mps = 0.04;
  return cbn;
}

TEST(MakeFix, CbnGivesPositionCovarianceAndVelocity) {
  EpochParts parts;
  parts.gga = Gga(3);
  parts.cbn = Cbn();
  const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kAshtechLegacy);
  EXPECT_EQ(fix.rtk, RtkState::kFixed);
  EXPECT_DOUBLE_EQ(fix.antenna.lat_rad, 35.1 * core::kRadFromDeg);
  // East, north, up: longitude first.
  EXPECT_NEAR(fix.position_cov_enu_m2(0, 0), 1e-4, 1e-12);
  EXPECT_NEAR(fix.position_cov_enu_m2(1, 1), 4e-4, 1e-12);
  EXPECT_NEAR(fix.position_cov_enu_m2(0, 1), 1e-4, 1e-12);
  EXPECT_NEAR(fix.position_cov_enu_m2(1, 2), -2e-4, 1e-12);
  EXPECT_NEAR(fix.position_cov_enu_m2(0, 2), 1e-4, 1e-12);
  EXPECT_EQ(fix.velocity_enu_mps, Eigen::Vector3d(1.0, 2.0, 0.5));
  EXPECT_EQ(fix.native_quality, 3);
}

TEST(MakeFix, CovariancesThatCannotBeLoseTheirCrossTerms) {
  EpochParts parts;
  parts.cbn = Cbn();
  parts.cbn->cross_m2 = {0.9e-4 * 2, 0.9 * 6e-4, -0.9 * 3e-4};  // possible in pairs, not together
  const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_EQ(fix.position_cov_enu_m2(0, 1), 0.0);
  EXPECT_NEAR(fix.position_cov_enu_m2(2, 2), 9e-4, 1e-12);
  parts.cbn->cross_m2 = {7.0, 0.0, 0.0};
  EXPECT_EQ(MakeFix(parts, ReceiverProfile::kNmea).position_cov_enu_m2(0, 1), 0.0);
}

TEST(MakeFix, GstEllipseCorrelatesNorthAndEast) {
  EpochParts parts;
  parts.gga = Gga(4);
  NmeaGst gst;
  gst.semi_major_m = 0.03;
  gst.semi_minor_m = 0.01;
  gst.orientation_deg = 45.0;  // to the north-east: both grow together
  gst.lat_sd_m = gst.lon_sd_m = std::sqrt((9e-4 + 1e-4) / 2.0);
  gst.alt_sd_m = 0.05;
  parts.gst = gst;
  const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_TRUE(fix.covariance_from_receiver);
  EXPECT_NEAR(fix.position_cov_enu_m2(0, 1), 4e-4, 1e-9);
  EXPECT_NEAR(fix.position_cov_enu_m2(2, 2), 25e-4, 1e-12);
}

TEST(MakeFix, WithoutAccuracyTheSolutionTypeDecidesNotHdopAlone) {
  double last = 0.0;
  for (const std::uint8_t quality : std::array<std::uint8_t, 4>{4, 5, 2, 1}) {
    EpochParts parts;
    parts.gga = Gga(quality);
    const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kNmea);
    EXPECT_FALSE(fix.covariance_from_receiver);
    const double sd = std::sqrt(fix.position_cov_enu_m2(0, 0));
    EXPECT_GT(sd, 2.0 * last) << int{quality};
    last = sd;
  }
  EXPECT_NEAR(PositionSigma(RtkState::kFixed, 3.0).horizontal_m,
              3.0 * PositionSigma(RtkState::kFixed, 0.7).horizontal_m, 1e-12);
}

TEST(MakeFix, AZeroAccuracyIsNoAccuracy) {
  EpochParts parts;
  parts.gga = Gga(4);
  NmeaGst gst;
  gst.lat_sd_m = gst.lon_sd_m = gst.alt_sd_m = 0.0;
  parts.gst = gst;
  const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_FALSE(fix.covariance_from_receiver);
  EXPECT_GT(fix.position_cov_enu_m2(0, 0), 0.0);
}

TEST(MakeFix, AtRestAMissingCourseIsNormal) {
  EpochParts parts;
  parts.gga = Gga(4);
  NmeaRmc rmc;
  rmc.valid = true;
  rmc.speed_mps = 0.006;
  parts.rmc = rmc;
  core::GnssFix fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_TRUE(fix.has_velocity);
  EXPECT_EQ(fix.velocity_enu_mps.norm(), 0.0);
  EXPECT_GE(fix.velocity_sd_enu_mps.z(), 1.0) << "nobody told the vertical part";
  parts.rmc->speed_mps = 5.0;
  fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_FALSE(fix.has_velocity);
  parts.rmc->course_deg = 90.0;
  fix = MakeFix(parts, ReceiverProfile::kNmea);
  EXPECT_NEAR(fix.velocity_enu_mps.x(), 5.0, 1e-12);
  EXPECT_NEAR(fix.velocity_enu_mps.y(), 0.0, 1e-12);
}

TEST(MakeFix, WhatNobodySaidIsNotANumber) {
  const core::GnssFix fix = MakeFix({}, ReceiverProfile::kNmea);
  EXPECT_FALSE(fix.has_position || fix.has_velocity || fix.has_heading);
  EXPECT_TRUE(std::isnan(fix.hdop) && std::isnan(fix.latency_s) &&
              std::isnan(fix.correction_age_s) && std::isnan(fix.geoid_separation_m));
}

TEST(MakeFix, PbnVelocityTurnsFromEcefToEnu) {
  EpochParts parts;
  AshtechPbn pbn;
  pbn.ecef_m = core::EcefFromGeodetic({0.0, core::kPi / 2.0, 0.0});  // on the equator at 90 E
  pbn.velocity_ecef_mps = {-3.0, 2.0, 1.0};                          // -x is east, y up, z north
  parts.pbn = pbn;
  const core::GnssFix fix = MakeFix(parts, ReceiverProfile::kAshtech);
  EXPECT_TRUE(fix.velocity_enu_mps.isApprox(Eigen::Vector3d(3.0, 1.0, 2.0), 1e-12));
  EXPECT_EQ(fix.rtk, RtkState::kAutonomous) << "PBN never is the RTK solution";
}

}  // namespace
}  // namespace kawara::drivers
