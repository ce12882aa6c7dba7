#include "drivers/v4l2_camera.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <utility>

#include "tests/unit/drivers/scripted_camera.hpp"

namespace kawara::drivers {
namespace {

class V4l2CameraOfScript : public ::testing::Test {
 protected:
  V4l2CameraOfScript() {
    config_.device = "/dev/video0";
    config_.reconnect = core::Milliseconds(500);
    config_.hang = core::Seconds(1);
  }
  V4l2Camera& Camera() {
    if (!camera_) {
      auto system = script_.System();
      if (open_line_) system.open_line = open_line_;
      camera_ = std::make_unique<V4l2Camera>(config_, counters_, std::move(system));
    }
    return *camera_;
  }
  auto Next() { return Camera().Next(core::Milliseconds(200)); }
  std::int64_t Count(const std::string& name) {
    return counters_.Register("camera.v4l2." + name).value();
  }
  void Frames(std::initializer_list<std::uint32_t> sequences) {
    for (const std::uint32_t sequence : sequences) script_.frames.push_back(Numbered(sequence));
  }

  ScriptedCamera script_;
  decltype(V4l2Camera::System::open_line) open_line_;
  V4l2CameraConfig config_;
  core::Counters counters_;
  std::unique_ptr<V4l2Camera> camera_;
};

TEST_F(V4l2CameraOfScript, FramesComeWithoutTheRowsPadding) {
  ScriptedFrame frame;
  frame.sequence = 3;
  frame.age = core::Milliseconds(30);
  frame.bytes = {1, 2, 3, 4, 99, 99, 5, 6, 7, 8, 99, 99};
  script_.frames.push_back(frame);
  const auto got = Next();
  ASSERT_TRUE(got && *got);
  EXPECT_EQ((*got)->sequence, 3U);
  EXPECT_EQ((*got)->format, PixelFormat::kGrey8);
  EXPECT_EQ((*got)->bytes, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ((*got)->arrival - (*got)->exposure_start, core::Milliseconds(30));
  EXPECT_EQ(script_.queued, 4);  // the buffer went back
}

TEST_F(V4l2CameraOfScript, MultiPlanarFramesAreTheSame) {
  script_.capabilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  Frames({1, 2});
  ASSERT_TRUE(Next().value());
  EXPECT_EQ(Next().value()->bytes.size(), 8U);
}

TEST_F(V4l2CameraOfScript, NoFrameYetIsNoError) {
  const auto got = Next();
  ASSERT_TRUE(got);
  EXPECT_EQ(*got, nullptr);
}

TEST_F(V4l2CameraOfScript, GapsAreCountedAlsoAcrossTheWrap) {
  Frames({0xFFFFFFFD, 0xFFFFFFFE, 1, 2});  // 0xFFFFFFFF and 0 are missing
  for (int i = 0; i < 4; ++i) ASSERT_TRUE(Next().value());
  EXPECT_EQ(Count("sequence_gaps"), 2);
  Frames({0, 1});  // a count that begins anew is no gap of four thousand millions
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(Next().value());
  EXPECT_EQ(Count("sequence_gaps"), 2);
}

TEST_F(V4l2CameraOfScript, MarkedAndCutOffFramesAreLeftOut) {
  ScriptedFrame marked, cut;
  marked.sequence = 1;
  marked.flags |= V4L2_BUF_FLAG_ERROR;
  cut.sequence = 2;
  cut.bytes = {1, 2, 3, 4, 5, 6, 7, 8, 9};  // the last row needs one more
  script_.frames = {marked, cut, Numbered(3)};
  EXPECT_EQ(Camera().Next(core::Seconds(1)).value()->sequence, 3U);
  EXPECT_EQ(Count("error_frames"), 1);
  EXPECT_EQ(Count("damaged_frames"), 1);
  EXPECT_EQ(Count("sequence_gaps"), 0);
  EXPECT_EQ(script_.queued, 4);
}

TEST_F(V4l2CameraOfScript, EndOfFrameIsCorrectedByReadOutAndExposure) {
  config_.stamps = {core::Milliseconds(8), core::Milliseconds(20)};
  ScriptedFrame end, start;
  end.age = start.age = core::Milliseconds(5);
  start.flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  script_.frames = {end, start};
  const auto first = Next().value();
  EXPECT_EQ(first->arrival - first->exposure_start, core::Milliseconds(33));
  const auto second = Next().value();
  EXPECT_EQ(second->arrival - second->exposure_start, core::Milliseconds(5));
}

TEST_F(V4l2CameraOfScript, TheCamerasOwnExposureIsTakenWhileItIsManual) {
  script_.controls[V4L2_CID_EXPOSURE_AUTO] = {
      V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 3, 0, {"", "Manual Mode", "", "Aperture"}};
  script_.controls[V4L2_CID_EXPOSURE_ABSOLUTE] = {
      V4L2_CTRL_TYPE_INTEGER, "Exposure Time, Absolute", 1, 5000, 40, 0, {}};
  config_.stamps.exposure = core::Milliseconds(1);
  script_.frames = {Numbered(0), Numbered(1), Numbered(2), Numbered(3)};
  script_.frames[1].age = core::Milliseconds(130);  // frames come every 100 ms
  const auto automatic = Next().value();
  EXPECT_EQ(automatic->arrival - automatic->exposure_start, core::Milliseconds(1));
  EXPECT_EQ(automatic->exposure, core::Milliseconds(1));
  ASSERT_TRUE(Camera().Set({{"exposure_time_absolute", "50"}, {"auto_exposure", "manual mode"}}));
  const auto on_its_way = Next().value();  // began before the control was set
  EXPECT_EQ(on_its_way->arrival - on_its_way->exposure_start, core::Milliseconds(131));
  EXPECT_EQ(on_its_way->exposure, core::Milliseconds(1));
  for (int i = 0; i < 2; ++i) {
    const auto manual = Next().value();
    EXPECT_EQ(manual->arrival - manual->exposure_start, core::Milliseconds(5));
    EXPECT_EQ(manual->exposure, core::Milliseconds(5));
  }
  // The switch first, although it was written last.
  EXPECT_EQ(script_.sets, (std::vector<std::pair<std::string, std::int64_t>>{
                              {"auto_exposure", 1}, {"exposure_time_absolute", 50}}));
}

TEST_F(V4l2CameraOfScript, EveryWayToDieIsClosedAndOpenedAgain) {
  for (const int error : {ENODEV, EIO, EINVAL, EPROTO}) {
    Frames({1});
    ASSERT_TRUE(Next().value()) << error;
    script_.Fail(VIDIOC_DQBUF, error);
    const int opens = script_.opens;
    EXPECT_FALSE(Next()) << error;
    EXPECT_EQ(script_.closes, opens) << "a dead device must be let go of at once";
    EXPECT_EQ(script_.mapped, 0);
    EXPECT_FALSE(Next()) << "not before its time";
    EXPECT_EQ(script_.opens, opens);
    script_.now += config_.reconnect;
    Frames({1});
    ASSERT_TRUE(Next().value()) << error;
  }
  EXPECT_EQ(Count("lost"), 4);
  EXPECT_EQ(Count("opened"), 5);
}

TEST_F(V4l2CameraOfScript, GivingBackThatFailsLosesTheCamera) {
  Frames({1, 2});
  ASSERT_TRUE(Next().value());
  script_.Fail(VIDIOC_QBUF, ENODEV);
  EXPECT_EQ(Next().error().code, core::ErrorCode::kUnavailable);
  EXPECT_EQ(Count("lost"), 1);
}

TEST_F(V4l2CameraOfScript, NothingReadyAfterAllIsNoError) {
  Frames({1});
  ASSERT_TRUE(Next().value());
  script_.Fail(VIDIOC_DQBUF, EAGAIN);
  const auto got = Next();
  ASSERT_TRUE(got);
  EXPECT_EQ(*got, nullptr);
}

TEST_F(V4l2CameraOfScript, EveryStepOfOpeningMayFail) {
  struct {
    unsigned long request;
    int error;
    core::ErrorCode code;
    const char* part;
  } const cases[] = {
      {VIDIOC_QUERYCAP, ENOTTY, core::ErrorCode::kInvalidArgument, "not a capture device"},
      {VIDIOC_QUERYCAP, ENODEV, core::ErrorCode::kUnavailable, "unplugged"},
      {VIDIOC_ENUM_FMT, EIO, core::ErrorCode::kUnavailable, "cable"},
      {VIDIOC_S_FMT, EBUSY, core::ErrorCode::kUnavailable, "another program streams"},
      {VIDIOC_QUERY_EXT_CTRL, ENODEV, core::ErrorCode::kUnavailable, "unplugged"},
      {VIDIOC_REQBUFS, EBUSY, core::ErrorCode::kUnavailable, "another program streams"},
      {VIDIOC_REQBUFS, ENOMEM, core::ErrorCode::kIo, "VIDIOC_REQBUFS"},
      {VIDIOC_QUERYBUF, EINVAL, core::ErrorCode::kInvalidArgument, "VIDIOC_QUERYBUF"},
      {VIDIOC_QBUF, EINVAL, core::ErrorCode::kInvalidArgument, "VIDIOC_QBUF"},
      {VIDIOC_STREAMON, ENOSPC, core::ErrorCode::kUnavailable, "USB bandwidth"},
  };
  for (const auto& one : cases) {
    script_.Fail(one.request, one.error);
    const auto got = Next();
    ASSERT_FALSE(got) << one.part;
    EXPECT_EQ(got.error().code, one.code) << got.error().message;
    EXPECT_NE(got.error().message.find(one.part), std::string::npos) << got.error().message;
    EXPECT_EQ(script_.closes, script_.opens) << one.part;
    EXPECT_EQ(script_.mapped, 0) << one.part;
    script_.now += config_.reconnect;
  }
  Frames({1});
  EXPECT_TRUE(Next().value());
}

TEST_F(V4l2CameraOfScript, TooFewBuffersAreRefused) {
  script_.grants_buffers = 1;
  EXPECT_EQ(Next().error().code, core::ErrorCode::kFull);
}

TEST_F(V4l2CameraOfScript, AnotherFormatThanAskedForIsRefused) {
  config_.mode.format = "MJPG";
  const auto got = Next();
  ASSERT_FALSE(got);
  EXPECT_EQ(
      got.error().message,
      "camera /dev/video0 (Scripted) does not offer MJPG, at least 10 Hz; it offers: GREY 4x2 "
      "at 10 Hz");
}

TEST_F(V4l2CameraOfScript, CameraThatHangsIsRestartedThenOpenedAgain) {
  Frames({1});
  ASSERT_TRUE(Next().value());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(Next().value(), nullptr);
  const auto hung = Next();
  ASSERT_FALSE(hung);
  EXPECT_EQ(hung.error().message,
            "camera /dev/video0: no usable frame for 1.0 s: its stream was restarted");
  EXPECT_EQ(script_.stream_ons, 2);
  EXPECT_EQ(script_.opens, 1);
  EXPECT_EQ(script_.queued, 4);
  for (int i = 0; i < 5; ++i) EXPECT_FALSE(Next()) << "not back before its first frame";
  EXPECT_FALSE(Next());
  EXPECT_EQ(Count("restarts"), 2);
  EXPECT_EQ(script_.closes, 1);
  script_.now += config_.reconnect;
  Frames({1});
  EXPECT_TRUE(Next().value());
  EXPECT_EQ(Count("opened"), 2);
}

TEST_F(V4l2CameraOfScript, RestartCuresAndIsForgotten) {
  Frames({1});
  ASSERT_TRUE(Next().value());
  while (Next()) continue;
  Frames({0});
  ASSERT_TRUE(Next().value());
  for (int i = 0; i < 5; ++i) EXPECT_EQ(Next().value(), nullptr);
  EXPECT_FALSE(Next());
  EXPECT_EQ(script_.opens, 1) << "the next hang begins with the gentle cure again";
}

TEST_F(V4l2CameraOfScript, NothingButDamagedFramesIsAHang) {
  for (std::uint32_t i = 0; i < 20; ++i) {
    ScriptedFrame frame;
    frame.sequence = i;
    frame.flags |= V4L2_BUF_FLAG_ERROR;
    script_.frames.push_back(frame);
  }
  EXPECT_FALSE(Camera().Next(core::Seconds(5)));
  EXPECT_EQ(Count("restarts"), 1);
}

TEST_F(V4l2CameraOfScript, TriggeredCameraHangsOnlyIfTriggered) {
  script_.controls[0x009a2001] = {V4L2_CTRL_TYPE_BUTTON, "Software Trigger", 0, 0, 0, 0, {}};
  config_.trigger_control = "software_trigger";
  Frames({1});
  ASSERT_TRUE(Next().value());
  for (int i = 0; i < 20; ++i) EXPECT_EQ(Next().value(), nullptr);
  ASSERT_TRUE(Camera().Trigger(1));
  while (Next()) continue;
  EXPECT_EQ(Count("restarts"), 1);
  const auto pulled = [this] {
    const std::lock_guard lock(script_.mutex);
    return script_.sets;
  };
  while (pulled().empty()) std::this_thread::yield();
  EXPECT_EQ(pulled().back(), (std::pair<std::string, std::int64_t>{"software_trigger", 1}));
}

TEST_F(V4l2CameraOfScript, TriggerControlThatIsNotThereIsSaid) {
  config_.trigger_control = "software_trigger";
  EXPECT_EQ(Next().error().message,
            "camera /dev/video0 has no control \"software_trigger\": it has no controls at all");
}

/// A wire that counts, and fails as ordered.
class ScriptedLine final : public TriggerLine {
 public:
  struct Log {
    std::atomic<int> opened{0}, pulses{0}, to_fail{0};
  };
  explicit ScriptedLine(Log& log) : log_(log) {}
  core::Expected<void> Set(bool active) override {
    if (log_.to_fail.load() > 0) {
      --log_.to_fail;
      return core::Fail(core::ErrorCode::kUnavailable, "trigger: unplugged");
    }
    if (!active) ++log_.pulses;
    return {};
  }

 private:
  Log& log_;
};

TEST_F(V4l2CameraOfScript, TriggerLineIsPulsedAndOpenedAnewAfterAFailure) {
  ScriptedLine::Log log;
  config_.trigger_line.kind = TriggerLineConfig::Kind::kGpio;
  config_.hang = core::Seconds(1000);
  open_line_ = [&log](const TriggerLineConfig&) -> core::Expected<std::unique_ptr<TriggerLine>> {
    ++log.opened;
    return std::make_unique<ScriptedLine>(log);
  };
  Frames({1});
  ASSERT_TRUE(Next().value());
  ASSERT_TRUE(Camera().Trigger(1));
  while (log.pulses.load() < 1) std::this_thread::yield();
  log.to_fail = 1;
  ASSERT_TRUE(Camera().Trigger(2));
  while (Count("trigger_failures") < 1) std::this_thread::yield();
  std::string said;
  while (said.empty()) {  // the failure is counted a moment before it is told
    const auto next = Next();
    if (!next) said = next.error().message;
  }
  EXPECT_EQ(said, "trigger: unplugged");
  ASSERT_TRUE(Camera().Trigger(3));
  while (log.pulses.load() < 2) std::this_thread::yield();
  while (!Next()) std::this_thread::yield();  // all is well again
  EXPECT_EQ(log.opened, 2);
}

TEST_F(V4l2CameraOfScript, TriggersThatNothingFollowsAreExplained) {
  script_.controls[0x009a2001] = {V4L2_CTRL_TYPE_BUTTON, "Software Trigger", 0, 0, 0, 0, {}};
  config_.trigger_control = "software_trigger";
  EXPECT_EQ(Next().value(), nullptr);
  for (std::uint32_t i = 1; i <= 3; ++i) ASSERT_TRUE(Camera().Trigger(i));
  std::string said;
  while (said.empty()) {
    const auto next = Next();
    if (!next) said = next.error().message;
  }
  EXPECT_NE(said.find("after 3 triggers, and none before"), std::string::npos) << said;
  EXPECT_NE(said.find("active_low"), std::string::npos) << said;
}

TEST_F(V4l2CameraOfScript, TriggerOfAClosedCameraFailsWithoutAWord) {
  const auto triggered = Camera().Trigger(1);
  ASSERT_FALSE(triggered);
  EXPECT_TRUE(triggered.error().message.empty());
  Frames({1});
  ASSERT_TRUE(Next().value());
  EXPECT_TRUE(Camera().Trigger(2));  // runs freely: nothing to do
  EXPECT_TRUE(script_.sets.empty());
}

TEST_F(V4l2CameraOfScript, ComesBackUnderAnotherNumber) {
  Frames({1});
  ASSERT_TRUE(Next().value());
  script_.Fail(VIDIOC_DQBUF, ENODEV);
  EXPECT_FALSE(Next());
  script_.now += config_.reconnect;
  script_.path = "/dev/video4";
  Frames({1});
  EXPECT_TRUE(Next().value());
  EXPECT_NE(Camera().Description().find("/dev/video4: Scripted"), std::string::npos);
}

TEST_F(V4l2CameraOfScript, AnotherCameraInItsPlaceIsNotTaken) {
  Frames({1});
  ASSERT_TRUE(Next().value());
  script_.Fail(VIDIOC_DQBUF, ENODEV);
  EXPECT_FALSE(Next());
  script_.now += config_.reconnect;
  script_.card = "Stranger";
  script_.bus_info = "usb-2";
  const auto got = Next();
  ASSERT_FALSE(got);
  EXPECT_NE(got.error().message.find("Stranger (usb-2) is in its place"), std::string::npos);
  script_.now += config_.reconnect;
  script_.card = "Scripted";  // the same make in another socket
  Frames({1});
  EXPECT_TRUE(Next().value());
}

}  // namespace
}  // namespace kawara::drivers
