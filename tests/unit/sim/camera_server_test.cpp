#include "sim/camera/camera_server.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/camera_socket_client.hpp"
#include "sim/motion/recording.hpp"

namespace kawara::sim {
namespace {

/// Pictures whose bytes are their caption.
class CaptionBytes final : public PictureSource {
 public:
  explicit CaptionBytes(const std::atomic<int>& prepare_ms) : prepare_ms_(prepare_ms) {}
  void Prepare(core::GpsTime /*expected*/) override {
    std::this_thread::sleep_for(std::chrono::milliseconds(prepare_ms_.load()));
  }
  std::uint64_t made_late() const override { return 7; }
  core::Expected<Picture> Expose(const Caption& caption) override {
    return Picture{
        64, 32,
        std::vector<std::uint8_t>(200'000, static_cast<std::uint8_t>(caption.trigger_sequence))};
  }

 private:
  const std::atomic<int>& prepare_ms_;
};

/// The simulated camera in its thread and the driver that onboard programs use.
class CameraPair : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_camera_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    recording_ =
        LoadRecording(std::filesystem::path(KAWARA_SOURCE_DIR) / "data/drive_0708").value();
    clock_.emplace(recording_.begin() + core::Seconds(100), core::MonoNow(), 1.0);
    CameraServer::Hooks hooks;
    hooks.faults = [this](core::MonoTime /*t*/) {
      return CameraServer::Faults{.hang = hang_,
                                  .miss = miss_ ? 1.0 : 0.0,
                                  .doubled = 0.0,
                                  .late = late_,
                                  .dark = dark_,
                                  .disconnected = disconnected_};
    };
    hooks.signal = [this](core::MonoTime /*t*/) { ++pulses_; };
    hooks.exposed = [this](const CameraServer::Exposure& e) {
      const std::lock_guard lock(mutex_);
      exposures_.push_back(e);
    };
    server_ = std::make_unique<CameraServer>(folder_ / "camera.sock", *clock_,
                                             std::make_unique<CaptionBytes>(prepare_ms_),
                                             CameraOptions{}, std::move(hooks));
    ASSERT_TRUE(server_->Listen());
    thread_ = std::thread([this] { server_->Run(stop_); });
    camera_ = std::make_unique<drivers::SocketCamera>((folder_ / "camera.sock").string());
  }
  void TearDown() override {
    stop_ = true;
    thread_.join();
    server_.reset();
    std::filesystem::remove_all(folder_);
  }
  /// Waits long, because a busy machine may; the tests assert no times.
  std::shared_ptr<const drivers::Frame> WaitFrame() {
    return camera_->Next(core::Seconds(20)).value_or(nullptr);
  }
  /// The server looks at its faults once a round: gives it the time to see the new ones.
  static void LetTheServerLook() { std::this_thread::sleep_for(std::chrono::milliseconds(150)); }
  void Connect() { ASSERT_TRUE(camera_->Next(core::Milliseconds(1))); }
  /// The first frame of a trigger sent now; other triggers' frames are skipped.
  std::shared_ptr<const drivers::Frame> Shoot(std::uint32_t sequence) {
    if (!camera_->Trigger(sequence)) return nullptr;
    return WaitFrame();
  }

