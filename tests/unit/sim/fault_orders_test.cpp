#include "sim/faults/fault_orders.hpp"

#include <gtest/gtest.h>

#include <string>

namespace kawara::sim {
namespace {

TEST(FaultOrders, WithoutATimeTheyBeginNow) {
  const auto order = ParseFaultOrder(" gps.unplug 5s; camera.dark", core::Milliseconds(12'345));
  ASSERT_TRUE(order) << order.error().message;
  ASSERT_EQ(order->faults.size(), 2U);
  EXPECT_FALSE(order->clear);
  for (const Fault& fault : order->faults) EXPECT_EQ(fault.begin, core::Milliseconds(12'345));
  EXPECT_EQ(order->faults[0].kind, FaultKind::kGpsUnplug);
  EXPECT_EQ(order->faults[1].length, core::Seconds(5));
}

TEST(FaultOrders, WithATimeTheyCountFromTheStart) {
  const auto order = ParseFaultOrder("t=30 gps.unplug 2s", core::Seconds(10));
  ASSERT_TRUE(order) << order.error().message;
  EXPECT_EQ(order->faults[0].begin, core::Seconds(30));
}

TEST(FaultOrders, BeforeTheStartNowIsTheStart) {
  const auto order = ParseFaultOrder("gps.silent", core::Milliseconds(-400));
  ASSERT_TRUE(order) << order.error().message;
  EXPECT_EQ(order->faults[0].begin, core::Duration(0));
}

TEST(FaultOrders, WhatWasUnderstoodCanBeOrderedAgain) {
  for (const char* text : {"clear", "t=12.5 gps.unplug 5s; t=100 ahrs.stuck 0.25s"}) {
    const auto order = ParseFaultOrder(text, core::Duration(0));
    ASSERT_TRUE(order) << order.error().message;
    EXPECT_EQ(ToString(*order), text);
  }
}

TEST(FaultOrders, ValuesComeAndGoAsText) {
  const auto order = ParseFaultOrder("radio.loss=0.25 5s", core::Seconds(10));
  ASSERT_TRUE(order);
  EXPECT_EQ(ToString(*order), "t=10 radio.loss=0.25 5s");
}

TEST(FaultOrders, APlanForgetsWhatIsOverAndClearEndsAll) {
  const auto first = ParseFaultOrder("t=1 radio.down 2s; t=1 gps.silent 100s", {});
  const auto second = ParseFaultOrder("radio.delay 5s", core::Seconds(10));
  ASSERT_TRUE(first && second);
  FaultPlan plan = Applied({}, *first, {});
  plan = Applied(plan, *second, core::Seconds(10));
  EXPECT_EQ(plan.faults().size(), 2U);
  EXPECT_TRUE(plan.Active(FaultKind::kGpsSilent, core::Seconds(50)));
  EXPECT_TRUE(plan.Active(FaultKind::kRadioDelay, core::Seconds(12)));
  EXPECT_TRUE(Applied(plan, {.clear = true, .faults = {}}, core::Seconds(12)).faults().empty());
}

TEST(FaultOrders, MistakesAreOneLineThatCanBePrinted) {
  const struct {
    std::string text;
    const char* must_say;
  } cases[] = {
      {"", "0 words"},
      {"gps.explode 5s", "'gps.explode' is none of"},
      {"gps.unplug 5s; clear", "'clear' is none of"},
      {"t=3 gps.unplug 5s", "over before it was ordered (the run is at 20 s)"},
      {"gps.unplug never", "'never' is no length"},
      {std::string("gps\0un\x1b[2Jplug\n5s", 18), "gps?un?"},
      {std::string(1001, 'x'), "1001 characters"},
  };
  for (const auto& c : cases) {
    const auto order = ParseFaultOrder(c.text, core::Seconds(20));
    ASSERT_FALSE(order) << c.text;
    EXPECT_NE(order.error().message.find(c.must_say), std::string::npos) << order.error().message;
    for (const char letter : order.error().message) EXPECT_TRUE(letter >= ' ' && letter <= '~');
  }
}

TEST(FaultOrderInbox, HandsOverInOrderAndOnce) {
  FaultOrderInbox inbox;
  ASSERT_TRUE(inbox.Post(*ParseFaultOrder("gps.silent", {})));
  ASSERT_TRUE(inbox.Post(*ParseFaultOrder("clear", {})));
  const auto orders = inbox.Take(0);
  ASSERT_EQ(orders.size(), 2U);
  EXPECT_TRUE(orders[1].clear);
  EXPECT_TRUE(inbox.Take(0).empty());
}

TEST(FaultOrderInbox, RefusesFloodsUntilCleared) {
  FaultOrderInbox inbox;
  (void)inbox.Take(FaultOrderInbox::kMostFaults);
  EXPECT_FALSE(inbox.Post(*ParseFaultOrder("gps.silent", {})));
  EXPECT_TRUE(inbox.Post(*ParseFaultOrder("clear", {})));
  EXPECT_TRUE(inbox.Post(*ParseFaultOrder("gps.silent", {})));
}

}  // namespace
}  // namespace kawara::sim
