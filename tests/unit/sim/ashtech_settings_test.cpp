#include "sim/instruments/ashtech_settings.hpp"

#include <gtest/gtest.h>

namespace kawara::sim {
namespace {

constexpr const char* kAck = "$PASHR,ACK*3D\r\n";
constexpr const char* kNak = "$PASHR,NAK*30\r\n";

std::string Say(AshtechSettings& settings, const char* line) {
  return ObeyAshtech(line, 0, settings).text;
}
bool IsOn(const AshtechSettings& s, int port, AshtechMessage m) {
  return s.ports[static_cast<std::size_t>(port)].on[static_cast<std::size_t>(m)];
}

TEST(AshtechCommands, WhatIsAcceptedAndWhatIsNot) {
  const struct {
    const char* line;
    bool accepted;
  } cases[] = {
      {"$PASHS,NME,GGA,A,ON", true},
      {"$PASHS,NME,GGA,A,ON*1E", true},
      {"$PASHS,NME,GGA,A,ON*1F", false},
      {"$PASHS,NME,GGA,A,ON*1", false},
      {"$PASHS,NME,GGA,E,ON", false},
      {"$PASHS,NME,GGA,A", false},
      {"$PASHS,NME,XYZ,A,ON", false},
      {"$PASHS,NME,CBN,A,ON", false},
      {"$PASHS,NME,ALL,A,OFF", true},
      {"$PASHS,NME,ALL,A,ON", false},
      {"$PASHS,NME,PER,0.1", true},
      {"$PASHS,NME,PER,0.05", false},
      {"$PASHS,NME,PER,nan", false},
      {"$PASHS,RCI,0.5", true},
      {"$PASHS,RCI,x", false},
      {"$PASHS,OUT,A,CBN", true},
      {"$PASHS,OUT,A,CBN,ASC", true},
      {"$PASHS,OUT,A,CBN,BIN", false},
      {"$PASHS,OUT,A", true},
      {"$PASHS,OUT", false},
      {"$PASHS,SPD,A,9", true},
      {"$PASHS,SPD,A,10", false},
      {"$PASHS,PPS,1,+0.5,R", true},
      {"$PASHS,PPS,61", false},
      {"$PASHS,PPS,1,1000", false},
      {"$PASHS,PPS,1,0,X", false},
      {"$PASHS,PHE,F", true},
      {"$PASHS,PHE,X", false},
      {"$PASHS,RTC,REM,B", true},
      {"$PASHS,RTC,REM", false},
      {"$PASHS,CPD,MOD,ROV", true},
      {"$PASHS,CPD,MOD,BAS", false},
      {"$PASHS,CPD,DYN,3", true},
      {"$PASHS,CPD,FST,ON", true},
      {"$PASHS,SAV,Y", true},
      {"$PASHS,SAV,M", false},
      {"$PASHS,RST", true},
      {"$PASHS", false},
      {"$PASHQ", false},
      {"$PASHX,NME", false},
      {"PASHS,RST", false},
      {"$", false},
      {"$PASHQ,NOPE", false},
      {"$PASHQ,TTT", false},
  };
  for (const auto& c : cases) {
    AshtechSettings settings;
    EXPECT_EQ(Say(settings, c.line), c.accepted ? kAck : kNak) << c.line;
  }
}

TEST(AshtechCommands, RefusedCommandChangesNothing) {
  AshtechSettings settings;
  Say(settings, "$PASHS,NME,GGA,A,ON*00");
  Say(settings, "$PASHS,PPS,1,0,X");
  EXPECT_FALSE(IsOn(settings, 0, AshtechMessage::kGga));
  EXPECT_EQ(settings.pps_edge, 'R');
}

TEST(AshtechCommands, SentencesBelongToTheirPort) {
  AshtechSettings settings;
  Say(settings, "$PASHS,NME,POS,B,ON");
  Say(settings, "$PASHS,OUT,A,CBN");
  EXPECT_FALSE(IsOn(settings, 0, AshtechMessage::kPos));
  EXPECT_TRUE(IsOn(settings, 1, AshtechMessage::kPos));
  Say(settings, "$PASHS,NME,ALL,A,OFF");
  EXPECT_TRUE(IsOn(settings, 0, AshtechMessage::kCbn)) << "CBN is raw output, not NMEA";
  Say(settings, "$PASHS,OUT,A");
  EXPECT_FALSE(IsOn(settings, 0, AshtechMessage::kCbn));
}

TEST(AshtechCommands, RemoteBeforeRoverKeepsCpdAliveTheOtherWayRoundKillsIt) {
  AshtechSettings good;
  Say(good, "$PASHS,RTC,REM,B");
  Say(good, "$PASHS,CPD,MOD,ROV");
  EXPECT_TRUE(good.cpd_works);
  AshtechSettings bad;
  Say(bad, "$PASHS,CPD,MOD,ROV");
  Say(bad, "$PASHS,RTC,REM,B");
  EXPECT_FALSE(bad.cpd_works);
  Say(bad, "$PASHS,CPD,MOD,ROV");
  EXPECT_TRUE(bad.cpd_works) << "saying it again in the right order mends it";
}

TEST(AshtechCommands, QueriesAnswerWhatWasSet) {
  AshtechSettings settings;
  Say(settings, "$PASHS,SPD,A,9");
  Say(settings, "$PASHS,PPS,2,+500,R");
  EXPECT_EQ(Say(settings, "$PASHQ,PRT"), WithChecksum("PASHR,PRT,A,9"));
  EXPECT_EQ(Say(settings, "$PASHQ,PRT,B"), WithChecksum("PASHR,PRT,B,5"));
  EXPECT_EQ(Say(settings, "$PASHQ,PHE"), "$PASHR,PHE,R*57\r\n");
  EXPECT_EQ(Say(settings, "$PASHQ,PPS"), WithChecksum("PASHR,PPS,2,500,R"));
  EXPECT_EQ(Say(settings, "$PASHQ,RID").rfind("$PASHR,RID,UZ,30,", 0), 0U);
  EXPECT_NE(Say(settings, "$PASHQ,PAR").find("CPD MODE: OFF"), std::string::npos);
  EXPECT_EQ(ObeyAshtech("$PASHQ,GGA", 0, settings).once, AshtechMessage::kGga);
}

TEST(AshtechCommands, ResetGoesBackToEverythingOffAt9600) {
  AshtechSettings settings;
  Say(settings, "$PASHS,SPD,A,9");
  Say(settings, "$PASHS,NME,GGA,A,ON");
  Say(settings, "$PASHS,RST");
  EXPECT_EQ(AshtechBaud(settings.ports[0].baud_code), 9600);
  EXPECT_TRUE(settings.ports[0].on.none());
}

TEST(AshtechChecksum, KnownLines) {
  EXPECT_EQ(WithChecksum("PASHR,TTT,4,03:32:45.0111305"), "$PASHR,TTT,4,03:32:45.0111305*0E\r\n");
  EXPECT_EQ(WithChecksum("PASHR,LTN,29"), "$PASHR,LTN,29*05\r\n");
  EXPECT_EQ(WithChecksum("PASHR,PPS,1,500,R"), "$PASHR,PPS,1,500,R*5D\r\n");
}

TEST(AshtechBaudCodes, RoundTrip) {
  for (int code = 0; code <= 9; ++code) EXPECT_EQ(AshtechBaudCode(AshtechBaud(code)), code);
  EXPECT_EQ(AshtechBaud(10), 0);
  EXPECT_FALSE(AshtechBaudCode(1234));
}

}  // namespace
}  // namespace kawara::sim
