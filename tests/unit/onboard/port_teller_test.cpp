#include "onboard/port_teller.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kawara::onboard {
namespace {

std::vector<std::string> Told(InputInbox& inbox) {
  std::vector<std::string> told;
  while (inbox.TryTake([&](InputKind kind, core::MonoTime, std::span<const std::uint8_t> bytes) {
    PortNote note;
    EXPECT_EQ(kind, InputKind::kPort);
    ASSERT_TRUE(Unpack(bytes, note));
    EXPECT_EQ(note.port, PortId::kPps);
    EXPECT_TRUE(note.changed);
    told.push_back((note.open ? "up: " : "down: ") + std::string(note.text));
  })) {
  }
  return told;
}

TEST(PortTeller, SaysOnceWhatItFindsAgainAndAgain) {
  InputInbox inbox;
  PortTeller teller(inbox, PortId::kPps, "here");
  for (int round = 0; round < 2; ++round) {
    for (int i = 0; i < 3; ++i) teller.Down("gone");
    for (int i = 0; i < 3; ++i) teller.Up();
  }
  EXPECT_EQ(Told(inbox),
            (std::vector<std::string>{"down: gone", "up: here", "down: gone", "up: here"}));
}

TEST(PortTeller, APortThatIsThereAtTheStartIsToldToo) {
  InputInbox inbox;
  PortTeller teller(inbox, PortId::kPps, "here");
  teller.Up();
  EXPECT_EQ(Told(inbox), std::vector<std::string>{"up: here"});
}

}  // namespace
}  // namespace kawara::onboard
