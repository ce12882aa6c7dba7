// A USB serial adapter (ftdi_sio) that is pulled and plugged while it is in use. Its other end is a
// serial port of this machine; QEMU, which is its cable, takes orders by another
// (tests/vm/machine.sh).
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <numeric>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/reconnecting_port.hpp"
#include "tests/vm/command.hpp"

namespace kawara::drivers {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAdapter = "/dev/ttyUSB0";
constexpr const char* kFarEnd = "/dev/ttyS2";
constexpr const char* kOrders = "/dev/ttyS3";
constexpr core::Duration kLong = core::Seconds(60);

SerialConfig Line(const std::string& device) {
  SerialConfig config;
  config.device = device;
  config.baud_bps = 115200;
  return config;
}

bool WaitUntil(const std::function<bool()>& condition, core::Duration patience = kLong) {
  const core::MonoTime deadline = core::MonoNow() + patience;
  while (core::MonoNow() < deadline) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return condition();
}

class UsbSerial : public ::testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(WaitUntil([] { return fs::exists(kAdapter); }));
    auto far = SerialPort::Open(Line(kFarEnd));
    ASSERT_TRUE(far) << far.error().message;
    far_.emplace(std::move(*far));
  }
  /// Leaves the machine as it was found.
  void TearDown() override {
    if (!fs::exists(kAdapter)) Plug();
  }
  /// QEMU takes what it said itself for the beginning of an order if it was echoed before the port
  /// became a raw one: a carriage return ends that.
  static void Tell(const std::string& order) {
    auto orders = SerialPort::Open(Line(kOrders));
    ASSERT_TRUE(orders) << orders.error().message;
    const std::string line = "\r" + order + "\r";
    WriteAll(*orders, {reinterpret_cast<const std::uint8_t*>(line.data()), line.size()});
    std::this_thread::sleep_for(
        std::chrono::milliseconds(300));  // it leaves before the port closes
  }
  static bool Listed() {
    std::ifstream devices("/proc/tty/driver/usbserial");
    const std::string text(std::istreambuf_iterator<char>(devices), {});
    return text.find("module:ftdi_sio") != std::string::npos;
  }
  static void Make(bool plugged, const std::string& order) {
    for (int k = 0; k < 5 && Listed() != plugged; ++k) {
      Tell(order);
      WaitUntil([&] { return Listed() == plugged; }, core::Seconds(5));
    }
    ASSERT_EQ(Listed(), plugged) << order;
  }
  static void Pull() { Make(false, "device_del adapter"); }
  static void Plug() { Make(true, "device_add usb-serial,id=adapter,chardev=adapter"); }
  /// Everything, in as many pieces as the driver takes.
  static void WriteAll(SerialPort& port, std::span<const std::uint8_t> bytes) {
    const core::MonoTime deadline = core::MonoNow() + kLong;
    while (!bytes.empty() && core::MonoNow() < deadline) {
      const auto written = port.Write(bytes);
      ASSERT_TRUE(written) << written.error().message;
      bytes = bytes.subspan(*written);
      if (*written == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(bytes.empty());
  }
  static std::vector<std::uint8_t> ReadSome(SerialPort& port, std::size_t size) {
    std::vector<std::uint8_t> all;
    WaitUntil([&] {
      std::array<std::uint8_t, 256> buffer{};
      const auto n = port.Read(buffer);
      if (n) all.insert(all.end(), buffer.begin(), buffer.begin() + static_cast<long>(*n));
      return all.size() >= size;
    });
    return all;
  }
  /// Serves the port until it says this.
  static bool Says(ReconnectingPort& port, PortEventKind kind) {
    return WaitUntil([&] {
      const core::MonoTime now = core::MonoNow();
      port.Service(now);
      std::array<std::uint8_t, 256> buffer{};
      (void)port.Read(now, buffer);
      for (PortEvent event; port.TryPopEvent(event);) {
        if (event.kind == kind) return true;
      }
      return false;
    });
  }
  /// A byte sent at the far end arrives.
  bool Hears(ReconnectingPort& port) {
    const std::uint64_t before = port.counters().bytes_in;
    return WaitUntil([&] {
      static constexpr std::array<std::uint8_t, 1> kByte{0x55};
      (void)far_->Write(kByte);
      const core::MonoTime now = core::MonoNow();
      port.Service(now);
      std::array<std::uint8_t, 256> buffer{};
      (void)port.Read(now, buffer);
      return port.counters().bytes_in > before;
    });
  }

  std::optional<SerialPort> far_;
};

TEST_F(UsbSerial, CarriesEveryByteBothWays) {
  auto near = SerialPort::Open(Line(kAdapter));
  ASSERT_TRUE(near) << near.error().message;
  std::vector<std::uint8_t> bytes(3000);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{0});  // also XON, XOFF, CR, 0xFF
  for (auto [from, to] : {std::pair(&*far_, &*near), std::pair(&*near, &*far_)}) {
    std::vector<std::uint8_t> heard;
    std::thread listener([&heard, to = to, &bytes] { heard = ReadSome(*to, bytes.size()); });
    WriteAll(*from, bytes);
    listener.join();
    EXPECT_EQ(heard, bytes);
  }
}

