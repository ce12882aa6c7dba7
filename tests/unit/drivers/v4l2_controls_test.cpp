#include "drivers/v4l2_controls.hpp"

#include <gtest/gtest.h>

#include "tests/unit/drivers/scripted_camera.hpp"

namespace kawara::drivers {
namespace {

class V4l2ControlsTest : public ::testing::Test {
 protected:
  V4l2ControlsTest() {
    camera_.controls[0x00980900] = {V4L2_CTRL_TYPE_INTEGER, "Brightness", -64, 64, 0, 0, {}};
    camera_.controls[0x0098090c] = {
        V4L2_CTRL_TYPE_BOOLEAN, "White Balance, Automatic", 0, 1, 1, 0, {}};
    camera_.controls[0x00980918] = {V4L2_CTRL_TYPE_MENU,      "Power Line Frequency", 0, 2, 0, 0,
                                    {"Disabled", "", "60 Hz"}};
    camera_.controls[0x00980919] = {
        V4L2_CTRL_TYPE_INTEGER, "Temperature", 0, 9, 0, V4L2_CTRL_FLAG_READ_ONLY, {}};
    camera_.controls[0x0098091a] = {V4L2_CTRL_TYPE_BUTTON,     "Do It", 0, 0, 0,
                                    V4L2_CTRL_FLAG_WRITE_ONLY, {}};
    camera_.controls[0x0098091b] = {V4L2_CTRL_TYPE_BITMASK, "Lines", 0, 0x80000003LL, 0, 0, {}};
    camera_.controls[0x0098091c] = {V4L2_CTRL_TYPE_INTEGER,  "Off", 0, 1, 0,
                                    V4L2_CTRL_FLAG_DISABLED, {}};
    auto device = V4l2Device::Take("/dev/video0", std::make_unique<ScriptedNode>(camera_));
    device_.emplace(std::move(*device));
    auto controls = V4l2Controls::Read(*device_);
    controls_.emplace(std::move(*controls));
  }

  ScriptedCamera camera_;
  std::optional<V4l2Device> device_;
  std::optional<V4l2Controls> controls_;
};

TEST_F(V4l2ControlsTest, NamesAreTheOnesPeopleWrite) {
  const std::pair<const char*, const char*> cases[] = {
      {"Exposure Time, Absolute", "exposure_time_absolute"},
      {"White Balance, Automatic", "white_balance_automatic"},
      {"Focus (absolute)", "focus_absolute"},
      {"  LED1 Mode ", "led1_mode"},
      {"", ""}};
  for (const auto& [title, name] : cases) EXPECT_EQ(V4l2ControlName(title), name);
}

TEST_F(V4l2ControlsTest, ListsWhatIsNotDisabled) {
  EXPECT_EQ(controls_->all().size(), 6U);
  EXPECT_EQ(controls_->Find("off"), nullptr);
  EXPECT_EQ(controls_->Find("0x980900"), controls_->Find("brightness"));
  EXPECT_EQ(RangeText(*controls_->Find("brightness")), "-64..64");
  EXPECT_EQ(RangeText(*controls_->Find("power_line_frequency")), "one of 0 (Disabled), 2 (60 Hz)");
}

TEST_F(V4l2ControlsTest, ValuesInEveryWayTheyMayBeWritten) {
  struct {
    const char* name;
    const char* value;
    std::int64_t set;
  } const cases[] = {
      {"brightness", "-64", -64},
      {"brightness", "0x10", 16},
      {"white_balance_automatic", "off", 0},
      {"white_balance_automatic", "True", 1},
      {"power_line_frequency", "60 hz", 2},
      {"power_line_frequency", "0", 0},
      {"do_it", "now", 1},
      {"lines", "0x80000001", -2147483647},
  };
  for (const auto& one : cases) {
    const auto set = controls_->Set(one.name, one.value);
    ASSERT_TRUE(set) << set.error().message;
    EXPECT_EQ(camera_.sets.back().second, one.set) << one.name << " " << one.value;
  }
  EXPECT_EQ(controls_->Get("lines").value(), 0x80000001LL);
}

TEST_F(V4l2ControlsTest, WrongOnesAreAllReportedAndTheRightOnesSet) {
  const auto set = controls_->Set({{"brightness", "65"},
                                   {"brightness", "much"},
                                   {"brightness", ""},
                                   {"power_line_frequency", "1"},
                                   {"power_line_frequency", "50 Hz"},
                                   {"temperature", "3"},
                                   {"lines", "4"},
                                   {"white_balance_automatic", "2"},
                                   {"brightness", "7"}});
  ASSERT_FALSE(set);
  for (const char* const part :
       {"control brightness = 65: expected -64..64", "brightness = much: expected",
        "power_line_frequency = 1: expected one of 0 (Disabled), 2 (60 Hz)",
        "power_line_frequency = 50 Hz: expected", "temperature can only be read",
        "lines = 4: expected bits of 2147483651", "white_balance_automatic = 2: expected 0 or 1"}) {
    EXPECT_NE(set.error().message.find(part), std::string::npos) << part << "\n"
                                                                 << set.error().message;
  }
  EXPECT_EQ(camera_.sets, (std::vector<std::pair<std::string, std::int64_t>>{{"brightness", 7}}));
}

TEST_F(V4l2ControlsTest, RefusalsOfTheKernelAreExplained) {
  const std::pair<int, const char*> cases[] = {
      {EBUSY, "cannot be changed now"},
      {ERANGE, "the camera refuses 1: expected -64..64"},
      {EACCES, "the camera refuses 1"},
      {ENODEV, "unplugged"},
  };
  for (const auto& [error, part] : cases) {
    camera_.Fail(VIDIOC_S_EXT_CTRLS, error);
    const auto set = controls_->Set("brightness", "1");
    ASSERT_FALSE(set);
    EXPECT_NE(set.error().message.find(part), std::string::npos) << set.error().message;
  }
}

TEST_F(V4l2ControlsTest, WhatIsNotThereIsAnsweredWithWhatIs) {
  EXPECT_EQ(controls_->Get("gain").error().message,
            "camera /dev/video0 has no control \"gain\"; it has: brightness "
            "white_balance_automatic power_line_frequency temperature do_it lines");
  EXPECT_EQ(controls_->Get("do_it").error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_EQ(controls_->ValueText(*controls_->Find("do_it")), "-");
  EXPECT_EQ(controls_->ValueText(*controls_->Find("power_line_frequency")), "0 (Disabled)");
}

}  // namespace
}  // namespace kawara::drivers
