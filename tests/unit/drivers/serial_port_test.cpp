#include "drivers/serial_port.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>

#include <filesystem>
#include <fstream>
#include <functional>

#include "drivers/serial_diagnosis.hpp"
#include "tests/support/pseudo_terminal.hpp"

namespace kawara::drivers {
namespace {

using core::ErrorCode;
using core::Milliseconds;
using core::MonoTime;
using core::Nanoseconds;
using kawara::testing::PseudoTerminal;
using kawara::testing::WaitReadable;
using ::testing::HasSubstr;
using ::testing::Not;

SerialConfig ConfigFor(const std::string& path) {
  SerialConfig config;
  config.device = path;
  return config;
}

/// Runs `body` in a child that has become user nobody, and returns what it returned as text.
std::string AsNobody(const std::function<std::string()>& body) {
  int ends[2];
  if (pipe(ends) != 0) return "no pipe";
  const pid_t child = fork();
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    std::string text = "cannot become nobody";
    if (setgid(kNobody) == 0 && setuid(kNobody) == 0) text = body();
    const ssize_t n = write(ends[1], text.data(), text.size());
    _exit(n == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string text;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof(buffer))) > 0;)
    text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  waitpid(child, nullptr, 0);
  return text;
}

std::string OpenMessage(const SerialConfig& config) {
  const auto port = SerialPort::Open(config);
  return port ? "opened" : port.error().message;
}

TEST(SerialPort, BytesPassUnchangedBothWays) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port) << port.error().message;
  // Everything a cooked line would translate, eat or echo.
  std::string all;
  for (int c = 0; c < 256; ++c) all.push_back(static_cast<char>(c));
  pty.Send(all);
  ASSERT_TRUE(WaitReadable(port->fd()));
  std::array<std::uint8_t, 512> buffer{};
  const auto n = port->Read(buffer);
  ASSERT_TRUE(n);
  EXPECT_EQ(std::string(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*n)), all);
  ASSERT_EQ(port->Write(std::span(buffer).first(256)).value_or(0), 256U);
  ASSERT_TRUE(WaitReadable(pty.fd()));
  EXPECT_EQ(pty.Receive(), all);
}

TEST(SerialPort, ReadWithoutDataReturnsZeroAtOnce) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(port->Read(buffer).value_or(99), 0U);
}

TEST(SerialPort, InputFromBeforeOpenIsThrownAway) {
  PseudoTerminal pty;
  // Somebody must have the line open for the bytes to be queued at all.
  const int earlier = open(pty.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  pty.Send("\nold news\n");
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port) << port.error().message;
  close(earlier);
  std::array<std::uint8_t, 64> buffer{};
  EXPECT_EQ(port->Read(buffer).value_or(99), 0U);
}

TEST(SerialPort, UnplugIsUnavailableForReadAndWrite) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  pty.Unplug();
  ASSERT_TRUE(WaitReadable(port->fd()));
  std::array<std::uint8_t, 8> buffer{};
  const auto n = port->Read(buffer);
  ASSERT_FALSE(n);
  EXPECT_EQ(n.error().code, ErrorCode::kUnavailable);
  const auto written = port->Write(buffer);
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().code, ErrorCode::kUnavailable);
}

TEST(SerialPort, FullLineTakesNoMoreButDoesNotBlock) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  const std::vector<std::uint8_t> block(4096, 'x');
  std::size_t total = 0;
  std::size_t last = 1;
  for (int i = 0; i < 1000 && last > 0; ++i) {
    const auto n = port->Write(block);
    ASSERT_TRUE(n);
    last = *n;
    total += last;
  }
  EXPECT_EQ(last, 0U) << "after " << total << " bytes";
}

