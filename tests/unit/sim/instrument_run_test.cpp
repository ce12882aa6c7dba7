#include "sim/run/instrument_run.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <thread>

#include "drivers/sick.hpp"
#include "sim/motion/motion_track.hpp"
#include "sim/vehicle/simulate_drive.hpp"

namespace kawara::sim {
namespace {

/// A robot that stands, and a wall three metres ahead of its scanner.
SimulatedDrive Standing() {
  DriveScenario scenario;
  scenario.origin = {35.36 * core::kRadFromDeg, 139.53 * core::kRadFromDeg, 52.0};
  scenario.begin = core::FromWeek({.week = 2391, .time_of_week = core::Seconds(7200)});
  scenario.path.waypoints = {{0, 0, {}, 0}, {1, 0, {}, 0}};
  scenario.path.stand_before_s = 120.0;
  return SimulateDrive(scenario).value();
}
void Wall(core::GpsTime /*ahead*/, std::span<float> ranges_m) {
  for (std::size_t i = 1; i + 1 < ranges_m.size(); ++i) {
    const double angle = static_cast<double>(i) * 0.5 * core::kRadFromDeg;
    ranges_m[i] = static_cast<float>(3.0 / std::sin(angle));
  }
}

/// Whoever has the scanner's port open.
class Host : public drivers::SickSink {
 public:
  explicit Host(const std::filesystem::path& link)
      : fd_(open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK)) {
    SetBaud(B9600);
  }
  ~Host() override { close(fd_); }
  void SetBaud(speed_t speed) const {
    termios settings{};
    tcgetattr(fd_, &settings);
    cfmakeraw(&settings);
    cfsetspeed(&settings, speed);
    tcsetattr(fd_, TCSANOW, &settings);
  }
  void Say(const drivers::SickTelegram& telegram) const {
    EXPECT_EQ(write(fd_, telegram.bytes.data(), telegram.size),
              static_cast<ssize_t>(telegram.size));
  }
  /// Until a condition holds; at most 20 s, as a busy machine may take.
  template <class Condition>
  bool Listen(const Condition& until) {
    for (int i = 0; i < 10'000; ++i) {
      std::array<std::uint8_t, 256> buffer{};
      const ssize_t n = read(fd_, buffer.data(), buffer.size());
      if (n > 0)
        decoder_.Feed(core::MonoNow(), std::span(buffer).first(static_cast<std::size_t>(n)), *this);
      if (until()) return true;
      if (n <= 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return false;
  }
  bool open_port() const { return fd_ >= 0; }
  int mode_replies = 0;
  std::vector<drivers::SickScan> scans;

 private:
  void OnScan(const drivers::SickScan& scan) override { scans.push_back(scan); }
  void OnMessage(const drivers::SickMessage& message) override {
    if (message.command == 0xA0) ++mode_replies;
  }
  int fd_;
  drivers::SickDecoder decoder_{drivers::SickConfig::Pls101()};
};

TEST(InstrumentRun, TwoScannersSpeakOnTheirOwnPortsAndLeaveNoLinksBehind) {
  std::string folder = testing::TempDir() + "kawara_run_XXXXXX";
  ASSERT_NE(mkdtemp(folder.data()), nullptr);
  const std::filesystem::path run_dir = folder;
  const SimulatedDrive drive = Standing();
  const MotionTrack track(drive.recording);
  const std::vector<AhrsState> trace = MakeAhrsTrace(drive.recording, track, 1);
  const MeasuredMotion motion{
      drive.recording,
      trace,
      drive.recording.begin(),
      drive.recording.end(),
      [&](core::GpsTime t) {
        return drive.truth.trajectory.GeodeticAt(t, Eigen::Vector3d::Zero());
      },
      [&](core::GpsTime t) { return drive.truth.trajectory.AttitudeAt(t).yaw_rad; },
      {{"laser1", Wall, {}}, {"laser2", Wall, {}}}};
  InstrumentOptions options;
  options.run_dir = run_dir;
  options.realtime = false;
  options.lead_s = 0.0;
  std::atomic<bool> stop{false};
  core::Expected<InstrumentSummary> summary;
  std::thread run([&] { summary = RunInstruments(options, motion, nullptr, stop); });
  for (int i = 0; i < 2000 && !std::filesystem::exists(run_dir / "ready"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));

  for (const char* port : {"laser1", "laser2"}) {
    Host host(run_dir / port);
    EXPECT_TRUE(host.open_port()) << port;
    host.Say(drivers::SickCommands().SetBaud(38400).value());
    EXPECT_TRUE(host.Listen([&] { return host.mode_replies == 1; })) << port;
    host.SetBaud(B38400);
    host.Say(drivers::SickCommands().StreamAll());
    EXPECT_TRUE(host.Listen([&] { return host.scans.size() == 2; })) << port;
    if (host.scans.empty()) continue;
    EXPECT_NEAR(host.scans[0].RangeM(180), 3.0, 0.1);
    EXPECT_DOUBLE_EQ(host.scans[0].RangeM(0), 81.91) << "nothing there";
  }
  stop = true;
  run.join();
  ASSERT_TRUE(summary) << summary.error().message;
  ASSERT_EQ(summary->instruments.scanners.size(), 2U);
  EXPECT_GE(summary->instruments.scanners[1].scans, 2U);
  EXPECT_NE(summary->ToText().find("laser2"), std::string::npos);
  for (const char* gone : {"laser1", "laser2", "gps", "ahrs", "ready"})
    EXPECT_FALSE(std::filesystem::is_symlink(run_dir / gone) ||
                 std::filesystem::exists(run_dir / gone))
        << gone;
  std::filesystem::remove_all(run_dir);
}

}  // namespace
}  // namespace kawara::sim
