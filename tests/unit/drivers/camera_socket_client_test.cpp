#include "drivers/camera_socket_client.hpp"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>

namespace kawara::drivers {
namespace {

CameraFrameHeader GoodHeader(std::uint32_t payload_bytes = 100) {
  CameraFrameHeader header;
  header.sequence = 7;
  header.trigger_sequence = 9;
  header.exposure_start_mono_ns = 123'456'789;
  header.width = 640;
  header.height = 480;
  header.payload_bytes = payload_bytes;
  return header;
}
std::array<std::uint8_t, sizeof(CameraFrameHeader)> BytesOf(const CameraFrameHeader& header) {
  std::array<std::uint8_t, sizeof(CameraFrameHeader)> bytes{};
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}
std::vector<std::uint8_t> FrameBytes(const CameraFrameHeader& header) {
  const auto head = BytesOf(header);
  std::vector<std::uint8_t> bytes(head.begin(), head.end());
  for (std::uint32_t i = 0; i < header.payload_bytes; ++i)
    bytes.push_back(static_cast<std::uint8_t>(i * 31));
  return bytes;
}

TEST(CameraFrameHeaderParsing, TakesGoodOnesRefusesTheRest) {
  EXPECT_TRUE(ParseCameraFrameHeader(BytesOf(GoodHeader())));
  const std::pair<const char*, std::function<void(CameraFrameHeader&)>> spoilers[] = {
      {"magic", [](auto& h) { h.magic ^= 1; }},
      {"format 0", [](auto& h) { h.format = 0; }},
      {"format 4", [](auto& h) { h.format = 4; }},
      {"no width", [](auto& h) { h.width = 0; }},
      {"no height", [](auto& h) { h.height = 0; }},
      {"wide", [](auto& h) { h.width = kCameraMaxSidePx + 1; }},
      {"high", [](auto& h) { h.height = 0xFFFFFFFFU; }},
      {"empty", [](auto& h) { h.payload_bytes = 0; }},
      {"huge", [](auto& h) { h.payload_bytes = kCameraMaxPayloadBytes + 1; }},
      {"rgb of wrong size", [](auto& h) { h.format = 2; }},
      {"grey of wrong size", [](auto& h) { h.format = 3; }},
  };
  for (const auto& [name, spoil] : spoilers) {
    CameraFrameHeader header = GoodHeader();
    spoil(header);
    const auto parsed = ParseCameraFrameHeader(BytesOf(header));
    ASSERT_FALSE(parsed) << name;
    EXPECT_EQ(parsed.error().code, core::ErrorCode::kFormat);
  }
  CameraFrameHeader raw = GoodHeader(640 * 480 * 3);
  raw.format = 2;
  EXPECT_TRUE(ParseCameraFrameHeader(BytesOf(raw)));
}

TEST(CameraFrameAssembly, AnySplitGivesTheSameFrames) {
  std::vector<std::uint8_t> stream;
  for (const std::uint32_t size : {100U, 1U, 70'000U}) {
    const auto frame = FrameBytes(GoodHeader(size));
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  for (const std::size_t piece :
       {std::size_t{1}, std::size_t{7}, std::size_t{41}, std::size_t{4096}, stream.size()}) {
    CameraFrameAssembler assembler;
    std::vector<std::shared_ptr<const Frame>> frames;
    for (std::size_t at = 0; at < stream.size(); at += piece) {
      std::span<const std::uint8_t> rest =
          std::span(stream).subspan(at, std::min(piece, stream.size() - at));
      while (!rest.empty()) {
        const auto frame = assembler.Feed(core::MonoTime::FromNs(5), rest);
        ASSERT_TRUE(frame);
        if (*frame) frames.push_back(*frame);
      }
    }
    ASSERT_EQ(frames.size(), 3U) << "pieces of " << piece;
    EXPECT_EQ(frames[0]->sequence, 7U);
    EXPECT_EQ(frames[0]->trigger_sequence, 9U);
    EXPECT_EQ(frames[0]->exposure_start.ns(), 123'456'789);
    EXPECT_EQ(frames[0]->arrival.ns(), 5);
    ASSERT_EQ(frames[2]->bytes.size(), 70'000U);
    EXPECT_EQ(frames[2]->bytes[69'999], static_cast<std::uint8_t>(69'999U * 31));
  }
}

TEST(CameraFrameAssembly, ClaimedSizeAloneTakesNoMemory) {
  const auto head = BytesOf(GoodHeader(kCameraMaxPayloadBytes));
  CameraFrameAssembler assembler;
  std::span<const std::uint8_t> rest(head);
  const auto frame = assembler.Feed({}, rest);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(*frame);
}

/// A camera that says exactly what the test wants.
class Listener {
 public:
  Listener() {
    std::string name = testing::TempDir() + "kawara_cam_XXXXXX";
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    path = name + "/sock";
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    listen_ = socket(AF_UNIX, SOCK_STREAM, 0);
    EXPECT_EQ(bind(listen_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(listen(listen_, 2), 0);
  }
  ~Listener() {
    Close();
    close(listen_);
    std::filesystem::remove_all(folder_);
  }
  void Accept() { client_ = accept(listen_, nullptr, nullptr); }
  void Send(const std::vector<std::uint8_t>& bytes) {
    EXPECT_EQ(send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(bytes.size()));
  }
  CameraTriggerMessage Receive() {
    CameraTriggerMessage message;
    EXPECT_EQ(recv(client_, &message, sizeof message, MSG_WAITALL),
              static_cast<ssize_t>(sizeof message));
    return message;
  }
  void Close() {
    if (client_ >= 0) close(client_);
    client_ = -1;
  }
  std::string path;

 private:
  std::filesystem::path folder_;
  int listen_ = -1;
  int client_ = -1;
};

TEST(SocketCamera, NobodyThereIsUnavailableWithPathAndHint) {
  SocketCamera camera("/tmp/kawara-no-such-socket");
  EXPECT_EQ(camera.Trigger(1).error().code, core::ErrorCode::kUnavailable);
  const auto frame = camera.Next(core::Milliseconds(1));
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().code, core::ErrorCode::kUnavailable);
  EXPECT_NE(frame.error().message.find("/tmp/kawara-no-such-socket"), std::string::npos);
}

TEST(SocketCamera, PathLongerThanASocketsIsRefused) {
  SocketCamera camera(std::string(200, 'x'));
  EXPECT_EQ(camera.Next({}).error().code, core::ErrorCode::kInvalidArgument);
}

TEST(SocketCamera, TriggerCarriesSequenceAndTime) {
  Listener listener;
  SocketCamera camera(listener.path);
  ASSERT_TRUE(camera.Next({}));
  listener.Accept();
  const std::int64_t before = core::MonoNow().ns();
  ASSERT_TRUE(camera.Trigger(42));
  const CameraTriggerMessage message = listener.Receive();
  EXPECT_EQ(message.magic, kCameraTriggerMagic);
  EXPECT_EQ(message.sequence, 42U);
  EXPECT_GE(message.mono_ns, before);
  EXPECT_LE(message.mono_ns, core::MonoNow().ns());
}

TEST(SocketCamera, FrameInTwoPartsAcrossTimeouts) {
  Listener listener;
  SocketCamera camera(listener.path);
  ASSERT_TRUE(camera.Next({}));
  listener.Accept();
  const auto bytes = FrameBytes(GoodHeader(1000));
  listener.Send({bytes.begin(), bytes.begin() + 500});
  const auto nothing = camera.Next(core::Milliseconds(20));
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(*nothing);
  listener.Send({bytes.begin() + 500, bytes.end()});
  const auto frame = camera.Next(core::Seconds(20));
  ASSERT_TRUE(frame);
  ASSERT_TRUE(*frame);
  EXPECT_EQ((*frame)->bytes.size(), 1000U);
}

TEST(SocketCamera, GarbageEndsTheConnectionAndTheNextOneWorks) {
  Listener listener;
  SocketCamera camera(listener.path);
  ASSERT_TRUE(camera.Next({}));
  listener.Accept();
  listener.Send(std::vector<std::uint8_t>(100, 0xAA));
  EXPECT_EQ(camera.Next(core::Seconds(20)).error().code, core::ErrorCode::kFormat);
  EXPECT_FALSE(camera.connected());
  EXPECT_EQ(camera.stats().format_errors, 1U);
  listener.Close();
  ASSERT_TRUE(camera.Next({}));
  listener.Accept();
  listener.Send(FrameBytes(GoodHeader()));
  const auto frame = camera.Next(core::Seconds(20));
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->sequence, 7U);
}

TEST(SocketCamera, FrameThatStopsHalfWayIsALoss) {
  Listener listener;
  SocketCamera camera(listener.path, core::Milliseconds(50));
  ASSERT_TRUE(camera.Next({}));
  listener.Accept();
  const auto bytes = FrameBytes(GoodHeader(1000));
  listener.Send({bytes.begin(), bytes.begin() + 500});
  core::Expected<std::shared_ptr<const Frame>> result;
  for (int i = 0; i < 1000 && result; ++i) result = camera.Next(core::Milliseconds(20));
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, core::ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace kawara::drivers
