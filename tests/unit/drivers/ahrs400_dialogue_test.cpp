#include "drivers/ahrs400_dialogue.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/counting_allocator.hpp"
#include "tests/unit/drivers/ahrs400_bytes.hpp"

namespace kawara::drivers {
namespace {

using core::Milliseconds;
using core::MonoTime;
using testing::Append;
using testing::Bytes;
using ::testing::Contains;
using ::testing::Each;
using testing::Frame;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using testing::Packet;
using testing::Version;

/// An AHRS400 at the other end of a line with a baud rate, in steps of one millisecond.
struct SimulatedUnit {
  int baud_bps = 38400;
  bool powered = true;
  bool hears = true;
  bool streaming = false;
  bool answers_version = true;
  bool frozen = false;
  char mode = 'a';
  std::string version = "AHRS400CC-100 v1.08";
  std::int16_t z_acceleration = -10923;  // -1 g of 3 g full scale
  std::uint16_t counter = 0;
  int phase_ms = 0;

  Bytes OnePacket() {
    if (!frozen) counter = static_cast<std::uint16_t>(counter - 21097);
    const auto z = static_cast<std::uint16_t>(z_acceleration);
    // Yaw 0x4848: data bytes that look like the ping's reply 'H'.
    if (mode == 'a') return Packet({10, 20, 0x4848, 1, 2, 3, 4, 5, z, 7, 8, 9, 1500, counter});
    return Packet({1, 2, 3, 4, 5, z, 7, 8, 9, 1500, counter});
  }
  Bytes Hear(std::uint8_t byte) {
    if (!powered || !hears) return {};
    switch (byte) {
      case 'R':
        streaming = false;
        return {'H'};
      case 'P':
        streaming = false;
        return {};
      case 'G':
        streaming = false;
        return OnePacket();
      case 'C':
        streaming = true;
        return {};
      case 'a':
        mode = 'a';
        return {'A'};
      case 'c':
        mode = 'c';
        return {'C'};
      case 'v':
        return answers_version ? Version(version) : Bytes{};
      case 'S':
        return Frame({0, 0, 0x30, 0x39});
      default:
        return {};
    }
  }
  Bytes Stream() {
    if (!powered || !streaming || ++phase_ms % 17 != 0) return {};
    return OnePacket();
  }
};

/// Dialogue, decoder and unit wired together as a program would.
class Bench : private Ahrs400Sink {
 public:
  explicit Bench(Ahrs400DialogueConfig config = {})
      : dialogue(config), baud_bps_(config.baud_rates[0]) {
    Ahrs400Config decoder_config;
    decoder_config.mode = config.mode;
    decoder_ = Ahrs400Decoder(decoder_config);
  }
  void RunMs(int ms) {
    for (int i = 0; i < ms; ++i) Step();
  }
  bool RunUntilRunning(int limit_ms) {
    for (int i = 0; i < limit_ms && !dialogue.running(); ++i) Step();
    return dialogue.running();
  }
  std::vector<std::string> Named(std::string_view name) const {
    std::vector<std::string> texts;
    for (const auto& e : events) {
      if (name == e.name) texts.emplace_back(e.text.view());
    }
    return texts;
  }
  MonoTime now() const { return now_; }
  int baud_bps() const { return baud_bps_; }

  SimulatedUnit unit;
  Ahrs400Dialogue dialogue;
  std::vector<Ahrs400Action> events;
  std::string written;
  int samples = 0;

 private:
  void Step() {
    now_ += Milliseconds(1);
    Deliver(unit.Stream());
    dialogue.Tick(now_);
    for (Ahrs400Action action; dialogue.TryPopAction(action);) {
      switch (action.kind) {
        case Ahrs400Action::Kind::kWrite:
          written.push_back(static_cast<char>(action.byte));
          // At another rate the unit hears something else.
          Deliver(unit.Hear(baud_bps_ == unit.baud_bps ? action.byte : std::uint8_t{0xF8}));
          break;
        case Ahrs400Action::Kind::kSetBaud:
          baud_bps_ = action.baud_bps;
          break;
        case Ahrs400Action::Kind::kEvent:
          events.push_back(action);
          break;
      }
    }
  }
  void Deliver(Bytes bytes) {
    if (bytes.empty()) return;
    // Sampled at the wrong rate, bytes become other bytes.
    if (baud_bps_ != unit.baud_bps) {
      for (auto& b : bytes) b = static_cast<std::uint8_t>(b * 37 + 11);
    }
    dialogue.OnBytes(now_, bytes);
    decoder_.Feed(now_, bytes, *this);
  }
  void OnSample(const core::AhrsSample& sample, Ahrs400Mode mode) override {
    ++samples;
    dialogue.OnPacket(now_, mode, &sample);
  }

