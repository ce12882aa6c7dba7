// Trigger lines on the kernel's own drivers. The GPIO chip is gpio-pci-idio-16 bound to another
// card, whose memory (BAR 2) takes the place of the registers: what the driver writes can be read
// there. The serial port is a 16550.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "drivers/trigger_line.hpp"

namespace kawara::drivers {
namespace {

namespace fs = std::filesystem;
using Kind = TriggerLineConfig::Kind;

constexpr const char* kDriver = "/sys/bus/pci/drivers/pci-idio-16";

/// The registers of the first eight outputs, and the chip over them.
class GpioOutputs : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists("/dev/gpiochip0")) {
      std::ofstream(std::string(kDriver) + "/new_id") << "1000 0012" << std::flush;
    }
    ASSERT_TRUE(fs::exists("/dev/gpiochip0"));
    for (const auto& entry : fs::directory_iterator(kDriver)) {
      if (entry.path().filename().string().find(':') == std::string::npos) continue;
      const int fd = open((entry.path() / "resource2").c_str(), O_RDWR | O_CLOEXEC);
      ASSERT_GE(fd, 0);
      void* const memory = mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
      close(fd);
      ASSERT_NE(memory, MAP_FAILED);
      outputs_ = static_cast<volatile unsigned char*>(memory);
    }
    ASSERT_NE(outputs_, nullptr);
    *outputs_ = 0;
  }
  static TriggerLineConfig Config(const std::string& line, bool active_low = false) {
    TriggerLineConfig config;
    config.kind = Kind::kGpio;
    config.device = "gpiochip0";
    config.line = line;
    config.active_low = active_low;
    return config;
  }
  volatile unsigned char* outputs_ = nullptr;
};

TEST_F(GpioOutputs, FollowWhatIsSet) {
  const auto line = OpenTriggerLine(Config("3"));
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_EQ(*outputs_ & 0x08, 0);
  ASSERT_TRUE((*line)->Set(true));
  EXPECT_EQ(*outputs_ & 0x08, 0x08);
  ASSERT_TRUE((*line)->Set(false));
  EXPECT_EQ(*outputs_ & 0x08, 0);
  bool seen = false;
  std::thread watch([&] {
    for (int i = 0; i < 2000 && !seen; ++i) {
      seen = (*outputs_ & 0x08) != 0;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  ASSERT_TRUE((*line)->Pulse(core::Milliseconds(300)));
  watch.join();
  EXPECT_TRUE(seen);
  EXPECT_EQ(*outputs_ & 0x08, 0);
}

TEST_F(GpioOutputs, ActiveLowRestsHigh) {
  const auto line = OpenTriggerLine(Config("5", true));
  ASSERT_TRUE(line) << line.error().message;
  EXPECT_EQ(*outputs_ & 0x20, 0x20);
  ASSERT_TRUE((*line)->Set(true));
  EXPECT_EQ(*outputs_ & 0x20, 0);
}

TEST_F(GpioOutputs, AreFoundByNameToo) {
  const auto line = OpenTriggerLine(Config("OUT2"));
  ASSERT_TRUE(line) << line.error().message;
  ASSERT_TRUE((*line)->Set(true));
  EXPECT_EQ(*outputs_ & 0x04, 0x04);
}

TEST_F(GpioOutputs, SayWhatIsWrong) {
  const auto none = OpenTriggerLine(Config("40"));
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("there is none; it has 32"), std::string::npos)
      << none.error().message;
  const auto holder = OpenTriggerLine(Config("3"));
  ASSERT_TRUE(holder) << holder.error().message;
  const auto busy = OpenTriggerLine(Config("3"));
  ASSERT_FALSE(busy);
  EXPECT_NE(busy.error().message.find("in use by kawaraban"), std::string::npos)
      << busy.error().message;
}

/// Looks at a port's outputs from beside. Opened before the line is: opening raises them.
class Onlooker {
 public:
  explicit Onlooker(const char* path)
      : fd_(open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    EXPECT_GE(fd_, 0) << path;
  }
  ~Onlooker() { close(fd_); }
  int Bits() const {
    int bits = 0;
    EXPECT_EQ(ioctl(fd_, TIOCMGET, &bits), 0);
    return bits;
  }

 private:
  int fd_;
};

TEST(ModemLine, SetsItsLineAndNoOther) {
  constexpr const char* kPort = "/dev/ttyS1";
  for (const auto& [kind, bit] :
       {std::pair(Kind::kRts, TIOCM_RTS), std::pair(Kind::kDtr, TIOCM_DTR)}) {
    for (const bool active_low : {false, true}) {
      TriggerLineConfig config;
      config.kind = kind;
      config.device = kPort;
      config.active_low = active_low;
      const Onlooker port(kPort);
      const auto line = OpenTriggerLine(config);
      ASSERT_TRUE(line) << line.error().message;
      const int other = (TIOCM_RTS | TIOCM_DTR) & ~bit;
      ASSERT_TRUE((*line)->Set(true));
      const int active = port.Bits();
      ASSERT_TRUE((*line)->Set(false));
      const int rest = port.Bits();
      EXPECT_EQ((active & bit) != 0, !active_low);
      EXPECT_EQ((rest & bit) != 0, active_low);
      EXPECT_EQ(active & other, rest & other);
    }
  }
}

}  // namespace
}  // namespace kawara::drivers
