#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "corrections_data.hpp"
#include "drivers/ntrip_decoder.hpp"
#include "drivers/ntrip_request.hpp"
#include "drivers/ntrip_source.hpp"
#include "drivers/rtcm3_frame.hpp"

namespace kawara::drivers {
namespace {

using testing::AsBytes;
using testing::Bytes;
using ::testing::HasSubstr;
using ::testing::Not;

struct Answer {
  Bytes payload;
  NtripState state = NtripState::kHead;
  NtripFailure failure = NtripFailure::kNone;
  std::string error;
  std::vector<NtripSource> sources;
  std::uint64_t chunks = 0;
  bool operator==(const Answer& o) const {
    return payload == o.payload && state == o.state && failure == o.failure && error == o.error &&
           chunks == o.chunks && sources.size() == o.sources.size();
  }
};

NtripRequest Request() {
  NtripRequest r;
  r.host = "caster.example";
  r.mountpoint = "TSUK0";
  r.user = "robot";
  r.password = "secret";
  return r;
}

Answer Decode(std::span<const std::uint8_t> bytes, std::size_t longest = SIZE_MAX / 2,
              bool closed = false, bool wants_table = false) {
  Answer a;
  NtripDecoder decoder(wants_table);
  testing::ForPieces(bytes, longest, [&](std::span<const std::uint8_t> piece) {
    while (const auto payload = decoder.Next(piece)) testing::Append(a.payload, *payload);
  });
  if (closed) decoder.OnClosed();
  a.state = decoder.state();
  a.failure = decoder.failure();
  a.sources = decoder.sources();
  a.chunks = decoder.chunks();
  if (a.failure != NtripFailure::kNone) a.error = decoder.Explain(Request()).message;
  return a;
}
Answer Decode(const std::string& text, std::size_t longest = SIZE_MAX / 2, bool closed = false,
              bool wants_table = false) {
  return Decode(AsBytes(text), longest, closed, wants_table);
}

const std::string kData("\xD3\x00\x13\x3E\xD7 data \r\n\x00\xFF", 14);
const std::string kTable =
    "CAS;caster.example;2101;Test;Me;0;JPN;36.1;140.1;0.0.0.0;0;none\r\n"
    "NET;TEST;Me;B;N;none;none;none;none\r\n"
    "STR;TSUK1;Tsukuba;RTCM "
    "3.2;1005(10),1077(1);2;GPS+GLO;TEST;JPN;36.10;140.09;0;0;NetR9;none;B;N;9600;misc;x\r\n"
    "STR;VRS;Net;RTCM "
    "2.3;18(1),19(1),3(10);2;GPS;TEST;JPN;36.0;140.0;1;1;GNR;none;N;Y;4800;none\r\n"
    "ENDSOURCETABLE\r\n";
std::string Chunked(const std::string& body, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < body.size(); i += size) {
    const std::string piece = body.substr(i, size);
    char head[32];
    std::snprintf(head, sizeof(head), "%zX\r\n", piece.size());
    text += head + piece + "\r\n";
  }
  return text;
}

TEST(NtripRequest, VersionOne) {
  NtripRequest r = Request();
  r.version = 1;
  EXPECT_EQ(MakeNtripRequest(r).value(),
            "GET /TSUK0 HTTP/1.0\r\nUser-Agent: NTRIP Kawaraban/1.0\r\n"
            "Authorization: Basic cm9ib3Q6c2VjcmV0\r\n\r\n");
}

TEST(NtripRequest, VersionTwo) {
  NtripRequest r = Request();
  r.gga = "$GPGGA,1*00";
  EXPECT_EQ(MakeNtripRequest(r).value(),
            "GET /TSUK0 HTTP/1.1\r\nHost: caster.example:2101\r\nNtrip-Version: Ntrip/2.0\r\n"
            "User-Agent: NTRIP Kawaraban/1.0\r\nAuthorization: Basic cm9ib3Q6c2VjcmV0\r\n"
            "Ntrip-GGA: $GPGGA,1*00\r\nConnection: close\r\n\r\n");
}

TEST(NtripRequest, WithoutUserOrMountpoint) {
  NtripRequest r;
  r.host = "::1";
  r.version = 2;
  const auto text = MakeNtripRequest(r).value();
  EXPECT_THAT(text, ::testing::StartsWith("GET / HTTP/1.1\r\nHost: [::1]:2101\r\n"));
  EXPECT_THAT(text, Not(HasSubstr("Authorization")));
}

TEST(NtripRequest, NothingThatBreaksTheRequestApart) {
  const auto with = [](auto change) {
    NtripRequest r = Request();
    change(r);
    return MakeNtripRequest(r).has_value();
  };
  EXPECT_TRUE(with([](auto&) {}));
  EXPECT_FALSE(with([](auto& r) { r.host = ""; }));
  EXPECT_FALSE(with([](auto& r) { r.mountpoint = "A B"; }));
  EXPECT_FALSE(with([](auto& r) { r.mountpoint = "A\r\nX-Evil: 1"; }));
  EXPECT_FALSE(with([](auto& r) { r.user = "a:b"; }));
  EXPECT_FALSE(with([](auto& r) { r.password = "a\nb"; }));
  EXPECT_FALSE(with([](auto& r) { r.gga = "$GPGGA\r\n"; }));
  EXPECT_FALSE(with([](auto& r) { r.version = 3; }));
  EXPECT_TRUE(with([](auto& r) { r.password = "two words"; }));
}

core::GnssFix Fix(double lat_deg, double lon_deg) {
  core::GnssFix fix;
  fix.has_position = true;
  fix.rtk = core::RtkState::kAutonomous;
  fix.time = core::ToGps(core::FromCivil({2024, 5, 6, 7, 8, 9, 250'000'000}));
  fix.antenna = {lat_deg * core::kRadFromDeg, lon_deg * core::kRadFromDeg, 66.1};
  fix.geoid_separation_m = 40.0;
  fix.hdop = 0.9;
  fix.satellites = 9;
  return fix;
}

TEST(MakeGga, KnownAnswer) {
  EXPECT_EQ(MakeGga(Fix(36.1059, 140.0871)),
            "$GPGGA,070809.25,3606.35400,N,14005.22600,E,1,09,0.9,26.100,M,40.000,M,,*5B");
}

TEST(MakeGga, SignsRoundingAndUnknowns) {
  EXPECT_THAT(*MakeGga(Fix(-35.9999999999, -0.5)), HasSubstr(",3600.00000,S,00030.00000,W,"));
  auto fix = Fix(1, 2);
  fix.geoid_separation_m = std::numeric_limits<double>::quiet_NaN();
  fix.hdop = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(*MakeGga(fix), HasSubstr(",1.0,66.100,M,,M,,*"));
  for (const auto& [rtk, quality] : std::initializer_list<std::pair<core::RtkState, const char*>>{
           {core::RtkState::kFixed, ",E,4,"},
           {core::RtkState::kFloat, ",E,5,"},
           {core::RtkState::kCodeDifferential, ",E,2,"}}) {
    fix.rtk = rtk;
    EXPECT_THAT(*MakeGga(fix), HasSubstr(quality));
  }
}

TEST(MakeGga, NothingWithoutAFix) {
  auto fix = Fix(1, 2);
  fix.has_position = false;
  EXPECT_FALSE(MakeGga(fix));
  fix = Fix(1, 2);
  fix.rtk = core::RtkState::kNone;
  EXPECT_FALSE(MakeGga(fix));
}

TEST(ParseNtripSource, Fields) {
  const auto s = ParseNtripSource(
      "STR;VRS;Net;RTCM "
      "2.3;18(1),19(1);2;GPS;TEST;JPN;36.0;-140.5;1;1;GNR;none;D;Y;4800;none;more");
  ASSERT_TRUE(s);
  EXPECT_EQ(s->mountpoint, "VRS");
  EXPECT_EQ(s->format, "RTCM 2.3");
  EXPECT_EQ(s->format_details, "18(1),19(1)");
  EXPECT_EQ(s->carrier, 2);
  EXPECT_EQ(s->country, "JPN");
  EXPECT_DOUBLE_EQ(*s->lat_deg, 36.0);
  EXPECT_DOUBLE_EQ(*s->lon_deg, -140.5);
  EXPECT_TRUE(s->needs_gga);
  EXPECT_TRUE(s->is_network);
  EXPECT_EQ(s->authentication, 'D');
  EXPECT_TRUE(s->fee);
  EXPECT_EQ(s->bitrate_bps, 4800);
}

TEST(ParseNtripSource, ShortAndForeignLines) {
  const auto s = ParseNtripSource("STR;A;;;;x;;;;?;;");
  ASSERT_TRUE(s);
  EXPECT_EQ(s->carrier, -1);
  EXPECT_FALSE(s->lat_deg);
  EXPECT_FALSE(s->needs_gga);
  for (const char* line : {"", "STR", "STR;", "STR;;x", "CAS;a;b", "str;A"})
    EXPECT_FALSE(ParseNtripSource(line)) << line;
}

TEST(ListMountpoints, CutsWithACount) {
  std::vector<NtripSource> sources(5);
  for (std::size_t i = 0; i < sources.size(); ++i)
    sources[i].mountpoint = std::string("MOUNT") + std::to_string(i);
  EXPECT_EQ(ListMountpoints(sources, 100), "MOUNT0, MOUNT1, MOUNT2, MOUNT3, MOUNT4");
  EXPECT_EQ(ListMountpoints(sources, 40), "MOUNT0, MOUNT1, MOUNT2 and 2 more");
  EXPECT_EQ(ListMountpoints({}, 40), "none");
}

TEST(NtripDecoder, StreamsOfEveryKind) {
  const std::string v2 =
      "HTTP/1.1 200 OK\r\nNtrip-Version: Ntrip/2.0\r\nContent-Type: gnss/data\r\n";
  struct Case {
    const char* what;
    std::string answer;
  };
  for (const Case& c :
       {Case{"version 1, bare", "ICY 200 OK\r\n" + kData},
        Case{"version 1, blank line", "ICY 200 OK\r\n\r\n" + kData},
        Case{"version 1, headers", "ICY 200 OK\r\nServer: X 1.0\r\nDate: today\r\n\r\n" + kData},
        Case{"version 1, only line feeds", "ICY 200 OK\n\n" + kData},
        Case{"version 2, plain", v2 + "\r\n" + kData},
        Case{"version 2 from a 1.0 server", "HTTP/1.0 200 OK\r\n\r\n" + kData},
        Case{"version 2, chunked", v2 + "Transfer-Encoding: chunked\r\n\r\n" + Chunked(kData, 5)},
        Case{"version 2, chunks of one",
             v2 + "transfer-encoding:CHUNKED\r\n\r\n" + Chunked(kData, 1)},
        Case{"chunk extension",
             v2 + "Transfer-Encoding: chunked\r\n\r\n00e;a=b\r\n" + kData + "\r\n"}}) {
    for (const std::size_t longest : {1000U, 1U, 2U, 3U, 7U}) {
      const Answer a = Decode(c.answer, longest);
      EXPECT_EQ(std::string(a.payload.begin(), a.payload.end()), kData)
          << c.what << " in pieces of " << longest;
      EXPECT_EQ(a.state, NtripState::kStreaming) << c.what;
    }
  }
}

TEST(NtripDecoder, TextDataAfterIcyIsNotTakenForHeaders) {
  for (const std::string data :
       {"fAB@NdMaG^@", "$GPGGA,1,2\r\n", "abc\r\nxyz", "AB:\x01 binary", "Name without colon"}) {
    for (const std::size_t longest : {1000U, 1U}) {
      const Answer a = Decode("ICY 200 OK\r\n" + data + "\x01", longest);
      EXPECT_EQ(std::string(a.payload.begin(), a.payload.end()), data + "\x01");
    }
  }
}

TEST(NtripDecoder, Capture) {
  const std::string head =
      "HTTP/1.1 200 OK\r\nContent-Type: gnss/data\r\nTransfer-Encoding: chunked\r\n\r\n";
  Bytes answer(head.begin(), head.end());
  testing::Append(answer, testing::ReadRecording("ntrip_encode_chunked.bin"));
  const Answer whole = Decode(answer);
  EXPECT_EQ(whole.chunks, 292U);
  EXPECT_EQ(whole.failure, NtripFailure::kNone);
  std::span<const std::uint8_t> rest(whole.payload);
  Rtcm3Framer framer;
  std::uint64_t frames = 0;
  while (framer.Next(rest)) ++frames;
  EXPECT_EQ(frames, 292U);
  EXPECT_EQ(framer.stats().skipped_bytes, 0U) << "nothing of the transfer encoding is left";
  for (const std::size_t longest : {1U, 2U, 13U, 1460U})
    EXPECT_EQ(Decode(answer, longest), whole) << longest;
}

TEST(NtripDecoder, EndOfChunksIsTheEnd) {
  const Answer a = Decode("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n" +
                          Chunked(kData, 6) + "0\r\nX: y\r\n\r\n");
  EXPECT_EQ(a.payload.size(), kData.size());
  EXPECT_EQ(a.failure, NtripFailure::kEnded);
}

TEST(NtripDecoder, BrokenChunksAreSaid) {
  const std::string head = "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n";
  for (const std::string body :
       {"xyz\r\n", "\r\n\r\n", "FFFFFFFFFFFFFFFFFF\r\n", "2000000\r\n", "-5\r\n", "2\r\nabc\r\n"}) {
    EXPECT_EQ(Decode(head + body).failure, NtripFailure::kBrokenChunk) << body;
  }
  EXPECT_EQ(Decode(head + std::string(5000, '1')).failure, NtripFailure::kBrokenChunk);
}

TEST(NtripDecoder, Refusals) {
  struct Case {
    const char* answer;
    NtripFailure failure;
    const char* says;
  };
  for (const Case& c :
       {Case{"ERROR - Bad Password\r\n", NtripFailure::kWrongPassword,
             "user 'robot' or its password refused for TSUK0"},
        Case{"ERROR - Bad Password", NtripFailure::kWrongPassword, "refused"},
        Case{"ERROR - Mount Point Taken or Invalid\r\n", NtripFailure::kWrongMountpoint,
             "no mountpoint 'TSUK0'"},
        Case{"HTTP/1.0 401 Unauthorized\r\nWWW-Authenticate: Basic realm=\"/X\"\r\n\r\n",
             NtripFailure::kWrongPassword, "401"},
        Case{"HTTP/1.1 401 Unauthorized\r\nWWW-Authenticate: Digest realm=\"/X\"\r\n\r\n",
             NtripFailure::kWrongPassword, "Digest"},
        Case{"HTTP/1.1 404 Not Found\r\nContent-Type: text/html\r\n\r\n<html>",
             NtripFailure::kWrongMountpoint, "no mountpoint 'TSUK0'"},
        Case{"HTTP/1.1 409 Conflict\r\n\r\n", NtripFailure::kMountpointInUse, "in use"},
        Case{"HTTP/1.1 301 Moved\r\nLocation: http://new.example/TSUK0\r\n\r\n",
             NtripFailure::kRedirected, "http://new.example/TSUK0"},
        Case{"HTTP/1.1 503 Busy\r\n\r\n", NtripFailure::kServerError, "503"},
        Case{"HTTP/1.1 200 OK\r\nContent-Type: text/html\r\n\r\n<html>", NtripFailure::kNotNtrip,
             "check host and port"},
        Case{"HTTP/1.1 200 OK\r\nContent-Encoding: gzip\r\n\r\n", NtripFailure::kEncoding, "gzip"},
        Case{"SSH-2.0-OpenSSH_9.2\r\n", NtripFailure::kNotNtrip, "SSH-2.0"},
        Case{"", NtripFailure::kEnded, "without an answer"},
        Case{"ICY 200 OK\r\n\r\n", NtripFailure::kEnded, "closed the stream"}}) {
    for (const std::size_t longest : {1000U, 1U}) {
      const Answer a = Decode(std::string(c.answer), longest, true);
      EXPECT_EQ(a.state, NtripState::kDone) << c.answer;
      EXPECT_EQ(a.failure, c.failure) << c.answer;
      EXPECT_THAT(a.error, HasSubstr(c.says)) << c.answer;
      EXPECT_THAT(a.error, HasSubstr("caster.example:2101")) << c.answer;
      EXPECT_THAT(a.error, Not(HasSubstr("secret"))) << "passwords stay out of logs";
    }
  }
}

TEST(NtripDecoder, SourcetableInsteadOfData) {
  for (const std::string& head :
       {std::string("SOURCETABLE 200 OK\r\nServer: X\r\nContent-Type: text/plain\r\n\r\n"),
        std::string("SOURCETABLE 200 OK\r\n"),
        std::string("HTTP/1.1 200 OK\r\nContent-Type: gnss/sourcetable\r\n\r\n")}) {
    for (const std::size_t longest : {5000U, 1U, 10U}) {
      const Answer a = Decode(head + kTable, longest);
      EXPECT_EQ(a.failure, NtripFailure::kWrongMountpoint) << head;
      ASSERT_EQ(a.sources.size(), 2U) << head;
      EXPECT_TRUE(a.sources[1].needs_gga);
      EXPECT_THAT(a.error, HasSubstr("no mountpoint 'TSUK0'; it offers TSUK1, VRS"));
      EXPECT_TRUE(a.payload.empty());
    }
  }
}

TEST(NtripDecoder, SourcetableChunkedWithLengthOrCutShort) {
  const std::string v2 = "HTTP/1.1 200 OK\r\nContent-Type: gnss/sourcetable\r\n";
  EXPECT_EQ(Decode(v2 + "Transfer-Encoding: chunked\r\n\r\n" + Chunked(kTable, 11)).sources.size(),
            2U);
  const std::string without_end = kTable.substr(0, kTable.find("ENDSOURCETABLE"));
  const Answer by_length = Decode(v2 + "Content-Length: " + std::to_string(without_end.size()) +
                                  "\r\n\r\n" + without_end);
  EXPECT_EQ(by_length.state, NtripState::kDone);
  EXPECT_EQ(by_length.sources.size(), 2U);
  EXPECT_EQ(Decode(v2 + "\r\n" + without_end, 100, true).sources.size(), 2U);
}

TEST(NtripDecoder, SourcetableThatWasAskedFor) {
  const Answer a = Decode("SOURCETABLE 200 OK\r\n\r\n" + kTable, 1000, false, true);
  EXPECT_EQ(a.state, NtripState::kDone);
  EXPECT_EQ(a.failure, NtripFailure::kNone);
  EXPECT_EQ(a.sources.size(), 2U);
}

TEST(NtripDecoder, LongLinesDoNotGrowMemory) {
  EXPECT_EQ(Decode(std::string(1'000'000, 'A')).failure, NtripFailure::kNotNtrip);
  const Answer a =
      Decode("HTTP/1.1 200 OK\r\nX-Long: " + std::string(100'000, 'A') + "\r\n\r\n" + kData);
  EXPECT_EQ(a.payload.size(), kData.size());
}

}  // namespace
}  // namespace kawara::drivers