  void OnFrozen(MonoTime, Ahrs400Mode) override { dialogue.OnFrozen(); }

  MonoTime now_ = MonoTime::FromNs(10'000'000'000);
  int baud_bps_;
  Ahrs400Decoder decoder_;
};

TEST(Ahrs400Dialogue, FreshUnitRunsAndSaysWhatItIs) {
  Bench bench;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  EXPECT_EQ(bench.written, "PRvSaC");
  EXPECT_EQ(bench.dialogue.version(), "AHRS400CC-100 v1.08");
  EXPECT_EQ(bench.dialogue.serial_number(), 12345U);
  EXPECT_THAT(bench.Named("ahrs.running"),
              Contains(HasSubstr("AHRS400CC-100 v1.08, serial number 12345")));
  bench.RunMs(3000);
  EXPECT_TRUE(bench.dialogue.running());
  EXPECT_EQ(bench.events.size(), 1U) << "nothing else to say";
}

TEST(Ahrs400Dialogue, StreamOfTheLastRunIsStoppedFirst) {
  for (const char mode : {'a', 'c'}) {
    Bench bench;
    bench.unit.streaming = true;
    bench.unit.mode = mode;
    bench.dialogue.Start(bench.now());
    ASSERT_TRUE(bench.RunUntilRunning(2000)) << mode;
    EXPECT_EQ(bench.written, "PRvSaC");
    EXPECT_EQ(bench.dialogue.version(), "AHRS400CC-100 v1.08");
  }
}

TEST(Ahrs400Dialogue, DataThatLookLikeTheReplyDoNotPass) {
  // The unit streams 'H' bytes and hears nothing: the ping must not seem answered.
  Bench bench;
  bench.unit.streaming = true;
  bench.unit.hears = false;
  bench.dialogue.Start(bench.now());
  bench.RunMs(10'000);
  EXPECT_THAT(bench.written, Not(HasSubstr("v")));
  EXPECT_TRUE(bench.dialogue.running()) << "what it sends is the right kind, so it is taken";
  EXPECT_THAT(bench.Named("ahrs.deaf"), Contains(HasSubstr("takes no command")));
  EXPECT_EQ(bench.baud_bps(), 38400) << "packets fit, so the rate is right";
}

class Ahrs400DialogueBaud : public ::testing::TestWithParam<std::tuple<int, bool>> {};
TEST_P(Ahrs400DialogueBaud, WrongRateIsSaidAndTheRightOneFound) {
  const auto [baud, streaming] = GetParam();
  Bench bench;
  bench.unit.baud_bps = baud;
  bench.unit.streaming = streaming;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(60'000));
  EXPECT_EQ(bench.baud_bps(), baud);
  const auto said = bench.Named("ahrs.baud");
  ASSERT_FALSE(said.empty());
  EXPECT_THAT(said.front(), HasSubstr("38400 baud"));
  if (streaming) {
    EXPECT_THAT(said.front(), HasSubstr("none fit a packet or a reply: wrong baud rate"));
  }
}
INSTANTIATE_TEST_SUITE_P(Rates, Ahrs400DialogueBaud,
                         ::testing::Combine(::testing::Values(9600, 19200, 57600, 115200),
                                            ::testing::Bool()));

TEST(Ahrs400Dialogue, SilentUnitListsTheRatesTriedAndIsFoundWhenSwitchedOn) {
  Bench bench;
  bench.unit.powered = false;
  bench.dialogue.Start(bench.now());
  bench.RunMs(30'000);
  EXPECT_THAT(bench.Named("ahrs.baud"),
              Contains(HasSubstr("tried 38400, 9600, 19200, 57600, 115200")));
  EXPECT_FALSE(bench.dialogue.running());
  bench.unit.powered = true;
  EXPECT_TRUE(bench.RunUntilRunning(5000)) << "the usual rate is tried every other time";
}

TEST(Ahrs400Dialogue, OneConfiguredRateIsKept) {
  Ahrs400DialogueConfig config;
  config.baud_rates = {19200, 0, 0, 0, 0, 0};
  Bench bench(config);
  bench.unit.powered = false;
  bench.dialogue.Start(bench.now());
  bench.RunMs(10'000);
  EXPECT_EQ(bench.baud_bps(), 19200);
  EXPECT_THAT(bench.Named("ahrs.baud"), Contains(HasSubstr("tried 19200")));
}

TEST(Ahrs400Dialogue, ScalingThatDoesNotFitTheUnitIsAWarning) {
  Bench bench;
  bench.unit.version = "AHRS400CD-200 v2.11";
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  EXPECT_THAT(bench.Named("ahrs.scaling"), Contains(HasSubstr("set the scaling to 200")));
}

TEST(Ahrs400Dialogue, UnitWithoutVersionStillRuns) {
  Bench bench;
  bench.unit.answers_version = false;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(5000));
  EXPECT_THAT(bench.Named("ahrs.version"), Not(IsEmpty()));
  EXPECT_EQ(bench.dialogue.version(), "");
}

TEST(Ahrs400Dialogue, StallIsSaidAndMended) {
  Bench bench;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  bench.RunMs(1000);
  bench.unit.streaming = false;  // a brown-out: it is in polled mode again
  bench.RunMs(600);
  EXPECT_THAT(bench.Named("ahrs.stalled"), Contains(HasSubstr("line is silent")));
  const int before = bench.samples;
  bench.RunMs(1000);
  EXPECT_TRUE(bench.dialogue.running());
  EXPECT_GT(bench.samples, before);
  EXPECT_EQ(bench.dialogue.restarts(), 1U);
}

TEST(Ahrs400Dialogue, FrozenUnitIsSetUpAgainAtTheSameRate) {
  Bench bench;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  bench.RunMs(200);
  bench.unit.frozen = true;
  bench.RunMs(8000);
  EXPECT_THAT(bench.Named("ahrs.stalled"), Contains(HasSubstr("no new packet")));
  EXPECT_THAT(bench.Named("ahrs.baud"), IsEmpty());
  EXPECT_EQ(bench.baud_bps(), 38400);
  bench.unit.frozen = false;
  EXPECT_TRUE(bench.RunUntilRunning(3000));
}

TEST(Ahrs400Dialogue, UnitThatFallsIntoAnotherModeIsSetUpAgain) {
  Bench bench;
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  bench.unit.mode = 'c';
  bench.RunMs(2000);
  EXPECT_TRUE(bench.dialogue.running());
  EXPECT_EQ(bench.unit.mode, 'a');
  EXPECT_THAT(bench.Named("ahrs.mode"), Contains(HasSubstr("scaled packets instead of angle")));
}

TEST(Ahrs400Dialogue, ScaledModeIsSelected) {
  Ahrs400DialogueConfig config;
  config.mode = Ahrs400Mode::kScaled;
  Bench bench(config);
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(2000));
  EXPECT_EQ(bench.unit.mode, 'c');
}

TEST(Ahrs400Dialogue, PollingAsksAtItsRate) {
  Ahrs400DialogueConfig config;
  config.poll = true;
  config.poll_period = Milliseconds(50);
  Bench bench(config);
  bench.dialogue.Start(bench.now());
  ASSERT_TRUE(bench.RunUntilRunning(3000));
  const int before = bench.samples;
  bench.RunMs(2000);
  EXPECT_EQ(bench.samples - before, 40);
  EXPECT_FALSE(bench.unit.streaming);
}

TEST(Ahrs400Dialogue, ReversedAccelerationIsNoticed) {
  for (const std::int16_t z : {std::int16_t{10923}, std::int16_t{-10923}}) {
    Bench bench;
    bench.unit.z_acceleration = z;
    bench.dialogue.Start(bench.now());
    bench.RunMs(6000);
    EXPECT_EQ(bench.Named("ahrs.acceleration_sign").size(), z > 0 ? 1U : 0U) << z;
  }
}

TEST(Ahrs400Dialogue, StoppedDialogueIsSilent) {
  Bench bench;
  bench.dialogue.Start(bench.now());
  bench.dialogue.Stop();
  bench.RunMs(2000);
  EXPECT_EQ(bench.written, "");
}

TEST(Ahrs400Dialogue, DoesNotAllocate) {
  Ahrs400Dialogue dialogue{Ahrs400DialogueConfig{}};
  const Bytes noise(100, 0x55);
  const auto allocations = kawara::testing::CountAllocations([&] {
    MonoTime now = MonoTime::FromNs(1'000'000'000);
    dialogue.Start(now);
    for (int i = 0; i < 30'000; ++i) {
      now += Milliseconds(1);
      if (i % 40 == 0) dialogue.OnBytes(now, noise);
      dialogue.Tick(now);
      for (Ahrs400Action action; dialogue.TryPopAction(action);) continue;
    }
  });
  EXPECT_EQ(allocations, 0U);
}

}  // namespace
}  // namespace kawara::drivers
