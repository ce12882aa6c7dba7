#include "drivers/pps_socket_client.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

namespace kawara::drivers {
namespace {

using Record = std::array<std::uint8_t, sizeof(PpsEdgeMessage)>;

Record RecordOf(const PpsEdgeMessage& message) {
  Record record{};
  std::memcpy(record.data(), &message, sizeof message);
  return record;
}

const core::MonoTime kNow = core::MonoTime::FromNs(5'000'000'000);

TEST(ParsePpsEdge, TakesWhatASourceCanHaveStamped) {
  const auto edge = ParsePpsEdge(RecordOf({kPpsEdgeMagic, 7, 4'999'999'000}), kNow);
  ASSERT_TRUE(edge) << edge.error().message;
  EXPECT_EQ(edge->sequence, 7U);
  EXPECT_EQ(edge->mono.ns(), 4'999'999'000);
}

TEST(ParsePpsEdge, RefusesWhatNoneCan) {
  const PpsEdgeMessage cases[] = {
      {0, 1, 4'000'000'000},         {kPpsEdgeMagic, 1, 0},
      {kPpsEdgeMagic, 1, -1},        {kPpsEdgeMagic, 1, INT64_MIN},
      {kPpsEdgeMagic, 1, INT64_MAX}, {kPpsEdgeMagic, 1, (kNow + kPpsFuture).ns() + 1},
  };
  for (const PpsEdgeMessage& message : cases) {
    const auto edge = ParsePpsEdge(RecordOf(message), kNow);
    ASSERT_FALSE(edge) << message.mono_ns;
    EXPECT_EQ(edge.error().code, core::ErrorCode::kFormat);
  }
}

TEST(PpsEdgeAssembler, GivesTheSameForAnySplitOfTheBytes) {
  std::vector<std::uint8_t> stream;
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const Record record = RecordOf({kPpsEdgeMagic, i, 1000 + i});
    stream.insert(stream.end(), record.begin(), record.end());
  }
  for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
    PpsEdgeAssembler assembler;
    std::vector<std::uint32_t> got;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      std::span<const std::uint8_t> rest(stream.data() + at, std::min(piece, stream.size() - at));
      while (!rest.empty()) {
        const auto edge = assembler.Feed(kNow, rest);
        ASSERT_TRUE(edge);
        if (*edge) got.push_back((*edge)->sequence);
      }
    }
    EXPECT_EQ(got, (std::vector<std::uint32_t>{1, 2, 3, 4, 5})) << "pieces of " << piece;
  }
}

/// Who stamps the pulses.
class PulseSocket : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_pps_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  void TearDown() override {
    Close();
    std::filesystem::remove_all(folder_);
  }
  std::string path() const { return (folder_ / "pps.sock").string(); }
  void Listen() {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strcpy(address.sun_path, path().c_str());
    listen_fd_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    ASSERT_EQ(bind(listen_fd_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(listen(listen_fd_, 1), 0);
  }
  void Accept() { fd_ = accept(listen_fd_, nullptr, nullptr); }
  void Close() {
    for (int* fd : {&fd_, &listen_fd_}) {
      if (*fd >= 0) close(*fd);
      *fd = -1;
    }
    std::filesystem::remove(path());
  }
  void Send(const Record& record) const {
    ASSERT_EQ(write(fd_, record.data(), record.size()), static_cast<ssize_t>(record.size()));
  }
  void SendEdge(std::uint32_t sequence, core::Duration ago = {}) const {
    Send(RecordOf({kPpsEdgeMagic, sequence, (core::MonoNow() - ago).ns()}));
  }

  std::filesystem::path folder_;
  int listen_fd_ = -1, fd_ = -1;
};

TEST_F(PulseSocket, ComesBackWhenTheOtherSideDoes) {
  SocketPps pps(path());
  const auto absent = pps.Next(core::Milliseconds(1));
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().code, core::ErrorCode::kUnavailable);
  for (std::uint32_t round = 1; round <= 2; ++round) {
    Listen();
    const auto nothing = pps.Next(core::Milliseconds(1));
    ASSERT_TRUE(nothing) << nothing.error().message;
    EXPECT_FALSE(nothing->has_value());
    Accept();
    SendEdge(round);
    const auto edge = pps.Next(core::Seconds(20));
    ASSERT_TRUE(edge && *edge);
    EXPECT_EQ((*edge)->sequence, round);
    Close();
    EXPECT_FALSE(pps.Next(core::Seconds(20)));
  }
  EXPECT_EQ(pps.stats().connects, 2U);
  EXPECT_EQ(pps.stats().disconnects, 2U);
}

TEST_F(PulseSocket, EdgesThatWaitedTooLongArePassedOver) {
  Listen();
  SocketPps pps(path());
  ASSERT_TRUE(pps.Next(core::Milliseconds(1)));
  Accept();
  SendEdge(1, SocketPps::kStale + core::Milliseconds(1));
  SendEdge(2);
  const auto edge = pps.Next(core::Seconds(20));
  ASSERT_TRUE(edge && *edge);
  EXPECT_EQ((*edge)->sequence, 2U);
  EXPECT_EQ(pps.stats().stale, 1U);
}

TEST_F(PulseSocket, AnotherProtocolIsSaidAndLeft) {
  Listen();
  SocketPps pps(path());
  ASSERT_TRUE(pps.Next(core::Milliseconds(1)));
  Accept();
  Send(Record{'G', 'E', 'T', ' '});
  const auto edge = pps.Next(core::Seconds(20));
  ASSERT_FALSE(edge);
  EXPECT_EQ(edge.error().code, core::ErrorCode::kFormat);
  EXPECT_EQ(pps.stats().format_errors, 1U);
}

TEST(SocketPps, APathThatFitsNoSocketIsSaid) {
  for (const std::string& path : {std::string(), std::string(200, 'x')}) {
    const auto edge = SocketPps(path).Next({});
    ASSERT_FALSE(edge);
    EXPECT_EQ(edge.error().code, core::ErrorCode::kInvalidArgument);
  }
}

}  // namespace
}  // namespace kawara::drivers
