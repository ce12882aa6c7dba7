#include "sim/instruments/uart.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <string>

namespace kawara::sim {
namespace {

const core::MonoTime kStart = core::MonoTime::FromNs(1'000'000'000);

std::vector<std::uint8_t> Counting(std::size_t n) {
  std::vector<std::uint8_t> bytes(n);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});
  return bytes;
}

TEST(UartTransmitter, ByteLeavesAfterTenBitTimes) {
  UartTransmitter uart(9600);
  uart.Send(kStart, Counting(2));
  const core::Duration byte_time = core::Nanoseconds(1'041'666);
  EXPECT_TRUE(uart.TakeSent(kStart + byte_time - core::Nanoseconds(1)).bytes.empty());
  EXPECT_EQ(uart.TakeSent(kStart + byte_time).bytes, (std::vector<std::uint8_t>{0}));
  EXPECT_EQ(uart.NextSent(), kStart + 2 * byte_time);
  EXPECT_EQ(uart.TakeSent(kStart + 2 * byte_time).bytes, (std::vector<std::uint8_t>{1}));
  EXPECT_FALSE(uart.NextSent().IsSet());
}

TEST(UartTransmitter, ScheduleIsAbsoluteHoweverOftenItIsAsked) {
  UartTransmitter often(38400);
  UartTransmitter seldom(38400);
  const auto message = Counting(300);
  often.Send(kStart, message);
  seldom.Send(kStart, message);
  std::size_t total = 0;
  for (int ms = 1; ms <= 50; ++ms)
    total += often.TakeSent(kStart + core::Milliseconds(ms)).bytes.size();
  EXPECT_EQ(total, seldom.TakeSent(kStart + core::Milliseconds(50)).bytes.size());
  EXPECT_EQ(total, 192U);  // 50 ms of 3840 bytes a second
}

TEST(UartTransmitter, MessagesQueueBehindEachOther) {
  UartTransmitter uart(115200);
  uart.Send(kStart, Counting(115));
  uart.Send(kStart, Counting(115));
  EXPECT_NEAR(core::ToSeconds(uart.FreeAt(kStart) - kStart), 230 * 10 / 115200.0, 1e-6);
}

TEST(UartTransmitter, FullBufferDropsTheWholeMessageAndCountsIt) {
  UartTransmitter uart(9600, 100);
  EXPECT_TRUE(uart.Send(kStart, Counting(60)));
  EXPECT_FALSE(uart.Send(kStart, Counting(60)));
  EXPECT_EQ(uart.dropped_messages(), 1U);
  EXPECT_EQ(uart.TakeSent(kStart + core::Seconds(1)).bytes.size(), 60U);
}

TEST(UartTransmitter, ChangeOfRateHoldsForWhatIsQueuedLater) {
  UartTransmitter uart(9600);
  uart.Send(kStart, Counting(1));
  uart.SetBaud(115200);
  uart.Send(kStart, Counting(1));
  const core::MonoTime late = kStart + core::Seconds(1);
  EXPECT_EQ(uart.TakeSent(late).baud_bps, 9600);
  EXPECT_EQ(uart.TakeSent(late).baud_bps, 115200);
}

TEST(WrongBaud, SameRateIsTheIdentity) {
  const auto sent = Counting(256);
  EXPECT_EQ(ReceiveAtWrongBaud(sent, 38400, 38400), sent);
}

TEST(WrongBaud, AFewPercentStillReads) {
  const auto sent = Counting(256);
  EXPECT_EQ(ReceiveAtWrongBaud(sent, 39168, 38400), sent);
  EXPECT_EQ(ReceiveAtWrongBaud(sent, 37632, 38400), sent);
}

TEST(WrongBaud, KnownAnswerAtDoubleRate) {
  // 0x0F on the line: start 0, data 1111 0000, stop 1. Twice as fast the eight data samples lie at
  // 0.75, 1.25 ... 4.25 sender's bits after the edge: the rest of the start bit, then seven ones;
  // least significant first.
  const std::vector<std::uint8_t> sent{0x0F};
  const auto received = ReceiveAtWrongBaud(sent, 9600, 19200);
  ASSERT_GE(received.size(), 1U);
  EXPECT_EQ(received[0], 0xFE);
}

TEST(WrongBaud, TextBecomesOtherBytes) {
  const std::string text = "$GPGGA,193503.74,4005.8209120,N,10508.8138920,W,3,22,0.7,1615.5670,M";
  const std::vector<std::uint8_t> sent(text.begin(), text.end());
  for (const auto& [from, to] :
       {std::pair{9600, 115200}, {115200, 9600}, {38400, 57600}, {57600, 38400}}) {
    const auto received = ReceiveAtWrongBaud(sent, from, to);
    EXPECT_FALSE(received.empty());
    const std::string as_text(received.begin(), received.end());
    EXPECT_EQ(as_text.find("GGA"), std::string::npos);
  }
}

}  // namespace
}  // namespace kawara::sim
