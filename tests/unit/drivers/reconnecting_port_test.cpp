#include "drivers/reconnecting_port.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include "tests/support/pseudo_terminal.hpp"

namespace kawara::drivers {
namespace {

using core::Milliseconds;
using core::MonoTime;
using core::Seconds;
using kawara::testing::PseudoTerminal;
using kawara::testing::WaitReadable;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// A by-id name that points to whatever number the adapter has now.
class Link {
 public:
  Link() : path_(::testing::TempDir() + "/kawara_by_id_" + std::to_string(getpid())) { Remove(); }
  ~Link() { Remove(); }
  void PointTo(const std::string& target) {
    Remove();
    std::filesystem::create_symlink(target, path_);
  }
  void Remove() { unlink(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

ReconnectConfig ConfigFor(const std::string& path) {
  ReconnectConfig config;
  config.serial.device = path;
  config.open_in_background = false;
  return config;
}

MonoTime At(double s) {
  return MonoTime::FromNs(static_cast<std::int64_t>(s * 1e9) + 1'000'000'000);
}

std::vector<PortEventKind> Kinds(ReconnectingPort& port) {
  std::vector<PortEventKind> kinds;
  for (PortEvent event; port.TryPopEvent(event);) kinds.push_back(event.kind);
  return kinds;
}

void HangUp(ReconnectingPort& port, PseudoTerminal& pty, MonoTime now) {
  pty.Unplug();
  ASSERT_TRUE(WaitReadable(port.fd()));
  std::array<std::uint8_t, 16> buffer{};
  EXPECT_EQ(port.Read(now, buffer), 0U);
  EXPECT_FALSE(port.is_open());
}

TEST(ReconnectingPort, ComesBackUnderAnotherNumber) {
  Link link;
  auto first = std::make_unique<PseudoTerminal>();
  link.PointTo(first->path());
  ReconnectingPort port(ConfigFor(link.path()));
  port.Service(At(0));
  ASSERT_TRUE(port.is_open());
  EXPECT_EQ(port.generation(), 1U);

  PseudoTerminal second;  // made while the first lives, so it has another number
  ASSERT_NE(second.path(), first->path());
  HangUp(port, *first, At(1));
  link.PointTo(second.path());
  port.Service(At(1.1));
  EXPECT_FALSE(port.is_open()) << "not before the back-off";
  port.Service(At(1.3));
  ASSERT_TRUE(port.is_open());
  EXPECT_EQ(port.generation(), 2U);
  second.Send("hello");
  ASSERT_TRUE(WaitReadable(port.fd()));
  std::array<std::uint8_t, 16> buffer{};
  EXPECT_EQ(port.Read(At(2), buffer), 5U);
  EXPECT_EQ(port.counters().bytes_in, 5U);
  EXPECT_EQ(port.counters().lost, 1U);
  EXPECT_THAT(Kinds(port),
              ElementsAre(PortEventKind::kOpened, PortEventKind::kLost, PortEventKind::kOpened));
}

TEST(ReconnectingPort, DeadDescriptorIsClosedAtOnce) {
  PseudoTerminal pty;
  ReconnectingPort port(ConfigFor(pty.path()));
  port.Service(At(0));
  const int fd = port.fd();
  ASSERT_GE(fd, 0);
  HangUp(port, pty, At(1));
  EXPECT_EQ(port.fd(), -1);
  EXPECT_EQ(fcntl(fd, F_GETFD), -1) << "still open";
}

TEST(ReconnectingPort, WriteAlsoNoticesTheLoss) {
  PseudoTerminal pty;
  ReconnectingPort port(ConfigFor(pty.path()));
  port.Service(At(0));
  pty.Unplug();
  ASSERT_TRUE(WaitReadable(port.fd()));
  const std::array<std::uint8_t, 3> bytes{1, 2, 3};
  EXPECT_EQ(port.Write(At(1), bytes), 0U);
  EXPECT_FALSE(port.is_open());
  EXPECT_EQ(port.counters().bytes_not_written, 3U);
}

TEST(ReconnectingPort, BackOffGrowsToItsLimit) {
  ReconnectConfig config = ConfigFor("/dev/ttyUSB_not_there");
  ReconnectingPort port(config);
  std::vector<double> tries;
  std::uint64_t failed = 0;
  for (double t = 0; t < 12; t += 0.01) {
    port.Service(At(t));
    if (port.counters().failed_opens != failed) {
      failed = port.counters().failed_opens;
      tries.push_back(t);
    }
  }
  ASSERT_GE(tries.size(), 7U);
  const std::array<double, 6> gaps{0.2, 0.4, 0.8, 1.6, 2.0, 2.0};
  for (std::size_t i = 0; i < gaps.size(); ++i)
    EXPECT_NEAR(tries[i + 1] - tries[i], gaps[i], 0.02) << i;
}

TEST(ReconnectingPort, MissingIsSaidOnceThenReminded) {
  ReconnectingPort port(ConfigFor("/dev/ttyUSB_not_there"));
  for (double t = 0; t < 65; t += 0.1) port.Service(At(t));
  PortEvent event;
  int count = 0;
  while (port.TryPopEvent(event)) {
    ++count;
    EXPECT_EQ(event.kind, PortEventKind::kStillMissing);
    EXPECT_THAT(std::string(event.text.view()), HasSubstr("/dev/ttyUSB_not_there: no such device"));
  }
  EXPECT_EQ(count, 3) << "at 0, 30 and 60 s";
}

TEST(ReconnectingPort, SilenceIsReportedOnceAndItsEnd) {
  PseudoTerminal pty;
  ReconnectingPort port(ConfigFor(pty.path()));
  port.Service(At(0));
  for (double t = 0; t < 10; t += 0.1) port.Service(At(t));
  pty.Send("x");
  ASSERT_TRUE(WaitReadable(port.fd()));
  std::array<std::uint8_t, 4> buffer{};
  EXPECT_EQ(port.Read(At(10), buffer), 1U);
  EXPECT_THAT(Kinds(port),
              ElementsAre(PortEventKind::kOpened, PortEventKind::kSilent, PortEventKind::kTalking));
}

TEST(ReconnectingPort, BaudSurvivesReconnection) {
  Link link;
  PseudoTerminal first;
  link.PointTo(first.path());
  ReconnectingPort port(ConfigFor(link.path()));
  port.Service(At(0));
  ASSERT_TRUE(port.SetBaud(9600));
  PseudoTerminal second;
  HangUp(port, first, At(1));
  link.PointTo(second.path());
  port.Service(At(2));
  ASSERT_TRUE(port.is_open());
  EXPECT_EQ(port.port()->granted().baud_bps, 9600);
}

TEST(ReconnectingPort, UnheardEventsKeepTheNewest) {
  PseudoTerminal pty;
  ReconnectConfig config = ConfigFor(pty.path());
  config.silence = Seconds(1);
  ReconnectingPort port(config);
  std::array<std::uint8_t, 4> buffer{};
  for (int i = 0; i < 40; ++i) {
    port.Service(At(10 * i));
    pty.Send("x");
    ASSERT_TRUE(WaitReadable(port.fd()));
    port.Read(At(10 * i + 0.1), buffer);
  }
  PortEvent event;
  int count = 0;
  while (port.TryPopEvent(event)) ++count;
  EXPECT_EQ(count, 16);
  EXPECT_EQ(event.kind, PortEventKind::kTalking);
  EXPECT_EQ(event.stamp, At(390.1));
}

TEST(ReconnectingPort, OpensInTheBackground) {
  PseudoTerminal pty;
  ReconnectConfig config = ConfigFor(pty.path());
  config.open_in_background = true;
  ReconnectingPort port(config);
  for (int i = 0; i < 2000 && !port.is_open(); ++i) {
    port.Service(core::MonoNow());
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  ASSERT_TRUE(port.is_open());
  HangUp(port, pty, core::MonoNow());
  EXPECT_THAT(Kinds(port), ElementsAre(PortEventKind::kOpened, PortEventKind::kLost));
}

TEST(ReconnectingPort, BackgroundHelperEndsInAnyState) {
  for (int i = 0; i < 50; ++i) {
    ReconnectConfig config = ConfigFor("/dev/ttyUSB_not_there");
    config.open_in_background = true;
    ReconnectingPort port(config);
    for (int j = 0; j < i % 4; ++j) port.Service(core::MonoNow());
  }
}

}  // namespace
}  // namespace kawara::drivers
