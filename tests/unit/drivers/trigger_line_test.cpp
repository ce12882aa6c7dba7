#include "drivers/trigger_line.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace kawara::drivers {
namespace {

using Kind = TriggerLineConfig::Kind;

TEST(OpenTriggerLine, SaysWhatIsWrong) {
  struct Case {
    Kind kind;
    const char* device;
    const char* part;
  };
  const Case cases[] = {
      {Kind::kGpio, "gpiochip99", "there is none of this name (`gpiodetect`"},
      {Kind::kGpio, "/dev/null", "is not a GPIO chip"},
      {Kind::kRts, "/dev/no-port", "no such device"},
      {Kind::kDtr, "/dev/null", "not a serial port"},
      {Kind::kNone, "", "none is configured"},
  };
  for (const Case& c : cases) {
    TriggerLineConfig config;
    config.kind = c.kind;
    config.device = c.device;
    config.line = "0";
    const auto line = OpenTriggerLine(config);
    ASSERT_FALSE(line) << c.device;
    EXPECT_TRUE(line.error().message.starts_with("trigger")) << line.error().message;
    EXPECT_NE(line.error().message.find(c.part), std::string::npos) << line.error().message;
  }
}

/// Remembers what was set and when.
class Remembering final : public TriggerLine {
 public:
  core::Expected<void> Set(bool active) override {
    if (broken) return core::Fail(core::ErrorCode::kIo, "broken");
    set.emplace_back(active, core::MonoNow());
    return {};
  }
  bool broken = false;
  std::vector<std::pair<bool, core::MonoTime>> set;
};

TEST(TriggerLine, PulseIsActiveForItsLength) {
  Remembering line;
  ASSERT_TRUE(line.Pulse(core::Milliseconds(5)));
  ASSERT_EQ(line.set.size(), 2U);
  EXPECT_TRUE(line.set[0].first);
  EXPECT_FALSE(line.set[1].first);
  EXPECT_GE(line.set[1].second - line.set[0].second, core::Milliseconds(4));
  line.broken = true;
  EXPECT_FALSE(line.Pulse(core::Milliseconds(5)));
}

}  // namespace
}  // namespace kawara::drivers