TEST(SerialPort, SettingsAreRawAndKeepTheLinesAtClose) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  termios line{};
  ASSERT_EQ(tcgetattr(port->fd(), &line), 0);
  EXPECT_EQ(line.c_lflag & static_cast<tcflag_t>(ICANON | ECHO | ISIG | IEXTEN), 0U);
  EXPECT_EQ(line.c_iflag & static_cast<tcflag_t>(IXON | IXOFF | ICRNL | INLCR | IGNCR | ISTRIP),
            0U);
  EXPECT_EQ(line.c_oflag & static_cast<tcflag_t>(OPOST), 0U);
  EXPECT_EQ(line.c_cflag & static_cast<tcflag_t>(HUPCL | CRTSCTS | CSTOPB), 0U);
  EXPECT_NE(line.c_cflag & static_cast<tcflag_t>(CLOCAL), 0U);
  EXPECT_NE(fcntl(port->fd(), F_GETFD) & FD_CLOEXEC, 0);
  EXPECT_NE(fcntl(port->fd(), F_GETFL) & O_NONBLOCK, 0);
}

class SerialPortBaud : public ::testing::TestWithParam<int> {};
TEST_P(SerialPortBaud, IsGranted) {
  PseudoTerminal pty;
  SerialConfig config = ConfigFor(pty.path());
  config.baud_bps = GetParam();
  auto port = SerialPort::Open(config);
  ASSERT_TRUE(port) << port.error().message;
  EXPECT_EQ(port->granted().baud_bps, GetParam());
  EXPECT_EQ(port->character_time(), Nanoseconds(10'000'000'000LL / GetParam()));
}
// 500001 and 56800 have no termios name.
INSTANTIATE_TEST_SUITE_P(Rates, SerialPortBaud,
                         ::testing::Values(300, 4800, 9600, 19200, 38400, 57600, 115200, 230400,
                                           460800, 500000, 921600, 3000000, 56800, 500001));

TEST(SerialPort, BaudCanChangeWhileOpen) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  ASSERT_TRUE(port->SetBaud(9600));
  EXPECT_EQ(port->granted().baud_bps, 9600);
  const auto impossible = port->SetBaud(7);
  ASSERT_FALSE(impossible);
  EXPECT_THAT(impossible.error().message, HasSubstr("expected 50..4000000"));
  EXPECT_EQ(port->granted().baud_bps, 9600);
}

TEST(SerialPort, ParityThatDidNotStickShowsInGranted) {
  PseudoTerminal pty;
  SerialConfig config = ConfigFor(pty.path());
  config.format = SerialFormat::k8E1;
  auto port = SerialPort::Open(config);
  ASSERT_TRUE(port) << port.error().message;
  // What the driver keeps is the kernel's business; that we report what it kept is ours.
  termios line{};
  ASSERT_EQ(tcgetattr(port->fd(), &line), 0);
  const bool parity = (line.c_cflag & static_cast<tcflag_t>(PARENB)) != 0;
  EXPECT_EQ(port->granted().format, parity ? SerialFormat::k8E1 : SerialFormat::k8N1);
  EXPECT_TRUE(port->granted().pseudo_terminal);
}

TEST(SerialPort, NoModemLinesIsAnError) {
  PseudoTerminal pty;
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  EXPECT_FALSE(port->granted().modem_lines);
  const auto set = port->SetModemLines(true, std::nullopt);
  ASSERT_FALSE(set);
  EXPECT_EQ(set.error().code, ErrorCode::kUnavailable);
  EXPECT_TRUE(port->SetModemLines(std::nullopt, std::nullopt));
  EXPECT_FALSE(port->LineErrors().has_value());
}

TEST(SerialPort, SecondOpenerIsToldWhoHoldsThePort) {
  PseudoTerminal pty;
  int go[2], ready[2];
  ASSERT_EQ(pipe(go), 0);
  ASSERT_EQ(pipe(ready), 0);
  const pid_t holder = fork();
  if (holder == 0) {
    auto port = SerialPort::Open(ConfigFor(pty.path()));
    char c = port ? 'y' : 'n';
    (void)!write(ready[1], &c, 1);
    (void)!read(go[0], &c, 1);
    _exit(0);
  }
  char c = 0;
  ASSERT_EQ(read(ready[0], &c, 1), 1);
  ASSERT_EQ(c, 'y');
  const auto second = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().message, HasSubstr("in use by"));
  EXPECT_THAT(second.error().message, HasSubstr("process " + std::to_string(holder)));
  ASSERT_EQ(write(go[1], &c, 1), 1);
  waitpid(holder, nullptr, 0);
  EXPECT_EQ(OpenMessage(ConfigFor(pty.path())), "opened") << "the lock dies with its holder";
  for (const int fd : {go[0], go[1], ready[0], ready[1]}) close(fd);
}