  std::filesystem::path folder_;
  Recording recording_;
  std::optional<SimClock> clock_;
  std::atomic<bool> hang_{false}, miss_{false}, late_{false}, dark_{false};
  std::atomic<bool> disconnected_{false}, stop_{false};
  std::atomic<int> pulses_{0}, prepare_ms_{0};
  std::mutex mutex_;
  std::vector<CameraServer::Exposure> exposures_;
  std::unique_ptr<CameraServer> server_;
  std::unique_ptr<drivers::SocketCamera> camera_;
  std::thread thread_;
};

TEST_F(CameraPair, EachTriggerGivesTheFrameOfItsOwnExposure) {
  Connect();
  for (std::uint32_t sequence = 1; sequence <= 5; ++sequence) {
    const auto frame = Shoot(sequence);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->trigger_sequence, sequence);
    EXPECT_EQ(frame->sequence, sequence);
    EXPECT_EQ(frame->bytes,
              std::vector<std::uint8_t>(200'000, static_cast<std::uint8_t>(sequence)));
    EXPECT_EQ(frame->width, 64U);
    EXPECT_GT(frame->arrival, frame->exposure_start);
  }
  const std::lock_guard lock(mutex_);
  ASSERT_EQ(exposures_.size(), 5U);
  EXPECT_EQ(exposures_[2].gps, clock_->GpsAt(exposures_[2].mono));
  EXPECT_EQ(pulses_, 5);
}

TEST_F(CameraPair, MissedTriggersLeaveNoGapInTheCamerasOwnCount) {
  Connect();
  ASSERT_TRUE(Shoot(1));
  miss_ = true;
  LetTheServerLook();
  ASSERT_TRUE(camera_->Trigger(2));
  const auto nothing = camera_->Next(core::Milliseconds(200));
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(*nothing);
  miss_ = false;
  LetTheServerLook();
  const auto frame = Shoot(3);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->trigger_sequence, 3U);
  EXPECT_EQ(frame->sequence, 2U);
}

TEST_F(CameraPair, ATriggerThatComesWhileAPictureIsMadeIsNotMissed) {
  Connect();
  prepare_ms_ = 700;  // far longer than a trigger may lie about unread
  // A busy machine may itself be late to a trigger, so there are some tries; each would fail if the
  // picture were to blame.
  const auto shoot = [&](std::uint32_t sequence) {
    const auto frame =
        camera_->Trigger(sequence) ? camera_->Next(core::Seconds(3)).value_or(nullptr) : nullptr;
    return frame && frame->trigger_sequence == sequence;
  };
  bool taken = false;
  for (std::uint32_t sequence = 1; sequence < 20 && !taken; sequence += 2) {
    if (!shoot(sequence)) continue;
    LetTheServerLook();  // it begins to prepare
    taken = shoot(sequence + 1);
  }
  EXPECT_TRUE(taken);
  prepare_ms_ = 0;
  stop_ = true;
  thread_.join();
  EXPECT_EQ(server_->counters().made_late, 7U);
  thread_ = std::thread([] {});
}

TEST_F(CameraPair, LateFramesComeWithTheNextTriggerAndKeepTheirNumber) {
  Connect();
  late_ = true;
  LetTheServerLook();
  ASSERT_TRUE(camera_->Trigger(1));
  EXPECT_FALSE(*camera_->Next(core::Milliseconds(200)));
  late_ = false;
  LetTheServerLook();
  const auto first = Shoot(2);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->trigger_sequence, 1U);
  const auto second = WaitFrame();
  ASSERT_TRUE(second);
  EXPECT_EQ(second->trigger_sequence, 2U);
}

TEST_F(CameraPair, HangGivesNothingAndStaleTriggersMakeNoPicturesAfterwards) {
  Connect();
  hang_ = true;
  LetTheServerLook();
  ASSERT_TRUE(camera_->Trigger(1));
  EXPECT_FALSE(*camera_->Next(core::Milliseconds(300)));
  hang_ = false;
  const auto nothing = camera_->Next(core::Milliseconds(200));
  ASSERT_TRUE(nothing);
  EXPECT_FALSE(*nothing);
  const auto frame = Shoot(2);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->trigger_sequence, 2U);
}

TEST_F(CameraPair, DarkFramesAreFramesInTimeButNotThePicture) {
  Connect();
  dark_ = true;
  LetTheServerLook();
  const auto dark = Shoot(1);
  ASSERT_TRUE(dark);
  EXPECT_EQ(dark->trigger_sequence, 1U);
  EXPECT_EQ(dark->width, 64U);
  EXPECT_NE(dark->bytes, std::vector<std::uint8_t>(200'000, 1));
  dark_ = false;
  LetTheServerLook();
  const auto light = Shoot(2);
  ASSERT_TRUE(light);
  EXPECT_EQ(light->bytes, std::vector<std::uint8_t>(200'000, 2));
}

TEST_F(CameraPair, DisconnectIsToldAndMendsItself) {
  Connect();
  ASSERT_TRUE(Shoot(1));
  disconnected_ = true;
  EXPECT_EQ(camera_->Next(core::Seconds(20)).error().code, core::ErrorCode::kUnavailable);
  EXPECT_FALSE(camera_->Trigger(2));
  EXPECT_EQ(camera_->lost_triggers(), 1U);
  EXPECT_FALSE(camera_->Next(core::Milliseconds(1))) << "nobody listens";
  disconnected_ = false;
  LetTheServerLook();
  bool back = false;
  for (int i = 0; i < 1000 && !back; ++i) {
    back = camera_->Next(core::Milliseconds(10)).has_value();
    if (!back) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ASSERT_TRUE(back);
  EXPECT_TRUE(Shoot(3));
  EXPECT_GE(camera_->stats().connects, 2U)
      << "a try that meets the server on its way out does not count against it";
}

TEST_F(CameraPair, SecondUserIsTurnedAwayTheFirstOneStays) {
  Connect();
  ASSERT_TRUE(Shoot(1));
  drivers::SocketCamera other((folder_ / "camera.sock").string());
  EXPECT_FALSE(other.Next(core::Seconds(20)));
  EXPECT_TRUE(Shoot(2));
}

}  // namespace
}  // namespace kawara::sim
