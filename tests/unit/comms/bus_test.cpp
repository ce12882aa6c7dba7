#include <kawara/event_t.hpp>
#include <kawara/pose_t.hpp>

#include "comms/lcm_bus.hpp"
#include "comms/log_bus.hpp"
#include "comms/typed_bus.hpp"
#include "log_test_support.hpp"

namespace kawara::comms {
namespace {

pose_t MakePose(std::int64_t i) {
  pose_t pose{};
  pose.gps_ns = i;
  pose.lat_deg = 35.0 + 1e-6 * static_cast<double>(i);
  return pose;
}

// "memq://" is LCM inside one process: the same code, no network.
std::unique_ptr<LcmBus> MemoryBus() {
  auto bus = LcmBus::Open({.url = "memq://"});
  EXPECT_TRUE(bus.has_value()) << (bus ? "" : bus.error().message);
  return std::move(*bus);
}

TEST(LcmBus, TypedMessagesArriveInOrder) {
  const auto bus = MemoryBus();
  std::vector<std::int64_t> got;
  ASSERT_TRUE(Subscribe<pose_t>(
      *bus, "POSE", [&](const pose_t& pose, const MessageMeta&) { got.push_back(pose.gps_ns); }));
  for (std::int64_t i = 0; i < 5; ++i) ASSERT_TRUE(Publish(*bus, "POSE", MakePose(i)));
  ASSERT_TRUE(Publish(*bus, "POSE.EPOCH", MakePose(99)));  // "POSE" must match the whole name
  while (got.size() < 5) {
    const auto handled = bus->HandleFor(core::Milliseconds(2000));
    ASSERT_TRUE(handled.has_value());
    ASSERT_GT(*handled, 0);
  }
  EXPECT_EQ(got, (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  EXPECT_EQ(bus->bad_messages(), 0U);
}

TEST(LcmBus, BadMessagesAreCountedNotHandedOut) {
  const auto bus = MemoryBus();
  int got = 0;
  ASSERT_TRUE(Subscribe<pose_t>(*bus, "P.*", [&](const pose_t&, const MessageMeta&) { ++got; }));
  Blob cut = *Encode(MakePose(1));
  cut.pop_back();
  ASSERT_TRUE(bus->Publish("POSE", cut));
  ASSERT_TRUE(Publish(*bus, "POSE", event_t{}));
  ASSERT_TRUE(bus->Publish("POSE", Blob{}));
  ASSERT_TRUE(Publish(*bus, "POSE", MakePose(2)));
  for (int handled = 0; handled < 4;) {
    const auto n = bus->HandleFor(core::Milliseconds(2000));
    ASSERT_TRUE(n.has_value() && *n > 0);
    handled += *n;
  }
  EXPECT_EQ(got, 1);
  EXPECT_EQ(bus->bad_messages(), 3U);
  EXPECT_EQ(bus->last_bad_message().substr(0, 6), "POSE: ");
}

TEST(LcmBus, NothingCameIsZero) {
  const auto bus = MemoryBus();
  ASSERT_TRUE(bus->Subscribe("A", [](auto, auto, const auto&) {}));
  EXPECT_EQ(bus->HandleFor(core::Milliseconds(1)).value_or(-1), 0);
}

TEST(LcmBus, RefusesBadUrlsAndNames) {
  for (const char* url :
       {"nonsense", "udpm://127.0.0.1:7667", "udpm://somewhere:7667", "ftp://x"}) {
    const auto bus = LcmBus::Open({.url = url});
    ASSERT_FALSE(bus.has_value()) << url;
    EXPECT_EQ(bus.error().code, core::ErrorCode::kInvalidArgument) << bus.error().message;
  }
  EXPECT_FALSE(MemoryBus()->Publish("", Blob{}).has_value());
  EXPECT_FALSE(MemoryBus()->Publish(std::string(64, 'x'), Blob{}).has_value());
}

class LogBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto writer = EventLogWriter::Create(folder_ / "a", {.fdatasync = false});
    for (std::int64_t i = 0; i < 300; ++i) {
      const auto data = i % 2 == 0 ? *Encode(MakePose(i)) : TestData(i);
      ASSERT_TRUE(writer->Append(TestTime(i), i % 2 == 0 ? "POSE" : "OTHER", data,
                                 core::MonoTime::FromNs(1)));
    }
    ASSERT_TRUE(writer->Close());
  }
  EventLogReader Reader() { return *EventLogReader::Open({folder_ / "a"}); }
  TestFolder folder_;
};

TEST_F(LogBusTest, PlaysAllInOrder) {
  LogBus bus(Reader());
  std::vector<std::int64_t> got;
  std::int64_t others = 0;
  ASSERT_TRUE(Subscribe<pose_t>(bus, "POSE", [&](const pose_t& pose, const MessageMeta& meta) {
    EXPECT_EQ(meta.time_utc_us, TestTime(pose.gps_ns));
    got.push_back(pose.gps_ns);
  }));
  ASSERT_TRUE(bus.Subscribe("O.*R", [&](auto, auto, const auto&) { ++others; }));
  int handled = 0;
  while (!bus.AtEnd()) handled += bus.HandleFor(core::Milliseconds(1)).value();
  EXPECT_EQ(handled, 300);
  EXPECT_EQ(others, 150);
  ASSERT_EQ(got.size(), 150U);
  for (std::size_t i = 0; i < got.size(); ++i) EXPECT_EQ(got[i], static_cast<std::int64_t>(2 * i));
}

TEST_F(LogBusTest, WhatIsPublishedGoesAsideNotBack) {
  std::vector<std::string> published;
  LogBus bus(Reader(), {.published = [&](std::string_view channel, auto, const MessageMeta& meta) {
               published.push_back(std::string(channel) + std::to_string(meta.number));
             }});
  int heard = 0;
  ASSERT_TRUE(bus.Subscribe("REPLY", [&](auto, auto, const auto&) { ++heard; }));
  ASSERT_TRUE(Publish(bus, "REPLY", MakePose(1)));
  ASSERT_TRUE(Publish(bus, "REPLY", MakePose(2)));
  while (!bus.AtEnd()) ASSERT_TRUE(bus.HandleFor(core::Milliseconds(1)));
  EXPECT_EQ(heard, 0);
  EXPECT_EQ(published, (std::vector<std::string>{"REPLY0", "REPLY1"}));
}

// 300 events at 10 ms; at pace 1 nothing but the first is due at once.
TEST_F(LogBusTest, PaceHoldsBack) {
  LogBus bus(Reader(), {.pace = 1e-3});
  int heard = 0;
  ASSERT_TRUE(bus.Subscribe(".*", [&](auto, auto, const auto&) { ++heard; }));
  EXPECT_EQ(bus.HandleFor(core::Milliseconds(1)).value(), 1);
  EXPECT_EQ(bus.HandleFor(core::Milliseconds(1)).value(), 0);
  EXPECT_EQ(heard, 1);
  EXPECT_FALSE(bus.AtEnd());
}

TEST_F(LogBusTest, FastPaceLosesNothing) {
  LogBus bus(Reader(), {.pace = 1000.0});
  int heard = 0;
  ASSERT_TRUE(bus.Subscribe(".*", [&](auto, auto, const auto&) { ++heard; }));
  while (!bus.AtEnd()) ASSERT_TRUE(bus.HandleFor(core::Milliseconds(50)));
  EXPECT_EQ(heard, 300);
}

TEST_F(LogBusTest, BadPatternIsAnError) {
  LogBus bus(Reader());
  EXPECT_FALSE(bus.Subscribe("([", [](auto, auto, const auto&) {}).has_value());
}

}  // namespace
}  // namespace kawara::comms
