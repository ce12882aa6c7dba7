#include "sim/virtual/virtual_port.hpp"

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <vector>

#include "sim/virtual/virtual_link.hpp"

namespace kawara::sim {
namespace {

core::MonoTime At(double s) { return core::MonoTime::FromNs(0) + core::DurationFromSeconds(s); }
std::span<const std::uint8_t> Bytes(std::string_view text) { return onboard::BytesOf(text); }

TEST(VirtualPort, TheHostsBytesLeaveAtItsBaudRate) {
  VirtualPort port("gps");
  ASSERT_TRUE(port.Open(1000));  // 10 ms a byte
  port.HostWrite(At(1), Bytes("abcd"));
  std::array<std::uint8_t, 16> buffer{};
  port.SetTime(At(1.025));
  EXPECT_EQ(port.Read(buffer), 2U);
  EXPECT_EQ(port.NextByteOut(), At(1.03));
  port.SetTime(At(2));
  EXPECT_EQ(port.Read(buffer), 2U);
  EXPECT_EQ(buffer[1], 'd');
  EXPECT_FALSE(port.NextByteOut().IsSet());
}

TEST(VirtualPort, UnpluggedItForgetsAndClosesAndComesBackClosed) {
  VirtualPort port("gps");
  ASSERT_TRUE(port.Open(9600));
  EXPECT_EQ(port.Write(Bytes("abc")), 3U);
  port.Unplug();
  EXPECT_FALSE(port.plugged());
  EXPECT_EQ(port.waiting(), 0U);
  EXPECT_FALSE(port.Open(9600));
  ASSERT_TRUE(port.Replug());
  EXPECT_FALSE(port.host().open);
  EXPECT_TRUE(port.Open(9600));
}

/// What a link has to tell, as text.
class Listening : public ::testing::Test {
 protected:
  void Service(double s) {
    link_.Service(At(s), [this](const onboard::PortNote& note) {
      told_.push_back(std::string(note.changed ? (note.open ? "+" : "-") : " ") +
                      std::string(note.text));
    });
  }
  VirtualPort port_{"gps"};
  VirtualLink link_{onboard::PortId::kGps, "gps", 9600, port_};
  std::vector<std::string> told_;
};

TEST_F(Listening, DatesTheFirstByteAsItWasOnTheWire) {
  Service(1);
  port_.Write(Bytes("0123456789"));
  // Ten bytes at 9600 baud take 10.4 ms; read when the last is in, the first came nine earlier.
  const auto bytes = link_.Read(At(1.5));
  EXPECT_EQ(bytes.size(), 10U);
  EXPECT_NEAR(core::ToSeconds(link_.first_byte() - At(1.5)), -9 * 10 / 9600.0, 1e-6);
  // Never before the line was last found empty.
  EXPECT_TRUE(link_.Read(At(1.501)).empty());
  port_.Write(Bytes("0123456789"));
  EXPECT_FALSE(link_.Read(At(1.502)).empty());
  EXPECT_EQ(link_.first_byte(), At(1.501));
}

TEST_F(Listening, TellsOfOpeningSilenceLossAndReturn) {
  Service(1);
  Service(4.5);
  port_.Write(Bytes("x"));
  (void)link_.Read(At(5));
  Service(5);
  port_.Unplug();
  for (double s = 6; s < 8; s += 0.02) Service(s);
  ASSERT_TRUE(port_.Replug());
  for (double s = 8; s < 11; s += 0.02) Service(s);
  ASSERT_EQ(told_.size(), 6U);
  EXPECT_EQ(told_[0], "+opened gps: 9600 8N1");
  EXPECT_NE(told_[1].find("open, but no byte for 3.5 s"), std::string::npos) << told_[1];
  EXPECT_EQ(told_[2], " gps: bytes again");
  EXPECT_EQ(told_[3].substr(0, 9), "-lost gps");
  EXPECT_EQ(told_[4].substr(0, 9), " open gps");
  EXPECT_EQ(told_[5], "+opened gps: 9600 8N1");
}

}  // namespace
}  // namespace kawara::sim
