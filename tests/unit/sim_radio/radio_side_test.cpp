#include <arpa/inet.h>
#include <gtest/gtest.h>

#include "sim/radio/radio_relay.hpp"

namespace kawara::sim {
namespace {

TEST(RadioSide, IsReadAsLcmWritesIt) {
  const auto side = ParseRadioSide("udpm://239.255.1.2:7668?recv_buf_size=100000&ttl=1");
  ASSERT_TRUE(side) << side.error().message;
  EXPECT_EQ(ntohl(side->group.s_addr), 0xEFFF0102U);
  EXPECT_EQ(side->port, 7668);
  EXPECT_EQ(side->ttl, 1);
  EXPECT_EQ(ParseRadioSide("udpm://239.255.76.67:7667")->ttl, 0);
}

TEST(RadioSide, MistakesAreNamed) {
  const struct {
    const char* url;
    const char* must_say;
  } cases[] = {{"", "udpm://"},
               {"memq://", "udpm://"},
               {"udpm://239.255.76.67", "no port"},
               {"udpm://10.0.0.1:7667", "no multicast address"},
               {"udpm://x:7667", "no multicast address"},
               {"udpm://239.255.76.67:0", "wrong port"},
               {"udpm://239.255.76.67:70000", "wrong port"},
               {"udpm://239.255.76.67:7667?ttl=-1", "wrong ttl"}};
  for (const auto& c : cases) {
    const auto side = ParseRadioSide(c.url);
    ASSERT_FALSE(side) << c.url;
    EXPECT_EQ(side.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_NE(side.error().message.find(c.must_say), std::string::npos) << side.error().message;
  }
}

TEST(RadioRelay, TheSameBusOnBothSidesIsRefused) {
  const auto relay = RadioRelay::Open({.robot_url = "udpm://239.255.76.67:7667?ttl=0",
                                       .base_url = "udpm://239.255.76.67:7667?ttl=1"});
  ASSERT_FALSE(relay);
  EXPECT_NE(relay.error().message.find("same bus"), std::string::npos);
}

}  // namespace
}  // namespace kawara::sim
