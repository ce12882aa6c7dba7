#include "sim/vehicle/gnss_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geodesy.hpp"

namespace kawara::sim {
namespace {

using core::RtkState;

std::vector<GnssModel::Epoch> Receive(const GnssConfig& config, double seconds,
                                      const SkyBlocked& blocked = {}, double speed_mps = 0.0,
                                      std::uint64_t seed = 1) {
  GnssModel model(config, blocked, seed);
  std::vector<GnssModel::Epoch> epochs;
  const double dt_s = 1.0 / config.rate_hz;
  for (int i = 0; i < seconds * config.rate_hz; ++i) {
    const double t_s = i / config.rate_hz;
    epochs.push_back(model.Next(t_s, {speed_mps * t_s, 0.0, 1.0}, speed_mps * dt_s));
  }
  return epochs;
}

GnssConfig WithEvent(GnssEventKind kind, double t_s, double length_s) {
  GnssConfig config = GnssConfig::Named("z-xtreme");
  config.events = {{kind, t_s, length_s}};
  return config;
}

/// A high wall to the south of everything.
bool Wall(const Eigen::Vector3d& /*enu_m*/, double azimuth_rad, double elevation_rad) {
  return std::cos(azimuth_rad) < 0.2 && elevation_rad < 75.0 * core::kRadFromDeg;
}

double RmsNorth(const std::vector<GnssModel::Epoch>& epochs, RtkState state) {
  double square = 0.0;
  int n = 0;
  for (const GnssModel::Epoch& e : epochs) {
    if (e.rtk != state || e.wrong_fix) continue;
    square += e.error_ned_m.x() * e.error_ned_m.x();
    ++n;
  }
  return std::sqrt(square / std::max(n, 1));
}

TEST(Sky, GeometryOfEvenSkyIsWithinWhatReceiversSee) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto geometry = GeometryOf(Sky(15, seed).At(100.0));
    ASSERT_TRUE(geometry);
    EXPECT_GT(geometry->hdop, 0.5);
    EXPECT_LT(geometry->hdop, 1.5);
    EXPECT_GT(geometry->vdop, geometry->axis_dop.x()) << "satellites are never below";
  }
}

TEST(Sky, RangeErrorsOfOneMoveComeBackAsThatMove) {
  const auto used = Sky(9, 3).At(0.0);
  const auto geometry = GeometryOf(used);
  ASSERT_TRUE(geometry);
  const Eigen::Vector3d moved(0.3, -0.2, 0.5);
  std::vector<double> ranges;
  for (const SatelliteDirection& s : used) {
    const Eigen::Vector3d towards(std::cos(s.elevation_rad) * std::cos(s.azimuth_rad),
                                  std::cos(s.elevation_rad) * std::sin(s.azimuth_rad),
                                  -std::sin(s.elevation_rad));
    ranges.push_back(-towards.dot(moved));
  }
  EXPECT_LT((PositionErrorOf(*geometry, used, ranges) - moved).norm(), 1e-9);
}

TEST(GnssModel, OpenSkyStaysFixedAtItsStatedSize) {
  const GnssConfig config = GnssConfig::Named("z-xtreme");
  const auto epochs = Receive(config, 4.0 * 3600.0);
  double square = 0.0;
  double claimed = 0.0;
  for (const GnssModel::Epoch& e : epochs) {
    ASSERT_EQ(e.rtk, RtkState::kFixed);
    square += std::pow(e.error_ned_m.x(), 2);
    claimed += std::pow(e.sd_ned_m.x(), 2);
  }
  EXPECT_NEAR(std::sqrt(square / claimed), 1.0, 0.15);
  EXPECT_GT(RmsNorth(epochs, RtkState::kFixed), 0.004);
  EXPECT_LT(RmsNorth(epochs, RtkState::kFixed), 0.012);
}

TEST(GnssModel, NoiseIsColoured) {
  GnssConfig config;
  config.fixed = {.white_m = 0.0, .wander_m = 0.01, .tau_s = 30.0};
  const auto epochs = Receive(config, 7200.0);
  double square = 0.0;
  double lagged = 0.0;
  for (std::size_t i = 300; i < epochs.size(); ++i) {
    square += std::pow(epochs[i].error_ned_m.z(), 2);
    lagged += epochs[i].error_ned_m.z() * epochs[i - 300].error_ned_m.z();
  }
  EXPECT_NEAR(lagged / square, std::exp(-1.0), 0.1);
}

TEST(GnssModel, IdealHasNoErrorAtAll) {
  for (const GnssModel::Epoch& e : Receive({}, 60.0)) {
    EXPECT_EQ(e.rtk, RtkState::kFixed);
    EXPECT_EQ(e.error_ned_m.norm(), 0.0);
    EXPECT_EQ(e.velocity_error_ned_mps.norm(), 0.0);
  }
}