TEST(SerialPort, HolderIsFoundByItsLockWithoutRights) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to become nobody";
  PseudoTerminal pty;
  ASSERT_EQ(chmod(pty.path().c_str(), 0666), 0);
  auto port = SerialPort::Open(ConfigFor(pty.path()));
  ASSERT_TRUE(port);
  // Nobody may not look into our descriptors, but into the table of locks.
  const std::string message = AsNobody([&] { return OpenMessage(ConfigFor(pty.path())); });
  EXPECT_THAT(message, HasSubstr("process " + std::to_string(getpid())));
}

TEST(SerialPort, KilledHolderLeavesAPseudoTerminalUsable) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to become nobody";
  PseudoTerminal pty;
  ASSERT_EQ(chmod(pty.path().c_str(), 0666), 0);
  // Never closed by the program itself: _exit as after a SIGKILL.
  AsNobody([&] {
    auto* leaked = new core::Expected<SerialPort>(SerialPort::Open(ConfigFor(pty.path())));
    return std::string(*leaked ? "held" : "not held");
  });
  EXPECT_EQ(AsNobody([&] { return OpenMessage(ConfigFor(pty.path())); }), "opened");
}

TEST(SerialPort, NoPermissionNamesTheGroup) {
  if (geteuid() != 0) GTEST_SKIP() << "needs root to become nobody";
  PseudoTerminal pty;
  constexpr gid_t kDialout = 20;  // Debian's base-passwd
  ASSERT_EQ(chown(pty.path().c_str(), 0, kDialout), 0);
  ASSERT_EQ(chmod(pty.path().c_str(), 0660), 0);
  const std::string message = AsNobody([&] { return OpenMessage(ConfigFor(pty.path())); });
  EXPECT_THAT(message, HasSubstr(pty.path()));
  EXPECT_THAT(message, HasSubstr("Permission denied"));
  EXPECT_THAT(message, HasSubstr("add the user to group dialout"));
  EXPECT_THAT(message, Not(HasSubstr("\n")));
}

TEST(SerialPort, MissingDeviceIsNotFoundAndListsPorts) {
  const auto port = SerialPort::Open(ConfigFor("/dev/ttyUSB_not_there"));
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(port.error().message, HasSubstr("open /dev/ttyUSB_not_there: no such device"));
  EXPECT_THAT(port.error().message, ::testing::AnyOf(HasSubstr("serial ports here: "),
                                                     HasSubstr("no serial port is plugged in")));
}

TEST(SerialPort, ThingsThatAreNoSerialPortAreNamed) {
  const std::string folder = ::testing::TempDir();
  const std::string file = folder + "/kawara_not_a_port";
  std::ofstream(file) << "x";
  const std::string pipe_path = folder + "/kawara_pipe";
  unlink(pipe_path.c_str());
  ASSERT_EQ(mkfifo(pipe_path.c_str(), 0600), 0);
  const struct {
    std::string path;
    const char* kind;
  } kCases[] = {{file, "a file"},
                {folder, "a directory"},
                {pipe_path, "a pipe"},
                {"/dev/null", "another kind of device"}};
  for (const auto& c : kCases) {
    const auto port = SerialPort::Open(ConfigFor(c.path));
    ASSERT_FALSE(port) << c.path;
    EXPECT_EQ(port.error().code, ErrorCode::kInvalidArgument) << c.path;
    EXPECT_THAT(port.error().message, HasSubstr(std::string("not a serial port but ") + c.kind));
  }
  unlink(file.c_str());
  unlink(pipe_path.c_str());
}

