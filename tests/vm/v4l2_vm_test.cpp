// The V4L2 driver on a real kernel: streams, stamps, faults and unplugging of the kernel's test
// camera (vivid). Runs in the virtual machine of tests/vm/machine.sh, as root, and nowhere else.
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <numeric>

#include "tests/vm/vivid.hpp"

namespace kawara::drivers {
namespace {

/// Mean of the picture's middle, R, G, B (grey: three times the same).
std::array<double, 3> MiddleOf(const Frame& frame) {
  const std::size_t channels = frame.format == PixelFormat::kGrey8 ? 1 : 3;
  std::array<double, 3> sum{};
  int count = 0;
  for (std::size_t y = frame.height / 2 - 8; y < frame.height / 2 + 8; ++y) {
    for (std::size_t x = frame.width / 2 - 8; x < frame.width / 2 + 8; ++x, ++count) {
      const std::uint8_t* const pixel = &frame.bytes[(y * frame.width + x) * channels];
      for (std::size_t c = 0; c < 3; ++c) sum[c] += pixel[channels == 1 ? 0 : c];
    }
  }
  for (double& value : sum) value /= count;
  return sum;
}

/// Menu entries of vivid's test_pattern, and what they are in RGB. As GREY it writes their BT.709
/// luma, 0..255.
struct Pattern {
  const char* name;
  std::array<double, 3> rgb;
};
constexpr std::array<Pattern, 4> kPatterns{{{"100% Red", {255, 0, 0}},
                                            {"100% Green", {0, 255, 0}},
                                            {"100% Blue", {0, 0, 255}},
                                            {"100% White", {255, 255, 255}}}};

TEST(V4l2OnKernel, EveryFormatComesInItsTrueColours) {
  Order("osd_text_mode", "None");
  for (const char* const format : {"YUYV", "NV12", "RGGB", "BGGR", "GBRG", "GRBG", "GREY"}) {
    V4l2CameraConfig config = SmallConfig(format);
    config.mode.rate_hz = 30.0;
    Watched watched(config);
    for (const Pattern& pattern : kPatterns) {
      Order("test_pattern", pattern.name);
      watched.Frames(8);  // those made before are in the queue
      const auto frame = watched.Next();
      ASSERT_NE(frame, nullptr) << format;
      EXPECT_EQ(frame->width, 320U);
      EXPECT_EQ(frame->height, 180U);
      const auto middle = MiddleOf(*frame);
      if (frame->format == PixelFormat::kGrey8) {
        EXPECT_STREQ(format, "GREY");
        EXPECT_EQ(frame->bytes.size(), 320U * 180U);
        const auto& [r, g, b] = pattern.rgb;
        EXPECT_NEAR(middle[0], 0.2126 * r + 0.7152 * g + 0.0722 * b, 6.0) << pattern.name;
        continue;
      }
      EXPECT_EQ(frame->bytes.size(), 3U * 320U * 180U);
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_NEAR(middle[c], pattern.rgb[c], 6.0) << format << " " << pattern.name << " " << c;
      }
    }
    EXPECT_EQ(watched.Count("damaged_frames"), 0) << format;
  }
  Order("test_pattern", "0");
}

TEST(V4l2OnKernel, ChoosesTheLargestThatIsFastEnough) {
  V4l2CameraConfig config = SmallConfig();
  config.mode = {0, 0, 10.0, ""};
  Watched watched(config);
  const auto frame = watched.Next();
  ASSERT_NE(frame, nullptr);
  // Of vivid's sizes 1280x720 is the largest with 10 Hz, and NV12 stands before the others.
  EXPECT_EQ(watched.camera().session()->format().fourcc, std::uint32_t{V4L2_PIX_FMT_NV12});
  EXPECT_EQ(frame->width, 1280U);
  EXPECT_EQ(frame->height, 720U);
  EXPECT_NEAR(watched.camera().session()->interval().rate_hz(), 10.0, 0.01);
  EXPECT_GE(watched.camera().session()->stream().buffers(), 4U);
}

TEST(V4l2OnKernel, MultiPlanarDeviceStreams) {
  V4l2CameraConfig config = SmallConfig("NV12");
  config.device = kVividPlanes;
  Watched watched(config);
  EXPECT_EQ(watched.Frames(5), 5);
  EXPECT_TRUE(watched.camera().session()->device().multiplanar());
}

TEST(V4l2OnKernel, WhatIsNotOfferedIsToldWithWhatIs) {
  V4l2CameraConfig config = SmallConfig();
  config.mode = {1000, 1000, 10.0, "MJPG"};
  const core::Error error = Watched(config).Trouble();
  EXPECT_EQ(error.code, core::ErrorCode::kInvalidArgument);
  for (const char* const part : {"MJPG, 1000x1000", "YUYV 320x180 at 60", "GREY"}) {
    EXPECT_NE(error.message.find(part), std::string::npos) << error.message;
  }
  config.device = kVividOutput;
  EXPECT_NE(Watched(config).Trouble().message.find("it is an output"), std::string::npos);
}

TEST(V4l2OnKernel, StampsAreTakenForWhatTheyAre) {
  struct {
    const char* source;
    core::Duration before_arrival;  ///< at least: what is taken off an end of frame
  } const cases[] = {{"Start of Exposure", core::Duration(0)},
                     {"End of Frame", core::Milliseconds(30)}};
  for (const auto& one : cases) {
    Order("timestamp_source", one.source);
    V4l2CameraConfig config = SmallConfig();
    config.stamps = {core::Milliseconds(10), core::Milliseconds(20)};
    Watched watched(config);
    std::vector<double> intervals_s;
    core::MonoTime last, begin, end;
    for (int i = 0; i < 20; ++i) {
      const auto frame = watched.Next();
      ASSERT_NE(frame, nullptr);
      EXPECT_GE(frame->arrival - frame->exposure_start, one.before_arrival - core::Milliseconds(2))
          << one.source;
      EXPECT_LE(frame->arrival - frame->exposure_start, core::Seconds(5)) << one.source;
      if (i == 0) begin = frame->exposure_start;
      end = frame->exposure_start;
      if (i > 0) intervals_s.push_back(core::ToSeconds(frame->exposure_start - last));
      last = frame->exposure_start;
    }
    std::sort(intervals_s.begin(), intervals_s.end());
    EXPECT_NEAR(intervals_s[intervals_s.size() / 2], 0.1, 0.04) << one.source;
    EXPECT_GT(end - begin, core::Seconds(1)) << one.source;
    // vivid dates the end of a frame before it has gone by: such stamps are shifted to arrivals.
    // The start of exposure is of the monotonic clock and believed.
    if (std::string(one.source) == "Start of Exposure") {
      EXPECT_EQ(watched.Count("foreign_stamps"), 0);
    }
  }
  Order("timestamp_source", "End of Frame");
}

TEST(V4l2OnKernel, WrapOfTheSequenceIsNoGap) {
  Order("wrap_sequence_number", "1");  // begins 128 before the end of 32 bits
  V4l2CameraConfig config = SmallConfig();
  config.mode.rate_hz = 30.0;
  Watched watched(config);
  std::uint32_t first = 0, last = 0;
  int frames = 0;
  do {
    const auto frame = watched.Next();
    ASSERT_NE(frame, nullptr);
    if (frames++ == 0) first = frame->sequence;
    last = frame->sequence;
  } while (last > 1000U && frames < 1000);
  EXPECT_GT(first, 0xFFFFFF00U);
  EXPECT_LT(last, 1000U);
  EXPECT_EQ(last - first, static_cast<std::uint32_t>(frames - 1 + watched.Count("sequence_gaps")));
  Order("wrap_sequence_number", "0");
}

TEST(V4l2OnKernel, WrapOfTheStampHurtsNothing) {
  Order("wrap_timestamp", "64 Bit");  // some seconds before the end of 63 bits of nanoseconds
  V4l2Finder finder(kVivid, OpenV4l2Node);
  auto session = V4l2Session::Open(finder, SmallConfig());
  ASSERT_TRUE(session) << session.error().message;
  V4l2StampClock clock;
  bool wrapped = false;
  std::int64_t last_stamp_s = 0;
  core::MonoTime last;
  for (int after = 0; after < 20;) {
    V4l2Loan loan;
    const auto got = (*session)->stream().Take(kLong, loan);
    ASSERT_TRUE(got && *got == V4l2Stream::Got::kFrame);
    const auto stamp = clock.Take(loan.stamp_s, loan.stamp_us, loan.flags, loan.arrival, {});
    EXPECT_TRUE(stamp.foreign);
    EXPECT_LE(stamp.exposure_start, loan.arrival);
    EXPECT_LE(loan.arrival - stamp.exposure_start, core::Seconds(2));
    EXPECT_GT(stamp.exposure_start, last);
    last = stamp.exposure_start;
    wrapped = wrapped || (last_stamp_s > 0 && loan.stamp_s < 0);
    last_stamp_s = loan.stamp_s;
    if (wrapped) ++after;
    ASSERT_TRUE((*session)->stream().GiveBack(loan));
    ASSERT_LT(loan.sequence, 600U) << "the stamp does not wrap";
  }
  EXPECT_EQ(clock.stats().jumps, 0U);
  Order("wrap_timestamp", "None");
}

TEST(V4l2OnKernel, DroppedFramesAreCountedByTheirSequence) {
  Watched watched(SmallConfig());
  const auto first = watched.Next();
  ASSERT_NE(first, nullptr);
  Order("percentage_of_dropped_buffers", "50");
  std::shared_ptr<const Frame> last = first;
  std::uint32_t frames = 0;
  while (frames < 30) {
    last = watched.Next();
    ASSERT_NE(last, nullptr);
    ++frames;
  }
  Order("percentage_of_dropped_buffers", "0");
  EXPECT_GT(watched.Count("sequence_gaps"), 0);
  EXPECT_EQ(static_cast<std::int64_t>(last->sequence - first->sequence),
            frames + watched.Count("sequence_gaps"));
}

TEST(V4l2OnKernel, FramesMarkedAsDamagedAreLeftOut) {
  Watched watched(SmallConfig());
  watched.Frames(3);
  Order("inject_v4l2_buf_flag_error", "1");
  watched.Frames(200, [&] { return watched.Count("error_frames") > 0; });
  EXPECT_EQ(watched.Count("error_frames"), 1);
  EXPECT_EQ(watched.Frames(5), 5);
  EXPECT_EQ(watched.Count("lost"), 0);
}

TEST(V4l2OnKernel, StreamThatDiesIsOpenedAgain) {
  Watched watched(SmallConfig());
  watched.Frames(3);
  Order("inject_fatal_streaming_error", "1");
  EXPECT_EQ(watched.Trouble().code, core::ErrorCode::kUnavailable);
  EXPECT_EQ(watched.Frames(5), 5);
  EXPECT_EQ(watched.Count("opened"), 2);
  EXPECT_EQ(watched.Count("lost"), 1);
}

TEST(V4l2OnKernel, OpeningThatFailsIsTriedAgain) {
  for (const char* const fault : {"inject_vidioc_reqbufs_error", "inject_vidioc_qbuf_error",
                                  "inject_vidioc_streamon_error"}) {
    Order(fault, "1");
    Watched watched(SmallConfig());
    EXPECT_FALSE(watched.Trouble().message.empty()) << fault;
    EXPECT_EQ(watched.Frames(3), 3) << fault;
    EXPECT_EQ(watched.Count("open_failures"), 1) << fault;
  }
}

TEST(V4l2OnKernel, CameraThatHangsIsRestartedThenOpenedAgain) {
  V4l2CameraConfig config = SmallConfig();
  config.hang = core::Seconds(1);
  Watched watched(config);
  watched.Frames(3);
  Order("percentage_of_dropped_buffers", "100");
  const core::Error error = watched.Trouble();
  EXPECT_NE(error.message.find("its stream was restarted"), std::string::npos) << error.message;
  const core::MonoTime end = core::MonoNow() + kLong;
  while (watched.Count("opened") < 2 && core::MonoNow() < end) {
    (void)watched.camera().Next(core::Milliseconds(200));
  }
  EXPECT_GE(watched.Count("opened"), 2);
  EXPECT_GE(watched.Count("restarts"), 2);
  Order("percentage_of_dropped_buffers", "0");
  EXPECT_EQ(watched.Frames(5), 5);
}

TEST(V4l2OnKernel, BusyDeviceIsSaid) {
  Watched first(SmallConfig()), second(SmallConfig());
  first.Frames(2);
  const core::Error error = second.Trouble();
  EXPECT_EQ(error.code, core::ErrorCode::kUnavailable);
  EXPECT_NE(error.message.find("another program streams from it"), std::string::npos)
      << error.message;
  EXPECT_EQ(first.Frames(5), 5);
}

TEST(V4l2OnKernel, FoundByBusAndByName) {
  for (const char* const name : {"platform:vivid-000", "vivid"}) {
    V4l2CameraConfig config = SmallConfig();
    config.device = name;
    Watched watched(config);
    EXPECT_EQ(watched.Frames(2), 2) << name;
  }
}

TEST(V4l2OnKernel, ControlsAreSetAndRefusalsExplained) {
  V4l2CameraConfig config = SmallConfig();
  config.controls = {
      {"brightness", "100"}, {"test_pattern", "100% black"}, {"gain_automatic", "off"}};
  Watched watched(config);
  watched.Frames(1);
  EXPECT_EQ(watched.camera().session()->controls().Get("brightness").value(), 100);
  EXPECT_EQ(watched.camera().session()->controls().Get("test_pattern").value(), 5);
  EXPECT_EQ(watched.camera().session()->controls().Get("gain_automatic").value(), 0);
  const auto refused = watched.camera().Set({{"brightness", "256"}, {"brigthness", "1"}});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("expected 0..255"), std::string::npos);
  EXPECT_NE(refused.error().message.find("no control \"brigthness\"; it has: brightness"),
            std::string::npos);
  ASSERT_TRUE(watched.camera().Set(
      {{"brightness", "128"}, {"test_pattern", "0"}, {"gain_automatic", "1"}}));
}

