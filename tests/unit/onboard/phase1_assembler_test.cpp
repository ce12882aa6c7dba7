#include "onboard/phase1_assembler.hpp"

#include <gtest/gtest.h>

#include <kawara/phase1_t.hpp>

#include "comms/codec.hpp"
#include "vision/jpeg.hpp"

namespace kawara::onboard {
namespace {

vision::Phase1PictureConfig SmallDoughnut() {
  vision::Phase1PictureConfig config;
  config.doughnut.width_px = config.doughnut.height_px = 256;
  config.doughnut.center_u_px = config.doughnut.center_v_px = 127.5;
  config.doughnut.l_in_px = 30;
  config.doughnut.l_base_px = 65.625;
  config.doughnut.l_out_px = 125;
  config.panorama.width_px = 512;
  config.preview_width_px = 128;
  return config;
}

std::shared_ptr<const drivers::Frame> FrameOf(std::vector<std::uint8_t> bytes) {
  auto frame = std::make_shared<drivers::Frame>();
  frame->format = drivers::PixelFormat::kJpeg;
  frame->width = frame->height = 256;
  frame->bytes = std::move(bytes);
  return frame;
}

/// A ring with something in it, so that two frames differ.
std::shared_ptr<const drivers::Frame> FrameWith(std::uint8_t shade) {
  std::vector<std::uint8_t> rgb(256 * 256 * 3, shade);
  vision::JpegEncoder encoder;
  const auto jpeg = encoder.Encode(vision::ConstImageView{rgb.data(), 256, 256}, {.quality = 90});
  return FrameOf({jpeg->begin(), jpeg->end()});
}

ExposurePose PoseOf(std::int64_t epoch) {
  ExposurePose pose;
  pose.epoch = epoch;
  pose.camera.valid = true;
  pose.camera.time = core::GpsTime::FromNs(1'400'000'000'000'000'000);
  pose.body = pose.camera;
  return pose;
}

class Phase1AssemblerTest : public ::testing::Test {
 protected:
  Phase1Assembler Make(const vision::Phase1PictureConfig& config = SmallDoughnut()) {
    auto made = Phase1Assembler::Create(
        config, {"robot", "mission", "make", "model"},
        [this](std::span<const std::uint8_t> bytes) {
          sent_.push_back({bytes.begin(), bytes.end()});
        },
        [this](const core::Error& error) { complaints_.push_back(error.message); });
    EXPECT_TRUE(made.has_value()) << made.error().message;
    return std::move(*made);
  }
  /// "epoch.stage" of what was sent.
  std::vector<std::string> Sent() const {
    std::vector<std::string> names;
    for (const auto& bytes : sent_) {
      const auto packet = comms::Decode<phase1_t>(bytes);
      EXPECT_TRUE(packet.has_value());
      names.push_back(std::to_string(packet->epoch) + "." + std::to_string(packet->stage));
    }
    return names;
  }
  static void WorkAll(Phase1Assembler& assembler) {
    while (assembler.Work()) {
    }
  }