TEST(GnssModel, LossThenFloatThatConvergesThenFix) {
  std::vector<double> first_m, last_m, wait_s;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const auto epochs = Receive(WithEvent(GnssEventKind::kLost, 10.0, 5.0), 200.0, {}, 0.0, seed);
    EXPECT_EQ(epochs[120].rtk, RtkState::kNone);
    EXPECT_EQ(epochs[120].satellites, 0);
    ASSERT_EQ(epochs[150].rtk, RtkState::kFloat);
    std::size_t i = 150;
    while (i < epochs.size() && epochs[i].rtk == RtkState::kFloat) ++i;
    first_m.push_back(epochs[150].error_ned_m.x() / epochs[150].sd_ned_m.x());
    last_m.push_back(std::abs(epochs[i - 1].error_ned_m.x()));
    wait_s.push_back(static_cast<double>(i - 150) * 0.1);
    EXPECT_GT(epochs[150].sd_ned_m.x(),
              2.0 * epochs[i - 1].sd_ned_m.x() * std::min(1.0, wait_s.back() / 60.0));
    EXPECT_EQ(epochs.back().rtk, RtkState::kFixed);
  }
  double mean_wait_s = 0.0;
  double chi_square = 0.0;
  for (std::size_t i = 0; i < wait_s.size(); ++i) {
    mean_wait_s += wait_s[i] / 60.0;
    chi_square += first_m[i] * first_m[i] / 60.0;
    EXPECT_GT(wait_s[i], 5.9) << "0.3 of 20 s, surely";
  }
  EXPECT_NEAR(mean_wait_s, 20.0, 6.0);
  EXPECT_NEAR(chi_square, 1.0, 0.45) << "a float solution knows how bad it is";
}

TEST(GnssModel, WrongFixIsDecimetresOffAndClaimsCentimetres) {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const auto epochs =
        Receive(WithEvent(GnssEventKind::kWrongFix, 10.0, 8.0), 30.0, {}, 0.5, seed);
    EXPECT_FALSE(epochs[99].wrong_fix);
    for (std::size_t i = 101; i < 179; ++i) {
      ASSERT_TRUE(epochs[i].wrong_fix);
      ASSERT_EQ(epochs[i].rtk, RtkState::kFixed);
      ASSERT_GT(epochs[i].error_ned_m.norm(), 0.05);
      ASSERT_LT(epochs[i].error_ned_m.norm(), 1.3);
      ASSERT_LT(epochs[i].sd_ned_m.norm(), 0.03);
    }
    EXPECT_EQ(epochs[181].rtk, RtkState::kFloat) << "noticed: starts anew";
  }
}

TEST(GnssModel, WithoutCorrectionsItDecaysAndComesBack) {
  const auto epochs = Receive(WithEvent(GnssEventKind::kNoCorrections, 10.0, 90.0), 300.0);
  EXPECT_EQ(epochs[190].rtk, RtkState::kFixed) << "9 s old is good enough";
  EXPECT_EQ(epochs[250].rtk, RtkState::kFloat);
  EXPECT_EQ(epochs[750].rtk, RtkState::kAutonomous);
  EXPECT_GT(epochs[750].sd_ned_m.x(), 0.3);
  EXPECT_EQ(epochs[1005].rtk, RtkState::kFloat);
  EXPECT_EQ(epochs.back().rtk, RtkState::kFixed);
}

TEST(GnssModel, WallHidesSatellitesAndBringsMultipathUnclaimed) {
  GnssConfig config = GnssConfig::Named("z-xtreme");
  config.fix_satellites = 5;
  config.satellites = 24;
  config.phase_multipath_m = 0.03;
  config.wrong_fix_share = 0.0;
  const auto open = Receive(config, 1800.0, {}, 0.5);
  const auto beside = Receive(config, 1800.0, Wall, 0.5);
  EXPECT_GT(beside[5].blocked_share, 0.25);
  EXPECT_LT(beside[5].satellites, open[5].satellites);
  EXPECT_GT(beside[5].hdop, open[5].hdop);
  const double stated = beside[5].sd_ned_m.x();
  EXPECT_LT(RmsNorth(open, RtkState::kFixed), 1.5 * open[5].sd_ned_m.x());
  EXPECT_GT(RmsNorth(beside, RtkState::kFixed), 1.5 * stated) << "it does not know of reflections";
}

TEST(GnssModel, UnderAPoorSkySomeFixesAreWrongInTheirShare) {
  GnssConfig config = GnssConfig::Named("z-xtreme");
  config.satellites = 9;
  config.mask_deg = 15.0;
  config.fix_satellites = 5;
  config.wrong_fix_share = 0.3;
  config.fix_time_s = 4.0;
  int fixes = 0;
  int wrong = 0;
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    config.events.clear();
    for (int k = 0; k < 20; ++k) config.events.push_back({GnssEventKind::kFloat, 30.0 * k, 1.0});
    const auto epochs = Receive(config, 600.0, {}, 0.0, seed);
    for (std::size_t i = 1; i < epochs.size(); ++i) {
      if (epochs[i].satellites >= 8 || epochs[i].rtk != RtkState::kFixed ||
          epochs[i - 1].rtk == RtkState::kFixed)
        continue;
      ++fixes;
      wrong += epochs[i].wrong_fix ? 1 : 0;
    }
  }
  ASSERT_GT(fixes, 100);
  EXPECT_NEAR(static_cast<double>(wrong) / fixes, 0.3, 0.1);
}

TEST(GnssModel, VelocityNoiseHasItsSize) {
  const GnssConfig config = GnssConfig::Named("z-xtreme");
  double square = 0.0;
  double stated = 0.0;
  for (const GnssModel::Epoch& e : Receive(config, 600.0)) {
    square += e.velocity_error_ned_mps.cwiseAbs2().sum();
    stated += e.velocity_sd_ned_mps.cwiseAbs2().sum();
  }
  EXPECT_NEAR(std::sqrt(square / stated), 1.0, 0.03);
}

}  // namespace
}  // namespace kawara::sim
