#include "onboard/check/computer_check.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "onboard/check/device_check.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::onboard {
namespace {

namespace fs = std::filesystem;

/// A computer of which /proc and /sys are files of the test.
class Computer : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.record.folder = (folder_.path() / "log").string();
    config_.record.disk_reserve_mb = 0.0;
    config_.lcm_url = "memq://";  // no network in a unit test
    Write("proc/sys/net/core/rmem_max", "4194304\n");
  }
  void Write(const std::string& name, const std::string& text) {
    const fs::path path = folder_.path() / name;
    fs::create_directories(path.parent_path());
    std::ofstream(path) << text;
  }
  Finding Find(const std::string& subject) {
    const Findings findings = CheckComputer(config_, folder_.path());
    const auto found = std::find_if(findings.begin(), findings.end(), [&](const Finding& f) {
      return f.subject.starts_with(subject);
    });
    return found == findings.end() ? Wrong("nothing found", subject) : *found;
  }

  kawara::testing::TestFolder folder_;
  OnboardConfig config_;
};

TEST_F(Computer, SmallSocketBuffersAreSaidWithTheirCure) {
  EXPECT_EQ(Find("socket buffers").verdict, Verdict::kGood);
  Write("proc/sys/net/core/rmem_max", "212992\n");
  const Finding small = Find("socket buffers");
  EXPECT_EQ(small.verdict, Verdict::kWeak);
  EXPECT_NE(small.text.find("sysctl -w net.core.rmem_max=2097152"), std::string::npos);
}

TEST_F(Computer, GovernorIsLookedAtWhereThereIsOne) {
  EXPECT_EQ(Find("processor governor").subject, "nothing found");
  Write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "performance\n");
  EXPECT_EQ(Find("processor governor").verdict, Verdict::kGood);
  Write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  const Finding slow = Find("processor governor");
  EXPECT_EQ(slow.verdict, Verdict::kWeak);
  EXPECT_NE(slow.text.find("powersave"), std::string::npos);
}

TEST_F(Computer, KernelIsNamed) {
  EXPECT_NE(Find("kernel").text.find("not PREEMPT_RT"), std::string::npos);
  Write("sys/kernel/realtime", "1\n");
  EXPECT_EQ(Find("kernel").text, "PREEMPT_RT");
}

TEST_F(Computer, RecordingNeedsRoomAndAFolder) {
  EXPECT_EQ(Find("recording").verdict, Verdict::kGood) << Find("recording").text;
  EXPECT_FALSE(fs::exists(config_.record.folder)) << "a check leaves nothing behind";
  config_.record.disk_reserve_mb = 1e9;
  EXPECT_EQ(Find("recording").verdict, Verdict::kWrong);
  Write("file", "");
  config_.record.folder = (folder_.path() / "file" / "log").string();
  EXPECT_NE(Find("recording").text.find("is not a folder"), std::string::npos);
}

TEST_F(Computer, WhatIsSwitchedOffIsSaid) {
  config_.realtime = {.priority = 0, .lock_memory = false};
  config_.record.enabled = false;
  for (const char* subject : {"real-time priority", "locked memory", "recording"}) {
    EXPECT_EQ(Find(subject).verdict, Verdict::kWeak) << subject;
    EXPECT_NE(Find(subject).text.find("switched off"), std::string::npos) << subject;
  }
}

TEST(Devices, EachMissingOneIsWrongAndNamed) {
  OnboardConfig config;
  config.gps.device = "/dev/no-gps";
  config.gps.pps.device = "/dev/pps-none";
  config.ahrs.device = "/dev/null";
  config.camera.source = "v4l2";
  config.camera.v4l2.device = "/dev/video-none";
  const Findings findings = CheckDevices(config);
  ASSERT_EQ(findings.size(), 4U);
  const char* const parts[] = {"no such device", "not a serial port", "/dev/video-none",
                               "no such device"};
  for (std::size_t i = 0; i < findings.size(); ++i) {
    EXPECT_EQ(findings[i].verdict, Verdict::kWrong);
    EXPECT_NE(findings[i].text.find(parts[i]), std::string::npos) << findings[i].text;
  }
}

}  // namespace
}  // namespace kawara::onboard