  std::vector<std::vector<std::uint8_t>> sent_;
  std::vector<std::string> complaints_;
};

using Names = std::vector<std::string>;

TEST_F(Phase1AssemblerTest, PreviewLeavesBeforeTheFullPictureIsMade) {
  auto assembler = Make();
  assembler.OnFrame(1, FrameWith(90));
  assembler.OnPose(PoseOf(1));
  EXPECT_TRUE(assembler.Work());  // preview made
  EXPECT_TRUE(assembler.Work());  // preview sent
  EXPECT_EQ(Sent(), (Names{"1.0"}));
  WorkAll(assembler);
  EXPECT_EQ(Sent(), (Names{"1.0", "1.1"}));
}

TEST_F(Phase1AssemblerTest, NothingIsSentWithoutItsPose) {
  auto assembler = Make();
  assembler.OnFrame(1, FrameWith(90));
  WorkAll(assembler);
  EXPECT_TRUE(sent_.empty());
  EXPECT_EQ(assembler.stats().finished, 0);
}

TEST_F(Phase1AssemblerTest, SameBytesWhetherThePoseComesEarlyOrLate) {
  auto early = Make();
  early.OnFrame(1, FrameWith(90));
  early.OnPose(PoseOf(1));
  WorkAll(early);
  const auto first = std::exchange(sent_, {});
  auto late = Make();
  late.OnFrame(1, FrameWith(90));
  WorkAll(late);
  late.OnPose(PoseOf(1));
  WorkAll(late);
  EXPECT_EQ(first.size(), 2U);
  EXPECT_EQ(first, sent_);
}

TEST_F(Phase1AssemblerTest, APictureThatWaitsForItsPoseHoldsUpNoOther) {
  auto assembler = Make();
  assembler.OnFrame(1, FrameWith(90));
  assembler.OnFrame(2, FrameWith(120));
  assembler.OnPose(PoseOf(2));
  WorkAll(assembler);
  EXPECT_EQ(Sent(), (Names{"2.0", "2.1"}));
  assembler.OnPose(PoseOf(1));
  WorkAll(assembler);
  EXPECT_EQ(Sent(), (Names{"2.0", "2.1", "1.0", "1.1"}));
}

TEST_F(Phase1AssemblerTest, LevelledPicturesAreMadeWhenThePoseIsThere) {
  auto config = SmallDoughnut();
  config.panorama.level = true;
  auto assembler = Make(config);
  assembler.OnFrame(1, FrameWith(90));
  EXPECT_FALSE(assembler.Work());
  assembler.OnPose(PoseOf(1));
  WorkAll(assembler);
  EXPECT_EQ(Sent(), (Names{"1.0", "1.1"}));
}

TEST_F(Phase1AssemblerTest, EveryOrderIsFinishedOnceWhateverBecomesOfIt) {
  auto assembler = Make();
  assembler.OnFrame(1, FrameWith(90));
  assembler.OnFrame(2, FrameOf({1, 2, 3}));                                    // no picture
  for (const std::int64_t epoch : {1, 2, 3}) assembler.OnPose(PoseOf(epoch));  // 3: frame lost
  WorkAll(assembler);
  assembler.OnFrame(4, FrameOf({}));
  WorkAll(assembler);
  assembler.OnPose(PoseOf(4));  // its picture is known to be damaged by now
  EXPECT_EQ(Sent(), (Names{"1.0", "1.1"}));
  EXPECT_EQ(assembler.stats().finished, 4);
  EXPECT_EQ(assembler.stats().damaged, 2);
  EXPECT_EQ(complaints_.size(), 2U);
}

TEST_F(Phase1AssemblerTest, PicturesWithoutPosesDoNotPileUp) {
  auto assembler = Make();
  for (std::int64_t epoch = 1; epoch <= 20; ++epoch) assembler.OnFrame(epoch, FrameWith(90));
  for (std::int64_t epoch = 1; epoch <= 20; ++epoch) assembler.OnPose(PoseOf(epoch));
  WorkAll(assembler);
  EXPECT_EQ(assembler.stats().pictures, 8);
  EXPECT_EQ(assembler.stats().finished, 20);
}

TEST_F(Phase1AssemblerTest, GreyCameraGivesThePictureOfItsEqualInColour) {
  const auto frame_of = [](drivers::PixelFormat format, std::size_t channels) {
    auto frame = std::make_shared<drivers::Frame>();
    frame->format = format;
    frame->width = frame->height = 256;
    for (std::size_t i = 0; i < 256 * 256; ++i) {
      frame->bytes.insert(frame->bytes.end(), channels, static_cast<std::uint8_t>(i * 7 % 256));
    }
    return frame;
  };
  for (const auto& frame :
       {frame_of(drivers::PixelFormat::kGrey8, 1), frame_of(drivers::PixelFormat::kRgb8, 3)}) {
    Phase1Assembler assembler = Make();
    assembler.OnFrame(1, frame);
    assembler.OnPose(PoseOf(1));
    while (assembler.Work()) continue;
  }
  EXPECT_TRUE(complaints_.empty());
  ASSERT_EQ(sent_.size(), 4U);
  EXPECT_EQ(sent_[0], sent_[2]);
  EXPECT_EQ(sent_[1], sent_[3]);
}

}  // namespace
}  // namespace kawara::onboard