TEST_F(UsbSerial, IsLostWhenPulledAndBackWhenPlugged) {
  ReconnectConfig config;
  config.serial = Line(kAdapter);
  ReconnectingPort port(config);
  ASSERT_TRUE(Says(port, PortEventKind::kOpened));
  ASSERT_TRUE(Hears(port));
  Pull();
  ASSERT_TRUE(Says(port, PortEventKind::kLost));
  EXPECT_FALSE(port.is_open());
  EXPECT_TRUE(WaitUntil([] { return !fs::exists(kAdapter); }));
  Plug();
  ASSERT_TRUE(Says(port, PortEventKind::kOpened));
  EXPECT_TRUE(Hears(port));
  EXPECT_EQ(port.counters().lost, 1U);
  EXPECT_FALSE(fs::exists("/dev/ttyUSB1")) << "closed at once, it comes back under its number";
}

TEST_F(UsbSerial, IsFoundUnderAnotherNumberByItsLink) {
  const fs::path link = "/tmp/by-id-adapter";
  fs::remove(link);
  fs::create_symlink(kAdapter, link);
  ReconnectConfig config;
  config.serial = Line(link.string());
  ReconnectingPort port(config);
  ASSERT_TRUE(Says(port, PortEventKind::kOpened));
  // Somebody else does not let go of the dead device: its number stays taken.
  const int holder = open(kAdapter, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(holder, 0);
  Pull();
  ASSERT_TRUE(Says(port, PortEventKind::kLost));
  Plug();
  ASSERT_TRUE(WaitUntil([] { return fs::exists("/dev/ttyUSB1"); }));
  fs::remove(link);
  fs::create_symlink("/dev/ttyUSB1", link);  // what udev does
  EXPECT_TRUE(Says(port, PortEventKind::kOpened));
  EXPECT_TRUE(Hears(port));
  close(holder);
  // Back under its own number for those who come after.
  Pull();
  ASSERT_TRUE(Says(port, PortEventKind::kLost));
  ASSERT_TRUE(WaitUntil([] { return !fs::exists("/dev/ttyUSB1"); }));
  Plug();
  EXPECT_TRUE(WaitUntil([] { return fs::exists(kAdapter); }));
}

/// GGA and RMC of that second and tenth of the day.
std::string Burst(int tenths) {
  const auto sentence = [](const std::string& body) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    std::array<char, 8> end{};
    std::snprintf(end.data(), end.size(), "*%02X\r\n", sum);
    return "$" + body + end.data();
  };
  std::array<char, 16> time{};
  std::snprintf(time.data(), time.size(), "1200%02d.%d0", tenths / 10 % 60, tenths % 10);
  return sentence("GPGGA," + std::string(time.data()) +
                  ",3510.0000000,N,13658.0000000,E,4,09,0.9,50.000,M,37.500,M,1.0,0001") +
         sentence("GPRMC," + std::string(time.data()) +
                  ",A,3510.0000000,N,13658.0000000,E,0.00,090.0,200626,,,A");
}

/// The number that the log's message in this line of the table has.
long NumberAt(const std::string& table, std::size_t position) {
  return std::atol(table.c_str() + table.rfind('\n', position) + 1);
}

TEST_F(UsbSerial, TheRobotGoesOnWhenItsReceiverIsPulledAndPlugged) {
  std::ofstream("/tmp/usb_robot.yaml")
      << "robot: {name: usb}\n"
         "gps: {device: /dev/ttyUSB0, baud_bps: 115200, profile: nmea, configure: false}\n"
         "ahrs: {device: /dev/none_ahrs, model: 100}\n"
         "camera: {source: none}\n"
         "picture: {camera: doughnut, quality: 80}\n"
         "schedule: {every_epochs: 0}\n"
         "record: {folder: /tmp/usb_log, disk_reserve_mb: 0}\n";
  std::atomic<bool> over{false};
  std::thread receiver([&] {
    for (int tenths = 0; !over; tenths += 2) {
      const std::string burst = Burst(tenths);
      (void)far_->Write({reinterpret_cast<const std::uint8_t*>(burst.data()), burst.size()});
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  });
  vm::Answer robot;
  std::thread program([&robot] {
    robot = vm::Command("kawara-onboard --config /tmp/usb_robot.yaml --duration 22");
  });
  std::this_thread::sleep_for(std::chrono::seconds(9));
  Pull();
  std::this_thread::sleep_for(std::chrono::seconds(3));
  Plug();
  program.join();
  over = true;
  receiver.join();
  ASSERT_EQ(robot.status, 0) << robot.text;
  const vm::Answer events = vm::Command("kawara-log export --channel EVENT --out - /tmp/usb_log");
  const std::size_t lost = events.text.find("lost /dev/ttyUSB0");
  ASSERT_NE(lost, std::string::npos) << events.text;
  const std::size_t back = events.text.find("opened /dev/ttyUSB0", lost);
  ASSERT_NE(back, std::string::npos) << events.text;
  const vm::Answer fixes = vm::Command("kawara-log export --channel GNSS --out - /tmp/usb_log");
  std::istringstream lines(fixes.text);
  long before = 0, after = 0;
  for (std::string line; std::getline(lines, line);) {
    const long number = std::atol(line.c_str());
    if (number == 0) continue;  // the head and the program's last words
    if (number < NumberAt(events.text, lost)) ++before;
    if (number > NumberAt(events.text, back)) ++after;
  }
  EXPECT_GT(before, 5);
  EXPECT_GT(after, 5);
}

}  // namespace
}  // namespace kawara::drivers
