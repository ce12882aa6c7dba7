#include "onboard/output_ring.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kawara::onboard {
namespace {

/// Writes down what it hears.
class Listener : public CoreSink {
 public:
  void OnInput(const Input& input) override {
    heard.push_back("input " + std::string(ChannelOf(input.kind)) + " " +
                    std::to_string(input.sequence) + " " + std::to_string(input.mono.ns()) + " " +
                    std::string(input.bytes.begin(), input.bytes.end()));
  }
  void OnFrame(const FrameInput& frame, bool selected) override {
    heard.push_back("frame " + std::to_string(frame.slot) + (selected ? " selected" : ""));
  }
  void OnFix(const core::GnssFix& fix) override {
    heard.push_back("fix " + std::to_string(fix.position_cov_enu_m2(2, 1)));
  }
  void OnAhrs(const core::AhrsSample& sample, core::GpsTime sampled) override {
    heard.push_back("ahrs " + std::to_string(sample.counter) + " " + std::to_string(sampled.ns()));
  }
  void OnPose(const core::Pose& pose) override {
    heard.push_back("pose " + std::to_string(pose.mono.ns()));
  }
  void OnNavigation(const estimation::NavigationReport& report) override {
    heard.emplace_back("navigation " + std::to_string(report.fixes_used));
  }
  void OnClock(const estimation::ClockStatus&) override { heard.emplace_back("clock"); }
  void OnEvent(const core::Event& event, core::GpsTime) override {
    heard.push_back(std::string("event ") + event.name + " " + std::string(event.text.view()));
  }
  void OnNote(core::MonoTime, const EventNote& note, core::GpsTime) override {
    heard.push_back("note " + std::string(note.name) + ": " + std::string(note.text));
  }
  void OnPicture(const PictureOrder& order) override {
    heard.push_back("picture " + std::to_string(order.epoch));
  }
  void OnExposurePose(const ExposurePose& pose) override {
    heard.push_back("exposure " + std::to_string(pose.epoch));
  }
  void Trigger(std::uint32_t) override { heard.emplace_back("trigger"); }
  void Write(PortId, std::span<const std::uint8_t>) override { heard.emplace_back("write"); }
  void SetBaud(PortId, int) override { heard.emplace_back("baud"); }

  std::vector<std::string> heard;
};

TEST(OutputRing, RepeatsEveryCallInOrderOnTheOtherSide) {
  OutputRing ring(1 << 16);
  ring.OnInput({InputKind::kGpsBytes, 7, core::MonoTime::FromNs(5), BytesOf("$GPGGA")});
  core::GnssFix fix;
  fix.position_cov_enu_m2(2, 1) = 0.25;
  ring.OnFix(fix);
  core::AhrsSample sample;
  sample.counter = 1234;
  ring.OnAhrs(sample, core::GpsTime::FromNs(99));
  core::Pose pose;
  pose.mono = core::MonoTime::FromNs(8);
  ring.OnPose(pose);
  estimation::NavigationReport report;
  report.fixes_used = 21;
  ring.OnNavigation(report);
  ring.OnClock({});
  core::Event event;
  event.name = "gps.port";
  event.text = "lost";
  ring.OnEvent(event, {});
  ring.OnNote({}, {core::Severity::kInfo, "ntrip.streaming", "flows"}, {});
  FrameInput frame;
  frame.slot = 3;
  ring.OnFrame(frame, true);
  ring.OnPicture({11, 3});
  ExposurePose exposure;
  exposure.epoch = 11;
  ring.OnExposurePose(exposure);
  ring.Trigger(1);  // acting is not carried

  Listener listener;
  while (ring.TryDeliver(listener)) {
  }
  EXPECT_EQ(listener.heard,
            (std::vector<std::string>{"input RAW.GPS 7 5 $GPGGA", "fix 0.250000", "ahrs 1234 99",
                                      "pose 8", "navigation 21", "clock", "event gps.port lost",
                                      "note ntrip.streaming: flows", "frame 3 selected",
                                      "picture 11", "exposure 11"}));
  EXPECT_EQ(ring.refused(), 0U);
}

TEST(OutputRing, FullRingRefusesAndCounts) {
  OutputRing ring(4096);
  for (int i = 0; i < 100; ++i) ring.OnPose({});
  EXPECT_GT(ring.refused(), 0U);
}

TEST(Notes, PackAndUnpackAgree) {
  const auto bytes =
      Pack(PortNote{PortId::kAhrs, true, true, core::Severity::kWarnHigh, "gone: why"});
  PortNote note;
  ASSERT_TRUE(Unpack(BytesOf(bytes.view()), note));
  EXPECT_EQ(note.port, PortId::kAhrs);
  EXPECT_TRUE(note.open);
  EXPECT_TRUE(note.changed);
  EXPECT_EQ(note.severity, core::Severity::kWarnHigh);
  EXPECT_EQ(note.text, "gone: why");
}

TEST(Notes, BytesFromAForeignLogAreRefused) {
  PortNote port;
  EventNote event;
  for (const std::string_view bad : {"", "1", "9111x", "x", "7 name", "1name"}) {
    EXPECT_FALSE(Unpack(BytesOf(bad), port)) << bad;
    EXPECT_FALSE(Unpack(BytesOf(bad), event)) << bad;
  }
}

TEST(Channels, EveryInputKindHasItsOwn) {
  for (int i = 0; i <= static_cast<int>(InputKind::kFrame); ++i) {
    const auto kind = static_cast<InputKind>(i);
    InputKind back{};
    ASSERT_TRUE(KindOf(ChannelOf(kind), back)) << i;
    EXPECT_EQ(back, kind);
  }
}

}  // namespace
}  // namespace kawara::onboard
