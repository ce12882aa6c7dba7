#include "onboard/outlet.hpp"

#include <gtest/gtest.h>

#include <kawara/event_t.hpp>
#include <map>
#include <mutex>
#include <thread>

#include "comms/codec.hpp"
#include "comms/event_log_reader.hpp"
#include "tests/support/test_folder.hpp"

/// What leaves the program, with a real recorder behind it and a bus that keeps what it is given.
namespace kawara::onboard {
namespace {

using Blob = std::vector<std::uint8_t>;

class KeepingBus final : public comms::Bus {
 public:
  core::Expected<void> Publish(std::string_view channel,
                               std::span<const std::uint8_t> data) override {
    const std::lock_guard lock(mutex_);
    if (refuse) return core::Fail(core::ErrorCode::kIo, "refused");
    published_[std::string(channel)].emplace_back(data.begin(), data.end());
    return {};
  }
  core::Expected<void> Subscribe(const std::string&, comms::Handler) override { return {}; }
  core::Expected<int> HandleFor(core::Duration) override { return 0; }

  std::vector<Blob> published(const std::string& channel) const {
    const std::lock_guard lock(mutex_);
    const auto found = published_.find(channel);
    return found == published_.end() ? std::vector<Blob>{} : found->second;
  }
  bool refuse = false;

 private:
  mutable std::mutex mutex_;
  std::map<std::string, std::vector<Blob>> published_;
};

class OutletTest : public ::testing::Test {
 protected:
  OutletTest() {
    config_.folder = folder_.path();
    config_.robot = "r";
    config_.mission = "m";
    config_.disk_reserve_bytes = 0;
    config_.navigation_reserve_bytes = 0;
  }
  /// As the live robot starts it.
  std::unique_ptr<comms::Recorder> Record() {
    auto recorder = comms::Recorder::Start(
        config_, Blob{}, [this](const comms::RecorderEvent& event) { outlet_.Publish(event); });
    EXPECT_TRUE(recorder.has_value()) << recorder.error().message;
    outlet_.RecordTo(**recorder);
    return std::move(*recorder);
  }
  std::vector<Blob> Logged(std::string_view channel) const {
    std::vector<Blob> logged;
    auto reader = comms::EventLogReader::Open({config_.folder});
    EXPECT_TRUE(reader.has_value()) << reader.error().message;
    while (const auto event = reader->Next()) {
      if (event->channel == channel) logged.emplace_back(event->data.begin(), event->data.end());
    }
    return logged;
  }

  testing::TestFolder folder_;
  comms::RecorderConfig config_;
  KeepingBus bus_;
  core::Counters counters_;
  Outlet outlet_{bus_, counters_};
};

// So that the station's event table is the same from the bus and from the log.
TEST_F(OutletTest, WhatTheRecorderTellsIsLiveInTheBytesOfTheLog) {
  config_.disk_reserve_bytes = std::uint64_t{1} << 60;  // no disk has that much left
  Record()->Stop();
  const std::vector<Blob> live = bus_.published("EVENT");
  ASSERT_FALSE(live.empty());
  EXPECT_EQ(live, Logged("EVENT"));
  const auto event = comms::Decode<event_t>(live.front());
  ASSERT_TRUE(event.has_value());
  EXPECT_EQ(event->name, "recorder.pictures_paused");
  EXPECT_EQ(event->robot + "/" + event->mission, "r/m");
  EXPECT_GT(event->mono_ns, 0);
}

// Run it under TSan: the recorder's thread tells while others send.
TEST_F(OutletTest, EverybodyAtOnce) {
  constexpr std::size_t kEach = 500;
  config_.disk_reserve_bytes = std::uint64_t{1} << 60;
  const auto recorder = Record();
  {
    std::vector<std::jthread> threads;
    for (const char* channel : {"POSE", "COUNTERS"}) {
      threads.emplace_back([this, channel] {
        for (std::size_t i = 0; i < kEach; ++i) {
          outlet_.Send(channel, Blob{1, 2, 3}, Outlet::Reach::kBusAndLog);
        }
      });
    }
  }
  recorder->Stop();
  for (const char* channel : {"POSE", "COUNTERS"}) {
    EXPECT_EQ(bus_.published(channel).size(), kEach) << channel;
    EXPECT_EQ(Logged(channel).size(), kEach) << channel;
  }
  EXPECT_EQ(counters_.Register("recorder.refused").value(), 0);
}

TEST_F(OutletTest, InputsStayInTheLog) {
  const auto recorder = Record();
  outlet_.Send("RAW.GPS", Blob{1}, Outlet::Reach::kLogOnly);
  recorder->Stop();
  EXPECT_TRUE(bus_.published("RAW.GPS").empty());
  EXPECT_EQ(Logged("RAW.GPS").size(), 1U);
}

TEST_F(OutletTest, WhatTheBusRefusesIsCountedAndLogged) {
  const auto recorder = Record();
  bus_.refuse = true;
  outlet_.Send("POSE", Blob{1}, Outlet::Reach::kBusAndLog);
  outlet_.Publish({.mono = core::MonoNow(), .severity = 1, .name = "recorder.x", .text = "x"});
  recorder->Stop();
  EXPECT_EQ(counters_.Register("bus.not_sent").value(), 2);
  EXPECT_EQ(Logged("POSE").size(), 1U);
}

}  // namespace
}  // namespace kawara::onboard
