// kawara-onboard as the service of configs/systemd, installed as that file's head says, under
// Debian's systemd: who it runs as, what it may do, and what happens when it hangs or dies.
#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <sstream>
#include <string>
#include <thread>

#include "tests/vm/command.hpp"

namespace kawara::vm {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnit = "kawara-onboard.service";

std::string Text(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The words after "NAME:" in a file of /proc.
std::string Field(const fs::path& file, const std::string& name) {
  std::istringstream lines(Text(file));
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(name + ":")) return line.substr(name.size() + 1);
  }
  return {};
}

int System(const std::string& command) {
  const int status = std::system((command + " >/tmp/systemctl.out 2>&1").c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// One property of the unit.
std::string Property(const std::string& name) {
  System(std::string("systemctl show --value -p ") + name + " " + kUnit);
  std::string value = Text("/tmp/systemctl.out");
  value.erase(value.find_last_not_of(" \n") + 1);
  return value;
}

bool WaitUntil(const std::function<bool()>& condition) {
  for (int i = 0; i < 240 && !condition(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
  }
  return condition();
}

class Service : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const fs::path programs = fs::canonical("/proc/self/exe").parent_path();
    const fs::path source = KAWARA_SOURCE_DIR;
    fs::create_directories("/opt/kawaraban/bin");
    fs::create_directories("/etc/kawaraban");
    fs::copy_file(programs / "kawara-onboard", "/opt/kawaraban/bin/kawara-onboard",
                  fs::copy_options::overwrite_existing);
    fs::copy_file(source / "configs/systemd" / kUnit, fs::path("/etc/systemd/system") / kUnit,
                  fs::copy_options::overwrite_existing);
    std::ofstream("/etc/kawaraban/robot.yaml")
        << "robot: {name: service}\n"
           "gps: {device: /dev/ttyUSB0, baud_bps: 115200, profile: nmea, configure: false}\n"
           "ahrs: {device: /dev/none_ahrs, model: 100}\n"
           "camera: {source: none}\n"
           "picture: {camera: doughnut, quality: 80}\n"
           "schedule: {every_epochs: 0}\n"
           "record: {folder: /var/lib/kawaraban/log, disk_reserve_mb: 0}\n";
    ASSERT_EQ(System("chgrp dialout /dev/ttyUSB0 && chmod 660 /dev/ttyUSB0"), 0);  // as udev does
    ASSERT_EQ(System("systemctl daemon-reload"), 0) << Text("/tmp/systemctl.out");
  }
  void SetUp() override {
    // Answers when the program has said that it is ready.
    ASSERT_EQ(System(std::string("systemctl start ") + kUnit), 0)
        << Text("/tmp/systemctl.out") << Property("Result");
    ASSERT_EQ(Property("ActiveState"), "active");
  }
  void TearDown() override { System(std::string("systemctl stop ") + kUnit); }
  static int Pid() { return std::atoi(Property("MainPID").c_str()); }
  static int Restarts() { return std::atoi(Property("NRestarts").c_str()); }
  /// It is another process and ready.
  static bool ReplacedAndReady(int pid) {
    return WaitUntil([pid] {
      const int now = Pid();
      return now != 0 && now != pid && Property("SubState") == "running";
    });
  }
};

TEST_F(Service, RunsAsAnOrdinaryUserWithRealTimeAndLockedMemory) {
  const fs::path process = "/proc/" + std::to_string(Pid());
  EXPECT_EQ(std::atoi(Field(process / "status", "Uid").c_str()), 900);
  EXPECT_NE(Field(process / "status", "Groups").find("20"), std::string::npos) << "dialout";
  EXPECT_GT(std::atol(Field(process / "status", "VmLck").c_str()), 1000) << "kB";
  int real_time = 0;
  for (const auto& task : fs::directory_iterator(process / "task")) {
    const int tid = std::atoi(task.path().filename().c_str());
    sched_param parameters{};
    if (sched_getscheduler(tid) != SCHED_FIFO || sched_getparam(tid, &parameters) != 0) continue;
    if (parameters.sched_priority == 60) ++real_time;
  }
  EXPECT_EQ(real_time, 1) << "the loop that reads, estimates and triggers";
}

TEST_F(Service, TheOtherUnitsAreUnderstoodToo) {
  for (const char* unit : {"kawara-mapper.service", "kawara-station.service"}) {
    fs::copy_file(fs::path(KAWARA_SOURCE_DIR) / "configs/systemd" / unit,
                  fs::path("/etc/systemd/system") / unit, fs::copy_options::overwrite_existing);
    // Every complaint is printed: unknown settings, bad values. The programs are not installed
    // here.
    System(std::string("systemd-analyze verify --man=no ") + unit);
    std::istringstream complaints(Text("/tmp/systemctl.out"));
    for (std::string line; std::getline(complaints, line);) {
      EXPECT_NE(line.find("is not executable"), std::string::npos) << line;
    }
  }
}

TEST_F(Service, IsStartedAnewWhenItHangs) {
  const int pid = Pid(), restarts = Restarts();
  ASSERT_EQ(kill(pid, SIGSTOP), 0);
  EXPECT_TRUE(ReplacedAndReady(pid)) << Property("Result");
  EXPECT_EQ(Restarts(), restarts + 1);
}

TEST_F(Service, IsStartedAnewWhenItDiesAndWhatItRecordedStaysWhole) {
  const int pid = Pid();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  ASSERT_EQ(kill(pid, SIGKILL), 0);
  ASSERT_TRUE(ReplacedAndReady(pid)) << Property("Result");
  ASSERT_EQ(System(std::string("systemctl stop ") + kUnit), 0);
  EXPECT_EQ(Property("Result"), "success");
  const Answer info = Command("kawara-log info /var/lib/kawaraban/log");
  EXPECT_EQ(info.status, 0) << info.text;
  EXPECT_TRUE(Has(info, "COUNTERS")) << info.text;
  const Answer events = Command("kawara-log export --channel EVENT --out - /var/lib/kawaraban/log");
  EXPECT_TRUE(Has(events, "opened /dev/ttyUSB0")) << "by its group: " << events.text;
}

}  // namespace
}  // namespace kawara::vm
