#include "drivers/ntrip_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "corrections_data.hpp"
#include "small_caster.hpp"

namespace kawara::drivers {
namespace {

using ::testing::HasSubstr;
using testing::SmallCaster;

constexpr core::Duration kPatience = core::Seconds(20);  // a busy machine, not a promise of speed

/// A client against a scripted caster, in real time.
class Session {
 public:
  explicit Session(std::uint16_t port, int version = 2, std::string mountpoint = "TSUK0",
                   std::string password = "secret")
      : client_(Config(port, version, std::move(mountpoint), std::move(password)), events_,
                [this](core::MonoTime, std::span<const std::uint8_t> bytes) {
                  testing::Append(received, bytes);
                }) {}

  static NtripClientConfig Config(std::uint16_t port, int version, std::string mountpoint,
                                  std::string password) {
    NtripClientConfig c;
    c.caster.host = "127.0.0.1";
    c.caster.port = port;
    c.caster.version = version;
    c.caster.mountpoint = std::move(mountpoint);
    c.caster.user = "robot";
    c.caster.password = std::move(password);
    c.backoff_first = core::Milliseconds(20);
    c.backoff_refused = core::Milliseconds(40);
    c.silent_timeout = core::Milliseconds(300);
    c.position_period = core::Milliseconds(50);
    return c;
  }

  /// Runs until `done` or patience is over.
  template <class Done>
  bool RunUntil(Done done) {
    const core::MonoTime end = core::MonoNow() + kPatience;
    while (core::MonoNow() < end) {
      client_.Service(core::MonoNow());
      Collect();
      if (done()) return true;
      client_.Wait(core::MonoNow(), core::Milliseconds(20));
    }
    return false;
  }
  bool Saw(const std::string& name) const {
    return std::any_of(events.begin(), events.end(), [&](const auto& e) { return e.name == name; });
  }
  std::string Text(const std::string& name) const {
    for (const auto& e : events) {
      if (e.name == name) return std::string(e.text.view());
    }
    return "";
  }
  NtripClient& client() { return client_; }

  testing::Bytes received;
  std::vector<core::Event> events;

