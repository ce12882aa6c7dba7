#include "drivers/receiver_profile.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace kawara::drivers {
namespace {

using core::RtkState;

TEST(ReceiverProfile, GgaQualityInBothEncodings) {
  struct Case {
    std::uint8_t quality;
    RtkState standard;
    RtkState legacy;
  };
  const Case cases[] = {{0, RtkState::kNone, RtkState::kNone},
                        {1, RtkState::kAutonomous, RtkState::kAutonomous},
                        {2, RtkState::kCodeDifferential, RtkState::kCodeDifferential},
                        {3, RtkState::kAutonomous, RtkState::kFixed},
                        {4, RtkState::kFixed, RtkState::kNone},
                        {5, RtkState::kFloat, RtkState::kNone},
                        {6, RtkState::kDeadReckoning, RtkState::kNone},
                        {7, RtkState::kNone, RtkState::kNone},
                        {8, RtkState::kNone, RtkState::kNone},
                        {9, RtkState::kCodeDifferential, RtkState::kNone}};
  for (const Case& c : cases) {
    EXPECT_EQ(RtkStateOfGga(c.quality, ReceiverProfile::kNmea), c.standard) << int{c.quality};
    EXPECT_EQ(RtkStateOfGga(c.quality, ReceiverProfile::kAshtech), c.standard) << int{c.quality};
    EXPECT_EQ(RtkStateOfGga(c.quality, ReceiverProfile::kAshtechLegacy), c.legacy)
        << int{c.quality};
  }
}

TEST(ReceiverProfile, PosTypesOfAllModels) {
  const std::pair<int, RtkState> cases[] = {{-1, RtkState::kNone},
                                            {0, RtkState::kAutonomous},
                                            {1, RtkState::kCodeDifferential},
                                            {2, RtkState::kFloat},
                                            {3, RtkState::kFixed},
                                            {5, RtkState::kDeadReckoning},
                                            {9, RtkState::kCodeDifferential},
                                            {12, RtkState::kFloat},
                                            {13, RtkState::kFixed},
                                            {22, RtkState::kFloat},
                                            {23, RtkState::kFixed},
                                            {4, RtkState::kNone}};
  for (const auto& [type, state] : cases) EXPECT_EQ(RtkStateOfPos(type), state) << type;
}

TEST(ReceiverProfile, AltitudeWithoutSeparationIsEllipsoidal) {
  NmeaGga gga;
  gga.altitude_m = 12.384;
  EXPECT_DOUBLE_EQ(EllipsoidalHeight(gga), 12.384);
  gga.geoid_separation_m = -31.0;
  EXPECT_DOUBLE_EQ(EllipsoidalHeight(gga), -18.616);
  gga.altitude_m = kNotSaid;
  EXPECT_TRUE(std::isnan(EllipsoidalHeight(gga)));
}

TEST(ReceiverProfile, LegacyAgeHasTheLatencyInItsFraction) {
  NmeaGga gga;
  gga.age_s = 3.123;
  const AgeAndLatency legacy = AgeOfGga(gga, ReceiverProfile::kAshtechLegacy);
  EXPECT_DOUBLE_EQ(legacy.age_s, 3.0);
  EXPECT_NEAR(legacy.latency_s, 0.123, 1e-12);
  const AgeAndLatency standard = AgeOfGga(gga, ReceiverProfile::kNmea);
  EXPECT_DOUBLE_EQ(standard.age_s, 3.123);
  EXPECT_TRUE(std::isnan(standard.latency_s));
}

TEST(ReceiverProfile, Names) {
  for (const auto profile :
       {ReceiverProfile::kNmea, ReceiverProfile::kAshtechLegacy, ReceiverProfile::kAshtech}) {
    ReceiverProfile read = ReceiverProfile::kNmea;
    EXPECT_TRUE(FromString(ToString(profile), read));
    EXPECT_EQ(read, profile);
  }
  ReceiverProfile read = ReceiverProfile::kNmea;
  EXPECT_FALSE(FromString("trimble", read));
}

}  // namespace
}  // namespace kawara::drivers