TEST(SerialPort, ImpossibleBaudIsRefusedInOneLine) {
  PseudoTerminal pty;
  SerialConfig config = ConfigFor(pty.path());
  config.baud_bps = 0;
  EXPECT_THAT(OpenMessage(config), HasSubstr("baud rate 0 is impossible"));
}

TEST(SerialPort, StampOnAPseudoTerminalLiesBetweenSendingAndReading) {
  for (const StampRule rule : {StampRule::kAuto, StampRule::kReadTime}) {
    PseudoTerminal pty;
    SerialConfig config = ConfigFor(pty.path());
    config.stamp = rule;
    auto port = SerialPort::Open(config);
    ASSERT_TRUE(port);
    std::array<std::uint8_t, 64> buffer{};
    const MonoTime before = core::MonoNow();
    pty.Send("0123456789");
    ASSERT_TRUE(WaitReadable(port->fd()));
    ASSERT_EQ(port->Read(buffer).value_or(0), 10U);
    EXPECT_GE(port->first_byte_arrival(), before);
    EXPECT_LE(port->first_byte_arrival(), core::MonoNow());
  }
}

TEST(DateFirstByte, FollowsTheWire) {
  const auto at = [](std::int64_t us) { return MonoTime::FromNs(us * 1000); };
  const core::Duration character = Nanoseconds(260'000);  // 38400 baud
  const struct {
    const char* what;
    std::size_t bytes;
    std::int64_t empty_us, woke_us, read_us, expected_us;
  } kCases[] = {
      {"one byte: the read itself", 1, 0, 0, 100'000, 100'000},
      {"30 bytes took 29 character times", 30, 0, 0, 100'000, 100'000 - 29 * 260},
      {"woken before: the first byte was there already", 1, 0, 99'000, 100'000, 99'000},
      {"woken after the wire says: the wire wins", 30, 0, 99'000, 100'000, 100'000 - 29 * 260},
      {"not before the line was seen empty", 30, 95'000, 0, 100'000, 95'000},
      {"no byte at all", 0, 0, 0, 100'000, 100'000},
  };
  for (const auto& c : kCases) {
    const MonoTime woke = c.woke_us == 0 ? MonoTime{} : at(c.woke_us);
    EXPECT_EQ(DateFirstByte(c.bytes, at(c.empty_us), woke, at(c.read_us), character),
              at(c.expected_us))
        << c.what;
  }
}

TEST(DateFirstByte, IsNeverBeforeTheByteWasOnTheWire) {
  // Bytes leave the wire one character apart; a reader wakes whenever it likes and takes all there
  // is.
  const std::int64_t character_ns = 260'000;
  std::uint64_t random = 1;
  const auto next = [&](std::int64_t below) {
    random = random * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<std::int64_t>((random >> 33) % static_cast<std::uint64_t>(below));
  };
  std::vector<std::int64_t> wire;
  std::int64_t t = 1'000'000'000;
  for (int i = 0; i < 20'000; ++i) {
    t += character_ns + (next(30) == 0 ? next(20'000'000) : 0);
    wire.push_back(t);
  }
  MonoTime empty = MonoTime::FromNs(1);
  std::size_t taken = 0;
  std::int64_t now = wire.front();
  std::int64_t worst_late = 0;
  while (taken < wire.size()) {
    now += 1 + next(5'000'000);
    std::size_t n = 0;
    while (taken + n < wire.size() && wire[taken + n] <= now) ++n;
    if (n > 0) {
      const MonoTime stamp =
          DateFirstByte(n, empty, {}, MonoTime::FromNs(now), Nanoseconds(character_ns));
      EXPECT_GE(stamp.ns(), wire[taken]);
      worst_late = std::max(worst_late, stamp.ns() - wire[taken]);
    }
    taken += n;
    empty = MonoTime::FromNs(now);
  }
  EXPECT_LE(worst_late, 5'000'000) << "late by the reader's own sleep at most";
}

}  // namespace
}  // namespace kawara::drivers
