#include "drivers/zxtreme_dialogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "drivers/gnss_stream.hpp"
#include "tests/support/counting_allocator.hpp"
#include "tests/support/gnss_recording.hpp"

namespace kawara::drivers {
namespace {

using core::MonoTime;
using State = ZXtremeDialogue::State;

/// A dialogue with a receiver that answers as `answer` says ("PASHR,ACK", empty: nothing), 20 ms
/// later.
class Bench : public GnssStreamSink {
 public:
  using Answer = std::function<std::string(const std::string& command)>;
  explicit Bench(Answer answer, const ZXtremeConfig& config = {})
      : dialogue(config), answer_(std::move(answer)) {}

  void Run(int seconds) {
    dialogue.Start(now_);
    for (int i = 0; i < 100 * seconds; ++i) Step();
  }
  void Step() {
    const std::string command(dialogue.Poll(now_, events).view());
    now_ += core::Milliseconds(10);
    if (command.empty()) return;
    EXPECT_EQ(NmeaProbe(testing::ToBytes(command)).match, NmeaMatch::kSentence) << command;
    EXPECT_TRUE(command.ends_with("\r\n"));
    commands.push_back(command.substr(1, command.find('*') - 1));
    now_ += core::Milliseconds(10);
    const std::string reply = answer_(commands.back());
    if (!reply.empty()) Receive(reply);
  }
  void Receive(const std::string& body) {
    stream_.Feed(now_, testing::ToBytes(testing::Sentence(body)), *this);
  }
  void OnMessage(const GnssMessage& m) override { dialogue.OnMessage(now_, m, events); }

  std::vector<std::string> EventTexts() {
    std::vector<std::string> texts;
    core::Event event;
    while (events.TryPop(event)) texts.emplace_back(event.text.view());
    return texts;
  }
  std::ptrdiff_t IndexOf(const std::string& command) const {
    return std::find(commands.begin(), commands.end(), command) - commands.begin();
  }
  bool Sent(const std::string& command) const {
    return IndexOf(command) < static_cast<std::ptrdiff_t>(commands.size());
  }

  ZXtremeDialogue dialogue;
  core::Events events;
  std::vector<std::string> commands;

