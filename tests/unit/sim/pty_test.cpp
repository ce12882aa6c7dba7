#include "sim/ports/pty.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <fstream>
#include <string>
#include <vector>

namespace kawara::sim {
namespace {

class PtyTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_pty_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path Link() const { return folder_ / "gps"; }

  static int OpenHost(const std::filesystem::path& link, speed_t speed) {
    const int fd = open(link.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios settings{};
    tcgetattr(fd, &settings);
    cfmakeraw(&settings);
    cfsetspeed(&settings, speed);
    tcsetattr(fd, TCSANOW, &settings);
    return fd;
  }
  static std::vector<std::uint8_t> Bytes(const std::string& text) {
    return {text.begin(), text.end()};
  }

  std::filesystem::path folder_;
};

TEST_F(PtyTest, BytesGoBothWaysUnchanged) {
  auto pty = Pty::Create(Link());
  ASSERT_TRUE(pty) << pty.error().message;
  const int host = OpenHost(Link(), B115200);
  const std::vector<std::uint8_t> odd{0x00, 0xFF, 0x0A, 0x0D, 0x03, 0x11, 0x13, 0x7F, 0x1A};
  EXPECT_EQ(pty->Write(odd), odd.size());
  std::array<std::uint8_t, 64> buffer{};
  ASSERT_EQ(read(host, buffer.data(), buffer.size()), static_cast<ssize_t>(odd.size()));
  EXPECT_EQ(std::vector<std::uint8_t>(buffer.begin(), buffer.begin() + 9), odd);
  ASSERT_EQ(write(host, odd.data(), odd.size()), static_cast<ssize_t>(odd.size()));
  ASSERT_EQ(pty->Read(buffer), odd.size());
  EXPECT_EQ(std::vector<std::uint8_t>(buffer.begin(), buffer.begin() + 9), odd);
  close(host);
}

TEST_F(PtyTest, HostsRateAndPresenceAreSeen) {
  auto pty = Pty::Create(Link());
  ASSERT_TRUE(pty);
  EXPECT_FALSE(pty->host().open);
  EXPECT_EQ(pty->host().baud_bps, 9600);
  const int host = OpenHost(Link(), B57600);
  EXPECT_TRUE(pty->host().open);
  EXPECT_EQ(pty->host().baud_bps, 57600);
  close(host);
  EXPECT_FALSE(pty->host().open);
}

TEST_F(PtyTest, UnplugHangsUpAndReplugGivesAnotherNumberBehindTheSameLink) {
  auto pty = Pty::Create(Link());
  ASSERT_TRUE(pty);
  const std::string first = pty->device();
  int host = OpenHost(Link(), B9600);
  pty->Unplug();
  EXPECT_FALSE(std::filesystem::exists(std::filesystem::symlink_status(Link())));
  std::uint8_t byte = 0;
  EXPECT_EQ(read(host, &byte, 1), 0);  // end of file
  EXPECT_LT(write(host, &byte, 1), 0);
  close(host);  // even a host that lets go at once does not get the old number back
  ASSERT_TRUE(pty->Replug());
  EXPECT_NE(pty->device(), first);
  EXPECT_EQ(std::filesystem::read_symlink(Link()).string(), pty->device());
  host = OpenHost(Link(), B9600);
  EXPECT_EQ(pty->Write(Bytes("again")), 5U);
  std::array<char, 8> buffer{};
  EXPECT_EQ(read(host, buffer.data(), buffer.size()), 5);
  close(host);
}

TEST_F(PtyTest, NobodyReadingEndsInRefusedBytesNotInBlocking) {
  auto pty = Pty::Create(Link());
  ASSERT_TRUE(pty);
  const int host = OpenHost(Link(), B9600);
  const std::vector<std::uint8_t> block(4096, 'x');
  std::size_t taken = 0;
  for (int i = 0; i < 64; ++i) taken += pty->Write(block);
  EXPECT_GT(taken, 0U);
  EXPECT_LT(taken, 64 * block.size());
  close(host);
}

TEST_F(PtyTest, StaleLinkIsReplacedButNothingElse) {
  std::filesystem::create_symlink("/dev/pts/999999", Link());
  EXPECT_TRUE(Pty::Create(Link()));
  std::ofstream(folder_ / "file") << "precious";
  const auto refused = Pty::Create(folder_ / "file");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, core::ErrorCode::kInvalidArgument);
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "file"));
}

}  // namespace
}  // namespace kawara::sim
