#include "onboard/message_sink.hpp"

#include <gtest/gtest.h>

#include <kawara/event_t.hpp>

#include "comms/codec.hpp"

namespace kawara::onboard {
namespace {

/// Receivers and the bus can put any byte into a text; found by fuzzing the robot's core.
TEST(MessageSink, EventsOfHostileTextAreLines) {
  FrameTable frames;
  std::vector<event_t> events;
  MessageSink sink(
      {"robot", "mission"}, frames,
      [&](std::string_view channel, std::span<const std::uint8_t> bytes, MessageSink::Reach) {
        EXPECT_EQ(channel, "EVENT");
        const auto event = comms::Decode<event_t>(bytes);
        ASSERT_TRUE(event.has_value());
        events.push_back(*event);
      });
  using std::string_view_literals::operator""sv;
  core::Event event;
  event.name = "gps.identity";
  event.text = "UZ\0\x1b[2J\n30"sv;
  sink.OnEvent(event, {});
  sink.OnNote({}, {core::Severity::kInfo, "a\0b"sv, "c\0d"sv}, {});
  ASSERT_EQ(events.size(), 2U);
  EXPECT_EQ(events[0].text, "UZ??[2J?30");
  EXPECT_EQ(events[0].robot + "/" + events[1].mission, "robot/mission");
  EXPECT_EQ(events[1].name, "a?b");
  EXPECT_EQ(events[1].text, "c?d");
}

}  // namespace
}  // namespace kawara::onboard