 private:
  Answer answer_;
  GnssStreamDecoder stream_;
  MonoTime now_ = MonoTime::FromNs(1'000'000'000);
};

/// What a healthy Z-Xtreme says.
std::string Obey(const std::string& command) {
  if (command == "PASHQ,RID") return "PASHR,RID,UZ,30,ZC00,BUEPMFT3J-,0A13";
  if (command == "PASHQ,PRT") return "PASHR,PRT,A,9";
  if (command == "PASHQ,PPS") return "PASHR,PPS,1,+0,R";
  if (command == "PASHQ,PHE") return "PASHR,PHE,R";
  return "PASHR,ACK";
}

TEST(ZXtremeDialogue, ConfiguresAWillingReceiverInTheOrderThatKeepsCpdAlive) {
  Bench bench(Obey);
  bench.Run(5);
  EXPECT_EQ(bench.dialogue.state(), State::kConfigured);
  EXPECT_TRUE(bench.dialogue.corrections_allowed());
  EXPECT_EQ(bench.dialogue.identity(), "UZ,30,ZC00,BUEPMFT3J-,0A13");
  const auto at = [&](const std::string& command) {
    EXPECT_TRUE(bench.Sent(command)) << command;
    return bench.IndexOf(command);
  };
  EXPECT_LT(at("PASHS,RTC,REM,B"), at("PASHS,CPD,MOD,ROV"));
  EXPECT_LT(at("PASHS,NME,ALL,A,OFF"), at("PASHS,NME,GGA,A,ON"));
  EXPECT_LT(at("PASHS,OUT,A"), at("PASHS,OUT,A,CBN"));
  EXPECT_LT(at("PASHS,NME,PER,0.1"), at("PASHS,NME,GGA,A,ON"));
  for (const char* sentence : {"GGA", "RMC", "VTG", "GST", "ZDA", "POS", "LTN", "PTT", "TTT"})
    EXPECT_TRUE(bench.Sent("PASHS,NME," + std::string(sentence) + ",A,ON")) << sentence;
  EXPECT_TRUE(bench.Sent("PASHS,PPS,1,+0,R"));
  EXPECT_TRUE(bench.Sent("PASHS,PHE,R"));
  for (const std::string& command : bench.commands) {
    EXPECT_FALSE(command.starts_with("PASHS,SAV")) << "not asked for";
    EXPECT_FALSE(command.starts_with("PASHS,RST"));
  }
}

TEST(ZXtremeDialogue, TellsWhoTheReceiverIsOncePerReceiver) {
  std::string rid = "PASHR,RID,UZ,30,ZC00,BUEPMFT3J-,0A13";
  Bench bench([&](const std::string& c) { return c == "PASHQ,RID" ? rid : Obey(c); });
  bench.Run(30);
  bench.Run(30);  // as after a change of baud rate
  rid = "PASHR,RID,UZ,30,ZC00,BUEPMFT3J-,0B77";
  bench.Run(30);
  int told = 0;
  for (const std::string& text : bench.EventTexts()) told += text.starts_with("receiver UZ");
  EXPECT_EQ(told, 2);
}

TEST(ZXtremeDialogue, HoldsCorrectionsBackUntilItIsDone) {
  Bench bench(Obey);
  bench.dialogue.Start(MonoTime::FromNs(1));
  while (bench.dialogue.state() == State::kAsking) {
    EXPECT_FALSE(bench.dialogue.corrections_allowed());
    bench.Step();
  }
  EXPECT_TRUE(bench.dialogue.corrections_allowed());
}

TEST(ZXtremeDialogue, SavesAndSetsTheCorrectionsPortOnlyWhenAsked) {
  ZXtremeConfig config;
  config.save = true;
  config.rtcm_port = 'C';
  config.rtcm_baud_bps = 38400;
  config.pps_offset_ms = -0.25;
  Bench bench(Obey, config);
  bench.Run(5);
  EXPECT_TRUE(bench.Sent("PASHS,SAV,Y"));
  EXPECT_TRUE(bench.Sent("PASHS,RTC,REM,C"));
  EXPECT_TRUE(bench.Sent("PASHS,SPD,C,7"));
  EXPECT_TRUE(bench.Sent("PASHS,PPS,1,-0.25,R"));
}

TEST(ZXtremeDialogue, TheReceiverKnowsItsPortBetter) {
  Bench bench([](const std::string& c) { return c == "PASHQ,PRT" ? "PASHR,PRT,C,5" : Obey(c); });
  bench.Run(5);
  EXPECT_TRUE(bench.Sent("PASHS,NME,GGA,C,ON"));
  EXPECT_FALSE(bench.Sent("PASHS,NME,GGA,A,ON"));
  const auto texts = bench.EventTexts();
  EXPECT_TRUE(std::any_of(texts.begin(), texts.end(), [](const std::string& t) {
    return t.find("configured data port A") != std::string::npos;
  }));
}

TEST(ZXtremeDialogue, ARefusalIsSaidOnceAndTheRestGoesOn) {
  Bench bench(
      [](const std::string& c) { return c == "PASHS,NME,GST,A,ON" ? "PASHR,NAK" : Obey(c); });
  bench.Run(5);
  EXPECT_EQ(bench.dialogue.state(), State::kPartly);
  EXPECT_EQ(bench.dialogue.failed_steps(), 1);
  EXPECT_TRUE(bench.Sent("PASHS,PHE,R"));
  int told = 0;
  for (const std::string& text : bench.EventTexts()) {
    if (text.find("$PASHS,NME,GST,A,ON") == std::string::npos) continue;
    EXPECT_NE(text.find("refused (NAK)"), std::string::npos) << text;
    ++told;
  }
  EXPECT_EQ(told, 1);
}

TEST(ZXtremeDialogue, EveryRefusedStepHasItsOwnEvent) {
  Bench bench([](const std::string& c) { return c.starts_with("PASHS") ? "PASHR,NAK" : Obey(c); });
  bench.Run(5);
  EXPECT_EQ(bench.dialogue.state(), State::kPartly);
  int refused = 0;
  for (const std::string& text : bench.EventTexts())
    refused += text.find("refused") != std::string::npos ? 1 : 0;
  EXPECT_EQ(refused, bench.dialogue.failed_steps());
  EXPECT_GT(refused, 15);
}

TEST(ZXtremeDialogue, ALostAnswerIsAskedForAgain) {
  int asked = 0;
  Bench bench([&](const std::string& c) {
    return c == "PASHS,CPD,MOD,ROV" && ++asked < 3 ? std::string() : Obey(c);
  });
  bench.Run(10);
  EXPECT_EQ(asked, 3);
  EXPECT_EQ(bench.dialogue.state(), State::kConfigured);
}

TEST(ZXtremeDialogue, ALateAckDoesNotAnswerTheNextCommand) {
  // The first try is answered after the second: two ACKs for one command. The next command is
  // refused.
  int asked = 0;
  Bench bench([&](const std::string& c) -> std::string {
    if (c == "PASHS,CPD,MOD,ROV") return ++asked == 1 ? "" : "PASHR,ACK";
    return c == "PASHS,CPD,FST,ON" ? "PASHR,NAK" : Obey(c);
  });
  bench.dialogue.Start(MonoTime::FromNs(1'000'000'000));
  while (asked < 2) bench.Step();
  bench.Receive("PASHR,ACK");
  bench.Run(0);
  for (int i = 0; i < 1000 && bench.dialogue.state() == State::kAsking; ++i) bench.Step();
  EXPECT_EQ(bench.dialogue.failed_steps(), 1);
}

TEST(ZXtremeDialogue, AReceiverThatDoesNotAnswerIsAPlainNmeaOne) {
  Bench bench([](const std::string&) { return ""; });
  bench.Run(10);
  EXPECT_EQ(bench.dialogue.state(), State::kGeneric);
  EXPECT_TRUE(bench.dialogue.corrections_allowed());
  const std::set<std::string> different(bench.commands.begin(), bench.commands.end());
  EXPECT_EQ(different, (std::set<std::string>{"PASHQ,RID", "PASHQ,PRT"})) << "nothing is set";
  EXPECT_EQ(bench.commands.size(), 6U);
  const auto texts = bench.EventTexts();
  ASSERT_EQ(texts.size(), 1U);
  EXPECT_NE(texts[0].find("plain NMEA"), std::string::npos);
}

TEST(ZXtremeDialogue, AReceiverThatFallsSilentIsGivenUp) {
  int answered = 0;
  Bench bench([&](const std::string& c) { return ++answered <= 8 ? Obey(c) : std::string(); });
  bench.Run(30);
  EXPECT_EQ(bench.dialogue.state(), State::kPartly);
  EXPECT_EQ(bench.commands.size(), 8U + 9U) << "three commands, three tries each";
}

TEST(ZXtremeDialogue, ReadBackThatDiffersIsTold) {
  Bench bench([](const std::string& c) {
    return c == "PASHQ,PPS" ? "PASHR,PPS,0,+0,F" : c == "PASHQ,PHE" ? "PASHR,PHE,F" : Obey(c);
  });
  bench.Run(5);
  EXPECT_EQ(bench.dialogue.failed_steps(), 2);
  const auto texts = bench.EventTexts();
  EXPECT_TRUE(std::any_of(texts.begin(), texts.end(), [](const std::string& t) {
    return t.find("$PASHQ,PPS") != std::string::npos && t.find("edge F") != std::string::npos;
  }));
}

TEST(ZXtremeDialogue, StreamInBetweenIsNoAnswer) {
  Bench bench([](const std::string&) { return "GPHDT,1.0,T"; });
  bench.Run(10);
  EXPECT_EQ(bench.dialogue.state(), State::kGeneric);
}

TEST(ZXtremeDialogue, StartsOverAfterAReconnect) {
  Bench bench(Obey);
  bench.Run(5);
  ASSERT_EQ(bench.dialogue.state(), State::kConfigured);
  const std::size_t first = bench.commands.size();
  bench.Run(5);
  EXPECT_EQ(bench.dialogue.state(), State::kConfigured);
  EXPECT_EQ(bench.commands.size(), 2 * first);
}

TEST(ZXtremeDialogue, NeverAllocates) {
  ZXtremeDialogue dialogue({});
  core::Events events;
  GnssStreamDecoder stream;
  MonoTime now = MonoTime::FromNs(1);
  auto pass_on = [&](const GnssMessage& m) { dialogue.OnMessage(now, m, events); };
  testing::Each sink(pass_on);
  const testing::Bytes nak = testing::ToBytes(testing::Sentence("PASHR,NAK"));
  const auto allocations = testing::CountAllocations([&] {
    dialogue.Start(now);
    for (int i = 0; i < 2000; ++i) {
      now += core::Milliseconds(10);
      if (!dialogue.Poll(now, events).empty()) stream.Feed(now, nak, sink);
    }
  });
  EXPECT_EQ(dialogue.state(), State::kPartly);
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace kawara::drivers
