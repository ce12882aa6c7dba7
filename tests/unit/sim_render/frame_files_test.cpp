#include "sim/render/frame_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <opencv2/imgcodecs.hpp>

#include "vision/jpeg.hpp"

namespace kawara::sim {
namespace {

RenderedFrame SmallFrame() {
  RenderedFrame frame;
  frame.width_px = 3;
  frame.height_px = 2;
  frame.rgb = {255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9, 128, 128, 128, 255, 255, 255};
  frame.range_m = {1.2345F,       70.0F, std::numeric_limits<float>::infinity(),
                   std::nanf(""), 0.0F,  2.0F};
  frame.object = {1, 2, 0, 0, kRobotBodyObject, 500};
  return frame;
}

class FrameFiles : public testing::Test {
 protected:
  FrameFiles()
      : folder_(std::filesystem::path(testing::TempDir()) /
                ("frame_files_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~FrameFiles() override { std::filesystem::remove_all(folder_); }
  std::string Read(const std::string& name) const {
    std::ifstream file(folder_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  std::filesystem::path folder_;
};

TEST_F(FrameFiles, PfmKeepsEveryFloatBottomRowFirst) {
  const RenderedFrame frame = SmallFrame();
  ASSERT_TRUE(WriteRangePfm(frame, folder_ / "r.pfm"));
  const std::string bytes = Read("r.pfm");
  const std::string header = "Pf\n3 2\n-1.0\n";
  ASSERT_EQ(bytes.size(), header.size() + 6 * sizeof(float));
  EXPECT_EQ(bytes.substr(0, header.size()), header);
  std::array<std::uint32_t, 6> words{};
  std::memcpy(words.data(), bytes.data() + header.size(), sizeof(words));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(words[i], std::bit_cast<std::uint32_t>(frame.range_m[3 + i]));
    EXPECT_EQ(words[3 + i], std::bit_cast<std::uint32_t>(frame.range_m[i]));
  }
}

TEST_F(FrameFiles, RangePngIsMillimetresWithWordsForSkyAndOutside) {
  ASSERT_TRUE(WriteRangePng(SmallFrame(), folder_ / "r.png"));
  const cv::Mat image = cv::imread((folder_ / "r.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(image.type(), CV_16UC1);
  const std::vector<std::uint16_t> words(image.begin<std::uint16_t>(), image.end<std::uint16_t>());
  EXPECT_THAT(words, testing::ElementsAre(testing::AnyOf(1234, 1235), 65535, 65535, 0, 1, 2000));
}

TEST_F(FrameFiles, ObjectsPngKeepsIds) {
  ASSERT_TRUE(WriteObjectsPng(SmallFrame(), folder_ / "o.png"));
  const cv::Mat image = cv::imread((folder_ / "o.png").string(), cv::IMREAD_UNCHANGED);
  const std::vector<std::uint16_t> words(image.begin<std::uint16_t>(), image.end<std::uint16_t>());
  EXPECT_THAT(words, testing::ElementsAre(1, 2, 0, 0, 65535, 500));
}

TEST_F(FrameFiles, ColourPngKeepsEveryByteInOrder) {
  ASSERT_TRUE(WriteColourPng(SmallFrame(), folder_ / "c.png"));
  const cv::Mat image = cv::imread((folder_ / "c.png").string(), cv::IMREAD_COLOR);
  EXPECT_EQ(image.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 255));  // BGR
  EXPECT_EQ(image.at<cv::Vec3b>(0, 2), cv::Vec3b(255, 0, 0));
}

TEST_F(FrameFiles, JpegHasThePicturesSize) {
  ASSERT_TRUE(WriteColour(SmallFrame(), folder_ / "c.jpg"));
  const std::string bytes = Read("c.jpg");
  vision::JpegDecoder decoder;
  const auto info =
      decoder.ReadInfo({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
  ASSERT_TRUE(info);
  EXPECT_EQ(info->width_px, 3);
  EXPECT_EQ(info->height_px, 2);
}

TEST_F(FrameFiles, AFolderThatIsNotThereIsNamed) {
  const auto written = WriteRangePfm(SmallFrame(), folder_ / "none" / "r.pfm");
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().message, testing::HasSubstr("none/r.pfm"));
}

}  // namespace
}  // namespace kawara::sim
