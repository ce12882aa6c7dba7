#include "sim/instruments/pulse_line.hpp"

#include <gtest/gtest.h>

namespace kawara::sim {
namespace {

core::MonoTime Edge(int second) { return core::MonoTime::FromNs(1'000'000'000LL * (100 + second)); }

std::vector<drivers::PpsEdge> RunFor(PulseLine& line, int seconds,
                                     const PulseLine::Faults& faults) {
  std::vector<drivers::PpsEdge> all;
  for (int s = 0; s < seconds; ++s) {
    line.OnEdge(Edge(s), faults);
    for (const auto& edge : line.Take(Edge(s + 1) - core::Nanoseconds(1))) all.push_back(edge);
  }
  return all;
}

TEST(PulseLine, StampsComeAfterTheirEdgeByLatencyAndJitter) {
  PulseLine line({.latency_s = 10e-6, .jitter_s = 5e-6, .seed = 1});
  const auto edges = RunFor(line, 1000, {});
  ASSERT_EQ(edges.size(), 1000U);
  double sum_s = 0.0;
  for (int s = 0; s < 1000; ++s) {
    const double late_s = core::ToSeconds(edges[static_cast<std::size_t>(s)].mono - Edge(s));
    EXPECT_GE(late_s, 10e-6 - 1e-9);
    sum_s += late_s;
  }
  EXPECT_NEAR(sum_s / 1000, 15e-6, 1e-6);
  EXPECT_EQ(edges.back().sequence, 1000U);
}

TEST(PulseLine, NothingComesBeforeItsStamp) {
  PulseLine line({.latency_s = 10e-6, .jitter_s = 0.0});
  line.OnEdge(Edge(0), {});
  EXPECT_TRUE(line.Take(Edge(0) + core::Nanoseconds(9'999)).empty());
  EXPECT_EQ(line.NextDue(), Edge(0) + core::Nanoseconds(10'000));
  EXPECT_EQ(line.Take(line.NextDue()).size(), 1U);
  EXPECT_FALSE(line.NextDue().IsSet());
}

TEST(PulseLine, FaultsLoseDoubleAndSpread) {
  PulseLine line({});
  EXPECT_TRUE(RunFor(line, 10, {.lost = true}).empty());
  const auto doubled = RunFor(line, 10, {.doubled = true});
  ASSERT_EQ(doubled.size(), 20U);
  for (std::size_t i = 1; i < doubled.size(); ++i) {
    EXPECT_GT(doubled[i].mono, doubled[i - 1].mono);
  }
  core::Duration latest{};
  const auto jittery = RunFor(line, 100, {.jittery = true});
  for (std::size_t i = 0; i < jittery.size(); ++i) {
    latest = std::max(latest, jittery[i].mono - Edge(static_cast<int>(i)));
  }
  EXPECT_GT(latest, core::Milliseconds(4));
}

TEST(PulseLine, AFaultChangesNothingOfWhatComesAfterIt) {
  PulseLine whole({}), hurt({});
  (void)RunFor(whole, 5, {});
  (void)RunFor(hurt, 5, {.lost = true});
  for (PulseLine* line : {&whole, &hurt}) line->OnEdge(Edge(9), {});
  EXPECT_EQ(whole.NextDue(), hurt.NextDue());
}

}  // namespace
}  // namespace kawara::sim
