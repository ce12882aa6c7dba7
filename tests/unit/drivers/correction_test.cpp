#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "corrections_data.hpp"
#include "drivers/correction_forwarder.hpp"
#include "drivers/correction_queue.hpp"
#include "drivers/correction_watchdog.hpp"

namespace kawara::drivers {
namespace {

using testing::Append;
using testing::BitWriter;
using testing::Bytes;
using ::testing::HasSubstr;
using testing::MakeRtcm3Frame;
using testing::ReadRecording;

core::MonoTime At(double seconds) {
  return core::MonoTime::FromNs(1'000'000'000) + core::DurationFromSeconds(seconds);
}

Bytes Observations(int station = 7, int satellites = 1) {
  BitWriter w;
  w.Put(1002, 12).Put(station, 12).Put(1000, 30).Put(0, 1).Put(satellites, 5).Put(0, 4);
  for (int i = 0; i < satellites; ++i) w.Put(i + 1, 6).Put(0, 68);
  return MakeRtcm3Frame(w.bytes());
}
Bytes Base(int station = 7, double x_m = 1000.0) {
  BitWriter w;
  w.Put(1005, 12)
      .Put(station, 12)
      .Put(0, 10)
      .Put(static_cast<std::int64_t>(x_m * 1e4), 38)
      .Put(0, 2);
  w.Put(0, 38).Put(0, 2).Put(0, 38);
  return MakeRtcm3Frame(w.bytes());
}

/// A forwarder with its events and everything it let out.
struct Bench {
  explicit Bench(CorrectionForwarderConfig config = {}) : forwarder(config, events) {
    forwarder.Start(At(0));
  }
  void Feed(double seconds, std::span<const std::uint8_t> bytes) {
    forwarder.Feed(At(seconds), bytes);
    Drain();
  }
  void Tick(double seconds) { forwarder.Tick(At(seconds)); }
  void Drain() {
    while (!forwarder.Output().empty()) {
      const auto part = forwarder.Output().first(std::min(at_once, forwarder.Output().size()));
      Append(out, part);
      forwarder.Consume(part.size());
    }
  }
  std::vector<std::string> Events() {
    std::vector<std::string> all;
    core::Event event;
    while (events.TryPop(event))
      all.push_back(std::string(event.name) + ": " + std::string(event.text.view()));
    return all;
  }
  core::Events events{core::Duration(0)};
  CorrectionForwarder forwarder;
  Bytes out;
  std::size_t at_once = SIZE_MAX;
};

TEST(CorrectionForwarder, OnlyWholeFramesWhateverTheSplit) {
  const Bytes stream = ReadRecording("rtcm3-2.log");  // remarks before, 199 frames
  for (const std::size_t longest : {1U, 100U, 1000U}) {
    Bench bench;
    bench.at_once = 37;  // a port that takes little
    testing::ForPieces(stream, longest, [&](auto piece) { bench.Feed(0, piece); });
    EXPECT_EQ(bench.forwarder.stats().messages, 199U);
    EXPECT_EQ(bench.forwarder.stats().dropped, 0U);
    Rtcm3Framer framer;
    std::span<const std::uint8_t> rest(bench.out);
    while (framer.Next(rest)) {
    }
    EXPECT_EQ(framer.stats().skipped_bytes, 0U) << "nothing but frames";
    EXPECT_EQ(framer.pending_bytes(), 0U);
    EXPECT_EQ(bench.forwarder.stats().bytes_out, bench.out.size());
  }
}

TEST(CorrectionForwarder, Rtcm2ComesOutReadable) {
  const Bytes stream = ReadRecording("testglo.rtcm2");
  Bench bench;
  testing::ForPieces(stream, 500, [&](auto piece) { bench.Feed(0, piece); });
  Rtcm2Decoder decoder;
  std::span<const std::uint8_t> rest(bench.out);
  std::uint64_t messages = 0;
  while (decoder.Next(rest) != nullptr) ++messages;
  EXPECT_EQ(messages, 1727U);
  EXPECT_EQ(decoder.stats().parity_errors, 0U);
}

TEST(CorrectionForwarder, MixedFormatsInTheOrderOfTheStream) {
  const Bytes recording = ReadRecording("testglo.rtcm2");
  Bytes stream(recording.begin(), recording.begin() + 20'000);
  Append(stream, Observations());
  Append(stream, std::span(recording).subspan(20'000, 20'000));
  Bytes reference;
  for (const std::size_t longest : {2000U, 1U, 64U}) {
    Bench bench;
    testing::ForPieces(stream, longest, [&](auto piece) { bench.Feed(0, piece); });
    if (reference.empty()) reference = bench.out;
    EXPECT_EQ(bench.out, reference) << longest;
  }
}

TEST(CorrectionForwarder, HoldsWhileTheReceiverIsConfigured) {
  Bench bench;
  bench.Feed(0, Base());
  const std::size_t before = bench.out.size();
  bench.forwarder.Hold();
  bench.Feed(1, Observations());
  EXPECT_EQ(bench.out.size(), before);
  bench.forwarder.Release();
  bench.Drain();
  EXPECT_EQ(bench.out.size(), before + Observations().size());
}

TEST(CorrectionForwarder, AMessageBegunIsFinishedBeforeTheHold) {
  Bench bench;
  const Bytes frame = Observations();
  bench.forwarder.Feed(At(0), frame);
  bench.forwarder.Feed(At(0), Base());
  bench.forwarder.Consume(5);
  bench.forwarder.Hold();
  EXPECT_EQ(bench.forwarder.Output().size(), frame.size() - 5);
  bench.forwarder.Consume(frame.size() - 5);
  EXPECT_TRUE(bench.forwarder.Output().empty());
}

TEST(CorrectionForwarder, HeldTooLongDropsTheOldestAndCounts) {
  Bench bench;
  bench.forwarder.Hold();
  for (int i = 0; i < 100; ++i) bench.Feed(0.1 * i, Base(7, 1000.0));
  bench.Feed(10, Observations());
  EXPECT_EQ(bench.forwarder.stats().dropped, 101U - CorrectionQueue::kMessages);
  bench.forwarder.Release();
  bench.Drain();
  const Bytes newest = Observations();
  EXPECT_TRUE(std::equal(newest.rbegin(), newest.rend(), bench.out.rbegin()));
  EXPECT_THAT(bench.Events(), ::testing::Contains(HasSubstr("corrections.dropped")));
}

TEST(CorrectionForwarder, RawModePassesEverythingInOrder) {
  CorrectionForwarderConfig config;
  config.mode = CorrectionMode::kRaw;
  Bench bench(config);
  Bytes stream(3000);
  for (std::size_t i = 0; i < stream.size(); ++i)
    stream[i] = static_cast<std::uint8_t>((i * 7) % 200);
  Append(stream, Observations());
  bench.Feed(0, stream);
  EXPECT_EQ(bench.out, stream);
  EXPECT_EQ(bench.forwarder.stats().messages, 1U) << "the watchdog sees them all the same";
}

TEST(CorrectionForwarder, Rtcm3ForAnRtcm2ReceiverIsSaidAndNotSent) {
  CorrectionForwarderConfig config;
  config.receiver_accepts = CorrectionsAccepted::kRtcm2Only;
  Bench bench(config);
  bench.Feed(0, Base());
  bench.Feed(0, Observations());
  EXPECT_TRUE(bench.out.empty());
  EXPECT_EQ(bench.forwarder.stats().refused, 2U);
  EXPECT_THAT(bench.Events()[0],
              HasSubstr("corrections.wrong_format: source sends RTCM3 (type 1005) but the receiver "
                        "takes RTCM 2 only: choose a mountpoint with RTCM 2.3"));
  bench.Tick(5);
  EXPECT_TRUE(bench.forwarder.watchdog().alarm()) << "what is refused does not help";
}

TEST(CorrectionForwarder, DoesNotAllocate) {
  const Bytes rtcm3 = ReadRecording("rtcm3-2.log");
  const Bytes rtcm2 = ReadRecording("testglo.rtcm2");
  Bench bench;
  const auto before = testing::AllocationsOfThisThread();
  for (const auto* stream : {&rtcm3, &rtcm2}) {
    for (std::size_t i = 0; i + 100 <= stream->size(); i += 100) {
      bench.forwarder.Feed(At(0), std::span(*stream).subspan(i, 100));
      while (!bench.forwarder.Output().empty())
        bench.forwarder.Consume(bench.forwarder.Output().size());
      bench.forwarder.Tick(At(static_cast<double>(i) * 0.01));
    }
  }
  EXPECT_EQ(testing::AllocationsOfThisThread(), before);
}

TEST(CorrectionWatchdog, AlarmAtTheLimitAndRecovery) {
  Bench bench;
  bench.Feed(0.0, Base());
  bench.Feed(1.0, Observations());
  bench.Tick(5.9);
  EXPECT_FALSE(bench.forwarder.watchdog().alarm());
  bench.Tick(6.0);
  bench.Tick(7.0);
  EXPECT_TRUE(bench.forwarder.watchdog().alarm());
  EXPECT_EQ(*bench.forwarder.watchdog().Age(At(7.0)), core::Seconds(6));
  bench.Feed(9.0, Observations());
  EXPECT_FALSE(bench.forwarder.watchdog().alarm());
  EXPECT_EQ(bench.forwarder.watchdog().alarms(), 1U);
  EXPECT_THAT(bench.Events(),
              ::testing::ElementsAre(
                  "corrections.stale: no usable corrections for 5.0 s: observations stopped; check "
                  "radio or caster",
                  "corrections.recovered: usable corrections again after 8.0 s"));
}

TEST(CorrectionWatchdog, NothingEverCame) {
  Bench bench;
  bench.Tick(4.9);
  EXPECT_TRUE(bench.Events().empty());
  bench.Tick(5.0);
  EXPECT_THAT(bench.Events(), ::testing::ElementsAre(HasSubstr("nothing came at all")));
}

TEST(CorrectionWatchdog, ObservationsWithoutABasePositionAreNotUsable) {
  Bench bench;
  for (int i = 0; i < 6; ++i) bench.Feed(i, Observations());
  EXPECT_FALSE(bench.forwarder.watchdog().Age(At(5)));
  bench.Tick(5.5);
  EXPECT_THAT(bench.Events(),
              ::testing::ElementsAre(HasSubstr("the base's position never came (1005/1006 or 3)")));
  bench.Feed(6.0, Base());
  EXPECT_THAT(bench.Events(), ::testing::ElementsAre(HasSubstr("corrections.recovered")));
}

TEST(CorrectionWatchdog, BasePositionGrowsTooOld) {
  Bench bench;
  bench.Feed(0, Base());
  for (int i = 0; i <= 304; ++i) {
    bench.Feed(i, Observations());
    bench.Tick(i);
  }
  EXPECT_FALSE(bench.forwarder.watchdog().Age(At(304)));
  EXPECT_TRUE(bench.Events().empty()) << "usable until 300 s, so not before 305 s";
  bench.Tick(305);
  EXPECT_THAT(bench.Events(), ::testing::ElementsAre(
                                  "corrections.stale: no usable corrections for 5.0 s: the base's "
                                  "position is too old"));
}

TEST(CorrectionWatchdog, PositionWithoutObservations) {
  Bench bench;
  for (int i = 0; i < 6; ++i) bench.Feed(i, Base());
  bench.Tick(5.5);
  EXPECT_THAT(bench.Events(),
              ::testing::ElementsAre(HasSubstr("messages come, but no observations")));
}

TEST(CorrectionWatchdog, EmptyObservationsDoNotCount) {
  Bench bench;
  bench.Feed(0, Base());
  bench.Feed(1, Observations(7, 0));
  EXPECT_FALSE(bench.forwarder.watchdog().Age(At(1)));
}

TEST(CorrectionWatchdog, BaseMoved) {
  Bench bench;
  bench.Feed(0, Base(7, 1000.00));
  bench.Feed(1, Base(7, 1000.04));
  EXPECT_TRUE(bench.Events().empty()) << "below the limit";
  bench.Feed(2, Base(7, 1012.54));
  bench.Feed(3, Base(9, 1012.54));
  EXPECT_THAT(bench.Events(),
              ::testing::ElementsAre(
                  "corrections.base_moved: base 7 moved by 12.500 m: positions will jump by that",
                  "corrections.base_moved: base 7 replaced by base 9, moved by 0.000 m: positions "
                  "will jump by that"));
  EXPECT_EQ(bench.forwarder.watchdog().base_moves(), 2U);
  EXPECT_EQ(bench.forwarder.watchdog().base()->station, 9);
}

TEST(CorrectionWatchdog, Rtcm2PositionIsRefinedWithoutAMove) {
  Bench bench;
  testing::ForPieces(ReadRecording("testglo.rtcm2"), 500,
                     [&](auto piece) { bench.Feed(0, piece); });
  EXPECT_TRUE(bench.Events().empty());
  const auto& base = bench.forwarder.watchdog().base();
  ASSERT_TRUE(base);
  EXPECT_LT((base->ecef_m - Eigen::Vector3d(-3869297.5138, 3436571.3345, 3717369.3757)).norm(),
            0.0001);
}

TEST(CorrectionWatchdog, CodeCorrectionsCountOnlyIfAccepted) {
  core::Events events;
  Rtcm2Message m;
  m.type = 1;
  m.body = Rtcm2Corrections{};
  CorrectionWatchdogConfig config;
  CorrectionWatchdog strict(config, events);
  strict.OnMessage(At(0), m);
  EXPECT_FALSE(strict.Age(At(0)));
  config.accept_code_differential = true;
  CorrectionWatchdog lax(config, events);
  lax.OnMessage(At(0), m);
  EXPECT_TRUE(lax.Age(At(0)));
}

TEST(CorrectionWatchdog, CountsAndRatesPerType) {
  Bench bench;
  for (int i = 0; i < 20; ++i) {
    bench.Feed(i, Observations());
    if (i % 5 == 0) bench.Feed(i, Base());
  }
  const auto types = bench.forwarder.watchdog().types();
  ASSERT_EQ(types.size(), 2U);
  EXPECT_EQ(types[0].type, 1002);
  EXPECT_EQ(types[0].count, 20U);
  EXPECT_EQ(types[0].bytes, 20 * Observations().size());
  EXPECT_NEAR(types[0].interval_s, 1.0, 1e-9);
  EXPECT_EQ(types[1].type, 1005);
  EXPECT_EQ(types[1].count, 4U);
  EXPECT_NEAR(types[1].interval_s, 5.0, 1e-9);
}

TEST(CorrectionQueue, DropsTheOldestNotYetBegun) {
  auto queue = std::make_unique<CorrectionQueue>();
  const auto message = [](std::size_t i) { return Bytes(10, static_cast<std::uint8_t>(i)); };
  for (std::size_t i = 0; i < CorrectionQueue::kMessages; ++i) EXPECT_TRUE(queue->Push(message(i)));
  queue->Consume(3);  // message 0 is under way
  EXPECT_FALSE(queue->Push(message(100)));
  EXPECT_EQ(queue->Front().size(), 7U);
  EXPECT_EQ(queue->Front()[0], 0);
  queue->Consume(7);
  EXPECT_EQ(queue->Front()[0], 2) << "1 gave way";
  EXPECT_EQ(queue->dropped(), 1U);
  EXPECT_EQ(queue->Clear(), CorrectionQueue::kMessages - 1);
  EXPECT_TRUE(queue->Front().empty());
}

TEST(CorrectionQueue, RefusesWhatIsNoMessage) {
  auto queue = std::make_unique<CorrectionQueue>();
  EXPECT_FALSE(queue->Push(Bytes(CorrectionQueue::kMaxMessageBytes + 1)));
  EXPECT_TRUE(queue->Push(Bytes()));
  EXPECT_EQ(queue->size(), 0U);
  queue->Consume(5);
  EXPECT_TRUE(queue->Push(Bytes(CorrectionQueue::kMaxMessageBytes)));
}

}  // namespace
}  // namespace kawara::drivers