TEST(V4l2OnKernel, DisconnectedByItselfComesBack) {
  Watched watched(SmallConfig());
  watched.Frames(3);
  Order("disconnect", "1");
  EXPECT_EQ(watched.Trouble().code, core::ErrorCode::kUnavailable);
  // The kernel brings the device back when its last user has let go.
  EXPECT_EQ(watched.Frames(5), 5);
}

TEST(V4l2OnKernel, UnpluggedAndPluggedInAgain) {
  Watched watched(SmallConfig());
  watched.Frames(3);
  Unplug();
  watched.Trouble();
  EXPECT_EQ(watched.Count("lost"), 1);
  EXPECT_FALSE(std::filesystem::exists(kVivid));
  EXPECT_FALSE(watched.camera().Next(core::Milliseconds(100)));
  Replug();
  EXPECT_EQ(watched.Frames(5), 5);
}

TEST(V4l2OnKernel, ComesBackUnderAnotherNumber) {
  Watched watched(SmallConfig());
  watched.Frames(3);
  // A program that never lets go of the dead node keeps its number taken.
  const int held = open(kVivid, O_RDWR | O_CLOEXEC);
  ASSERT_GE(held, 0);
  Unplug();
  watched.Trouble();
  Replug();
  EXPECT_FALSE(std::filesystem::exists(kVivid));
  EXPECT_EQ(watched.Frames(5), 5);
  EXPECT_NE(watched.camera().session()->device().path(), kVivid);
  EXPECT_EQ(watched.camera().session()->device().identity().bus_info, "platform:vivid-000");
  close(held);
  // As it was, for whoever comes next.
  Unplug();
  watched.Trouble();
  Replug();
  EXPECT_EQ(watched.Frames(2), 2);
}

}  // namespace
}  // namespace kawara::drivers