 private:
  void Collect() {
    core::Event event;
    while (events_.TryPop(event)) events.push_back(event);
  }
  core::Events events_{core::Duration(0)};
  NtripClient client_;
};

const std::string kPayload = "\xD3 some corrections \x01\x02\x03";
const std::string kChunked =
    "HTTP/1.1 200 OK\r\nContent-Type: gnss/data\r\nTransfer-Encoding: chunked\r\n\r\n";
std::string AsChunks(const std::string& text) {
  std::string chunks;
  for (const char c : text) chunks += "1\r\n" + std::string(1, c) + "\r\n";
  return chunks;
}

TEST(NtripClient, StreamsFromVersionOne) {
  SmallCaster caster(
      [](int, const std::string&) { return SmallCaster::Answer{"ICY 200 OK\r\n" + kPayload}; });
  Session session(caster.port(), 1);
  ASSERT_TRUE(session.RunUntil([&] { return session.received.size() == kPayload.size(); }));
  EXPECT_EQ(std::string(session.received.begin(), session.received.end()), kPayload);
  EXPECT_THAT(caster.request(), HasSubstr("GET /TSUK0 HTTP/1.0\r\n"));
  EXPECT_THAT(caster.request(), HasSubstr("Authorization: Basic cm9ib3Q6c2VjcmV0\r\n"));
  EXPECT_EQ(session.client().state(), NtripClient::State::kStreaming);
  EXPECT_THAT(session.Text("ntrip.streaming"), HasSubstr("streaming TSUK0"));
}

TEST(NtripClient, StreamsFromVersionTwoInChunks) {
  SmallCaster caster(
      [&](int, const std::string&) { return SmallCaster::Answer{kChunked + AsChunks(kPayload)}; });
  Session session(caster.port());
  ASSERT_TRUE(session.RunUntil([&] { return session.received.size() == kPayload.size(); }));
  EXPECT_EQ(std::string(session.received.begin(), session.received.end()), kPayload);
}

TEST(NtripClient, ConnectsAnewWhenTheCasterDropsIt) {
  SmallCaster caster([&](int, const std::string&) {
    return SmallCaster::Answer{kChunked + AsChunks(kPayload), true};
  });
  Session session(caster.port());
  ASSERT_TRUE(session.RunUntil([&] { return session.client().stats().streams >= 3; }));
  EXPECT_GE(caster.connections(), 3);
  EXPECT_GE(session.client().stats().failures, 2U);
  EXPECT_THAT(session.Text("ntrip.ended"), HasSubstr("closed the stream of TSUK0; next try in"));
}

TEST(NtripClient, SaysWrongPassword) {
  for (const std::string answer :
       {"ERROR - Bad Password\r\n", "HTTP/1.1 401 Unauthorized\r\n\r\n"}) {
    SmallCaster caster([&](int, const std::string&) { return SmallCaster::Answer{answer, true}; });
    Session session(caster.port(), 2, "TSUK0", "wrong");
    ASSERT_TRUE(session.RunUntil([&] { return session.Saw("ntrip.refused"); })) << answer;
    EXPECT_THAT(session.Text("ntrip.refused"),
                HasSubstr("user 'robot' or its password refused for TSUK0"));
    EXPECT_EQ(session.events.back().severity, core::Severity::kWarnHigh);
    EXPECT_TRUE(session.received.empty());
  }
}

TEST(NtripClient, SaysWrongMountpointAndWhatThereIs) {
  const std::string table =
      "STR;TSUK1;a;RTCM 3.2;;;;;;;;0\r\nSTR;MITO;b;RTCM 3.2;;;;;;;;0\r\nENDSOURCETABLE\r\n";
  for (const std::string head : {"SOURCETABLE 200 OK\r\n\r\n",
                                 "HTTP/1.1 200 OK\r\nContent-Type: gnss/sourcetable\r\n\r\n"}) {
    SmallCaster caster([&](int, const std::string&) { return SmallCaster::Answer{head + table}; });
    Session session(caster.port(), 2, "NOWHERE");
    ASSERT_TRUE(session.RunUntil([&] { return session.Saw("ntrip.refused"); })) << head;
    EXPECT_THAT(session.Text("ntrip.refused"),
                HasSubstr("no mountpoint 'NOWHERE'; it offers TSUK1, MITO"));
  }
}

TEST(NtripClient, SaysThatNobodyListens) {
  std::uint16_t port = 0;
  {
    SmallCaster gone([](int, const std::string&) { return SmallCaster::Answer{}; });
    port = gone.port();
  }
  Session session(port);
  ASSERT_TRUE(session.RunUntil([&] { return session.Saw("ntrip.connect"); }));
  EXPECT_THAT(session.Text("ntrip.connect"),
              HasSubstr("connection refused: is the caster running"));
}

TEST(NtripClient, SaysThatTheNameIsUnknown) {
  core::Events events{core::Duration(0)};
  NtripClientConfig config = Session::Config(2101, 2, "X", "y");
  config.caster.host = "no-such-host.invalid";
  NtripClient client(config, events, nullptr);
  client.Service(core::MonoNow());
  EXPECT_THAT(client.last_error(), HasSubstr("name not resolved"));
  EXPECT_EQ(client.state(), NtripClient::State::kPausing);
}

TEST(NtripClient, SilentCasterIsLeft) {
  SmallCaster caster(
      [&](int, const std::string&) { return SmallCaster::Answer{"ICY 200 OK\r\n"}; });
  Session session(caster.port(), 1);
  ASSERT_TRUE(session.RunUntil([&] { return session.Saw("ntrip.silent"); }));
  EXPECT_THAT(session.Text("ntrip.silent"),
              HasSubstr("perhaps it waits for our position, and there is no fix yet"));
  ASSERT_TRUE(session.RunUntil([&] { return caster.connections() >= 2; }));
}

core::GnssFix Fix(core::RtkState rtk) {
  core::GnssFix fix;
  fix.arrival = core::MonoNow();
  fix.time = core::ToGps(core::FromCivil({2024, 5, 6, 7, 8, 9, 0}));
  fix.has_position = true;
  fix.rtk = rtk;
  fix.antenna = {0.6, 2.4, 66.0};
  return fix;
}

TEST(NtripClient, UploadsThePositionOnceThereIsAFixAndAgain) {
  SmallCaster caster([&](int, const std::string&) {
    return SmallCaster::Answer{"ICY 200 OK\r\n\r\n" + kPayload};
  });
  Session session(caster.port(), 1);
  ASSERT_TRUE(
      session.RunUntil([&] { return session.client().state() == NtripClient::State::kStreaming; }));
  session.client().OnFix(Fix(core::RtkState::kNone));
  session.client().Service(core::MonoNow());
  EXPECT_EQ(session.client().stats().positions_sent, 0U) << "no position without a fix";
  session.client().OnFix(Fix(core::RtkState::kAutonomous));
  ASSERT_TRUE(session.RunUntil([&] {
    const std::string up = caster.uploaded();
    return std::count(up.begin(), up.end(), '$') >= 2;
  }));
  EXPECT_THAT(caster.uploaded(), ::testing::MatchesRegex("(\\$GPGGA,070809[^\r\n]*\r\n)+"));
}

TEST(NtripClient, SendsThePositionWithARequestOfVersionTwo) {
  SmallCaster caster(
      [](int, const std::string&) { return SmallCaster::Answer{kChunked + AsChunks("x")}; });
  Session session(caster.port());
  session.client().OnFix(Fix(core::RtkState::kFixed));
  ASSERT_TRUE(session.RunUntil([&] { return !session.received.empty(); }));
  EXPECT_THAT(caster.request(), HasSubstr("\r\nNtrip-GGA: $GPGGA,070809.00,"));
}

TEST(NtripClient, BackoffGrowsToItsLimitWithJitterFromTheSeed) {
  // No socket: an address that can not be resolved fails at once; time is ours.
  const auto pauses = [](std::uint64_t seed) {
    core::Events events;
    NtripClientConfig config;
    config.caster.host = "256.256.256.256";
    config.caster.mountpoint = "X";
    config.seed = seed;
    NtripClient client(config, events, nullptr);
    std::vector<double> seconds;
    core::MonoTime now = core::MonoTime::FromNs(1'000'000'000);
    for (int i = 0; i < 9; ++i) {
      client.Service(now);
      seconds.push_back(core::ToSeconds(client.wake_at() - now));
      now = client.wake_at();
    }
    return seconds;
  };
  const auto first = pauses(1);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double nominal_s = std::min(60.0, static_cast<double>(1U << i));
    EXPECT_GE(first[i], 0.75 * nominal_s);
    EXPECT_LE(first[i], 1.25 * nominal_s);
  }
  EXPECT_EQ(pauses(1), first);
  EXPECT_NE(pauses(2), first);
}

}  // namespace
}  // namespace kawara::drivers
