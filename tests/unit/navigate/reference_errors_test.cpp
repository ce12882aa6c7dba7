#include "tools/navigate/reference_errors.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

using Role = Reference::Role;

const core::Geodetic kHome{0.6, 2.4, 50.0};

core::GpsTime T(const char* text) { return *ParseSeconds(text); }

/// Northwards at 2 m/s through kHome at t = 0, level and looking north.
estimation::NavSolution At(const char* t,
                           estimation::NavState state = estimation::NavState::kFixed) {
  estimation::NavSolution solution;
  solution.time = T(t);
  solution.position = core::OffsetNed(kHome, {2.0 * SecondsOf(T(t)), 0.0, 0.0});
  solution.velocity_ned_mps << 2.0, 0.0, 0.0;
  solution.state = state;
  return solution;
}

Reference Point(const char* t, const Eigen::Vector3d& ned_m, Role role, std::size_t window = 0,
                core::RtkState rtk = core::RtkState::kFixed) {
  return {T(t), core::OffsetNed(kHome, ned_m), rtk, role, window};
}

TEST(ReferenceErrors, BetweenSamplesAndAtTheAntenna) {
  const std::vector<Reference> references{
      Point("0.25", {0.5 + 0.03, 0.04 - 0.2, -1.0}, Role::kHeldOut)};
  ReferenceErrors errors(references, {0.0, -0.2, -1.0});
  errors.AddStretch(At("0.2"), At("0.3"));
  ASSERT_TRUE(errors.residual(0));
  EXPECT_TRUE(errors.residual(0)->isApprox(Eigen::Vector3d(0.03, 0.04, 0.0), 1e-5))
      << errors.residual(0)->transpose();
  const ErrorSum sum = errors.HeldOut(core::RtkState::kFixed);
  EXPECT_EQ(sum.count, 1);
  EXPECT_NEAR(sum.worst_horizontal_m, 0.05, 1e-6);
  EXPECT_NEAR(sum.RmsNed().x(), 0.03, 1e-6);
}

TEST(ReferenceErrors, StretchesInEitherOrderGiveTheSame) {
  const std::vector<Reference> references{Point("0.1", {0.3, 0.0, 0.0}, Role::kHeldOut),
                                          Point("0.6", {0.8, 0.0, 0.0}, Role::kHeldOut)};
  ReferenceErrors forward(references, Eigen::Vector3d::Zero());
  forward.AddStretch(At("0"), At("0.5"));
  forward.AddStretch(At("0.5"), At("1"));
  ReferenceErrors backward(references, Eigen::Vector3d::Zero());
  backward.AddStretch(At("0.5"), At("1"));
  backward.AddStretch(At("0"), At("0.5"));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(*forward.residual(i), *backward.residual(i));
}

TEST(ReferenceErrors, NoSolutionNoResidual) {
  const std::vector<Reference> references{Point("0.5", {1.0, 0.0, 0.0}, Role::kHeldOut),
                                          Point("2", {4.0, 0.0, 0.0}, Role::kHeldOut)};
  ReferenceErrors errors(references, Eigen::Vector3d::Zero());
  errors.AddStretch(At("0"), At("1", estimation::NavState::kAligning));
  errors.AddStretch(At("1"), At("2.5"));  // a gap
  EXPECT_FALSE(errors.residual(0) || errors.residual(1));
  EXPECT_EQ(errors.held_out_uncovered(), 2);
  EXPECT_TRUE(std::isnan(errors.HeldOut(core::RtkState::kFixed).RmsNed().x()));
}

TEST(ReferenceErrors, WindowsAreJudgedByTheirWorstFixedPosition) {
  const std::vector<TimeWindow> windows{{T("0"), T("0.4")}, {T("0.4"), T("0.9")}, {T("5"), T("6")}};
  const std::vector<Reference> references{
      Point("0.1", {0.2, 0.3, 0.0}, Role::kBlanked, 0),
      Point("0.2", {0.4, 0.4, 5.0}, Role::kBlanked, 0),
      Point("0.3", {0.6, 9.0, 0.0}, Role::kBlanked, 0, core::RtkState::kFloat),
      Point("0.5", {1.0, 0.3, 0.0}, Role::kBlanked, 1),
      Point("0.95", {1.9, 7.0, 0.0}, Role::kGiven)};
  ReferenceErrors errors(references, Eigen::Vector3d::Zero());
  errors.AddStretch(At("0"), At("0.5"));
  errors.AddStretch(At("0.5"), At("1"));
  const auto blanked = errors.Blanked(windows);
  ASSERT_EQ(blanked.size(), 3U);
  EXPECT_NEAR(blanked[0].worst_horizontal_m, 0.4, 1e-6);
  EXPECT_EQ(blanked[0].count, 2);
  EXPECT_NEAR(blanked[1].worst_horizontal_m, 0.3, 1e-6);
  EXPECT_EQ(blanked[2].count, 0);
  EXPECT_NEAR(RmsOfWorst(blanked), std::sqrt((0.16 + 0.09) / 2.0), 1e-6);
}

}  // namespace
}  // namespace kawara::navigate
