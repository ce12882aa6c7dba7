#include "sim/faults/fault_command.hpp"

#include <gtest/gtest.h>

namespace kawara::sim {
namespace {

TEST(FaultCommand, ChannelNamesThatAreNoneAreRefusedBeforeAnyBusIsOpened) {
  const std::atomic<bool> stop{false};
  for (const char* channel : {"", "A|B", "SIM FAULT", ".*", "tab\t"}) {
    const auto answer = SendFaultOrder("memq://", channel, "clear", core::Milliseconds(1), stop);
    ASSERT_FALSE(answer) << channel;
    EXPECT_EQ(answer.error().code, core::ErrorCode::kInvalidArgument) << channel;
    EXPECT_NE(answer.error().message.find("command channel"), std::string::npos);
  }
}

TEST(FaultCommand, NobodyThereIsSaid) {
  const std::atomic<bool> stop{false};
  const auto answer = SendFaultOrder("memq://", "SIM.FAULT", "clear", core::Milliseconds(50), stop);
  ASSERT_FALSE(answer);
  EXPECT_EQ(answer.error().code, core::ErrorCode::kUnavailable);
  EXPECT_NE(answer.error().message.find("nobody answered on SIM.FAULT"), std::string::npos);
}

}  // namespace
}  // namespace kawara::sim
