#include "sim/instruments/serial_line.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace kawara::sim {
namespace {

/// Says one byte after the other, 1 to 200 and again, without end.
class Counting final : public SerialInstrument {
 public:
  UartTransmitter& transmitter() override { return transmitter_; }
  void Receive(core::MonoTime, std::span<const std::uint8_t>) override {}
  void Advance(core::MonoTime now) override {
    while (transmitter_.FreeAt(now) <= now) {
      value_ = static_cast<std::uint8_t>(value_ % 200 + 1);
      transmitter_.Send(now, {&value_, 1});
    }
  }
  core::MonoTime NextEvent() const override { return {}; }

 private:
  UartTransmitter transmitter_{38400};
  std::uint8_t value_ = 0;
};

class SerialLineTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_line_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    auto pty = Pty::Create(folder_ / "port");
    ASSERT_TRUE(pty) << pty.error().message;
    line_.emplace(std::move(*pty), instrument_, 5);
    host_ = open((folder_ / "port").c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios settings{};
    tcgetattr(host_, &settings);
    cfmakeraw(&settings);
    cfsetspeed(&settings, B38400);
    tcsetattr(host_, TCSANOW, &settings);
  }
  void TearDown() override {
    close(host_);
    line_.reset();
    std::filesystem::remove_all(folder_);
  }
  /// What the host hears in 0.2 s.
  std::vector<std::uint8_t> Hear(const SerialLine::Faults& faults) {
    std::vector<std::uint8_t> heard;
    for (int ms = 0; ms < 200; ++ms, now_ += core::Milliseconds(1)) {
      EXPECT_TRUE(line_->Service(now_, faults));
      std::array<std::uint8_t, 64> buffer{};
      for (ssize_t n = 0; (n = read(host_, buffer.data(), buffer.size())) > 0;)
        heard.insert(heard.end(), buffer.begin(), buffer.begin() + n);
    }
    return heard;
  }

  std::filesystem::path folder_;
  Counting instrument_;
  std::optional<SerialLine> line_;
  int host_ = -1;
  core::MonoTime now_ = core::MonoTime::FromNs(900'000'000'000);
};

bool Counts(const std::vector<std::uint8_t>& bytes) {
  for (std::size_t i = 1; i < bytes.size(); ++i) {
    if (bytes[i] != bytes[i - 1] % 200 + 1) return false;
  }
  return bytes.size() > 100;
}

TEST_F(SerialLineTest, StuckRepeatsTheLastGoodByteAtTheSamePace) {
  const auto before = Hear({});
  const auto stuck = Hear({.stuck = true});
  const auto after = Hear({});
  EXPECT_TRUE(Counts(before));
  EXPECT_TRUE(Counts(after));
  EXPECT_EQ(std::set<std::uint8_t>(stuck.begin(), stuck.end()),
            std::set<std::uint8_t>{before.back()});
  EXPECT_NEAR(static_cast<double>(stuck.size()), static_cast<double>(before.size()), 5.0);
}

TEST_F(SerialLineTest, SilentGivesNothingGarbageTheRightAmount) {
  const auto good = Hear({});
  EXPECT_TRUE(Hear({.silent = true}).empty());
  const auto garbage = Hear({.garbage = true});
  EXPECT_FALSE(Counts(garbage));
  EXPECT_NEAR(static_cast<double>(garbage.size()), static_cast<double>(good.size()), 5.0);
  EXPECT_GT(line_->counters().unheard_bytes, 100U);
}

}  // namespace
}  // namespace kawara::sim
