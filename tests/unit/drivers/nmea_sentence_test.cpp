#include "drivers/nmea_sentence.hpp"

#include <gtest/gtest.h>

#include "tests/support/gnss_recording.hpp"

namespace kawara::drivers {
namespace {

using testing::ToBytes;

NmeaProbeResult Probe(const std::string& text) {
  static testing::Bytes bytes;  // the result has views into it
  bytes = ToBytes(text);
  return NmeaProbe(bytes);
}

TEST(NmeaProbe, TakesAddressAndFieldsApart) {
  const auto gga = Probe(testing::Sentence("GPGGA,1,2"));
  ASSERT_EQ(gga.match, NmeaMatch::kSentence);
  EXPECT_EQ(gga.length, 13U);
  EXPECT_EQ(gga.sentence.address, "GPGGA");
  EXPECT_EQ(gga.sentence.talker(), "GP");
  EXPECT_EQ(gga.sentence.type(), "GGA");
  EXPECT_EQ(gga.sentence.fields, "1,2");
  const auto ack = Probe("$PASHR,ACK*3D");
  ASSERT_EQ(ack.match, NmeaMatch::kSentence);
  EXPECT_TRUE(ack.sentence.is_proprietary());
  EXPECT_EQ(ack.sentence.type(), "ASHR");
}

TEST(NmeaProbe, ManualsKnownAnswers) {
  for (const char* text : {"$PASHR,ACK*3D", "$PASHR,NAK*30", "$PASHR,TTT,4,03:32:45.0111305*0E",
                           "$PASHR,LTN,29*05", "$PASHR,PHE,R*57", "$PASHR,PPS,1,500,R*5D",
                           "$PASHS,PPS,2,+500,R*74", "$PASHR,XMG,12,Solution valid*4A"}) {
    EXPECT_EQ(Probe(text).match, NmeaMatch::kSentence) << text;
  }
}

TEST(NmeaProbe, ChecksumDigitsOfEitherCase) {
  EXPECT_EQ(Probe("$PASHR,ACK*3d").match, NmeaMatch::kSentence);
  EXPECT_EQ(Probe("$PASHR,ACK*3D").match, NmeaMatch::kSentence);
  EXPECT_EQ(Probe("$PASHR,ACK*3E").match, NmeaMatch::kBadChecksum);
}

TEST(NmeaProbe, EveryPrefixOfASentenceNeedsMore) {
  const std::string text =
      "$GNGGA,132819.60,4134.49795459,N,09345.03431408,W,2,10,0.9,278.161,M,-31.442,M,6.6,0133*6A";
  for (std::size_t n = 1; n < text.size(); ++n)
    EXPECT_EQ(Probe(text.substr(0, n)).match, NmeaMatch::kNeedMore) << n;
  EXPECT_EQ(Probe(text).match, NmeaMatch::kSentence);
}

TEST(NmeaProbe, WhatIsNoSentence) {
  for (const char* text : {"GPGGA,1*00", "$,1*00", "$GP,1*00", "$gpgga,1*00", "$GPGGA;1*00",
                           "$GPGGA,1\r\n*00", "$GPGGA,1$GPGGA", "$GPGGA,1*G0", "$GPGGA,1*0G",
                           "$ABCDEFGHIJKLMNOP,1*00", "$GPGGA,\x80*00"}) {
    EXPECT_EQ(Probe(text).match, NmeaMatch::kNoMatch) << text;
  }
}

TEST(NmeaProbe, LengthHasALimitFarAbove82) {
  const auto sentence = [](std::size_t total) {
    return testing::Sentence(
        "GPTXT," + std::string(total - 10, 'x'));  // '$' + 6 + '*' + 2 + CR LF not counted
  };
  EXPECT_EQ(Probe(sentence(100)).match, NmeaMatch::kSentence);
  EXPECT_EQ(Probe(sentence(kNmeaMaxBytes - 1)).match, NmeaMatch::kSentence);
  EXPECT_EQ(Probe(sentence(kNmeaMaxBytes + 20)).match, NmeaMatch::kNoMatch);
}

}  // namespace
}  // namespace kawara::drivers
