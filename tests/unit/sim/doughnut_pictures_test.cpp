#include "sim/camera/doughnut_pictures.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

#include "sim/camera/caption.hpp"
#include "sim/camera/doughnut_geometry.hpp"
#include "sim/camera/folder_pictures.hpp"

namespace kawara::sim {
namespace {

constexpr int kWorldWidthPx = 1440;

/// Surroundings whose colour tells where one looks: blue rises with the azimuth (0..360
/// -> 20..236), green with the elevation.
cv::Mat MadeWorld() {
  cv::Mat world(kWorldWidthPx / 2, kWorldWidthPx, CV_8UC3);
  for (int v = 0; v < world.rows; ++v) {
    for (int u = 0; u < world.cols; ++u) {
      // The centre column is north: azimuth 0 lies at half the width.
      const double azimuth = std::fmod((u + 0.5) / world.cols * 360.0 + 180.0, 360.0);
      const double elevation = 90.0 - (v + 0.5) / world.rows * 180.0;
      world.at<cv::Vec3b>(v, u) =
          cv::Vec3b(static_cast<std::uint8_t>(std::lround(20.0 + azimuth * 0.6)),
                    static_cast<std::uint8_t>(std::lround(128.0 + elevation)), 40);
    }
  }
  return world;
}

class DoughnutTest : public ::testing::Test {
 protected:
  void SetUp() override {
    std::string name = testing::TempDir() + "kawara_doughnut_XXXXXX";
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    cv::imwrite((folder_ / "world.png").string(), MadeWorld());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  DoughnutPictures Open() {
    return DoughnutPictures::Open(folder_ / "world.png", geometry_, 90).value();
  }
  /// What the picture shows in a direction of the camera frame.
  cv::Vec3b Look(const DoughnutPictures& pictures, double theta_deg, double elevation_deg) const {
    const vision::DoughnutCamera camera = vision::DoughnutCamera::Create(geometry_).value();
    const double theta = theta_deg * core::kRadFromDeg;
    const double phi = elevation_deg * core::kRadFromDeg;
    const auto at = camera.Project(
        {std::sin(phi), std::cos(phi) * std::sin(theta), std::cos(phi) * std::cos(theta)});
    return pictures.image().at<cv::Vec3b>(static_cast<int>(std::lround(at->y())),
                                          static_cast<int>(std::lround(at->x())));
  }

  vision::DoughnutParameters geometry_ = StandardDoughnut(1024);
  std::filesystem::path folder_;
};

TEST_F(DoughnutTest, WorldStandsStillWhileTheVehicleTurns) {
  DoughnutPictures pictures = Open();
  for (const double yaw_deg : {0.0, 0.1, 90.0, 179.9, -90.0, -0.3, 213.7}) {
    ASSERT_TRUE(pictures.Expose(yaw_deg * core::kRadFromDeg, {}));
    for (const double theta_deg :
         {-170.0, -80.0, 75.0, 120.0, 165.0}) {  // the caption covers the middle
      for (const double elevation_deg : {-30.0, 0.0, 20.0}) {
        double azimuth = std::fmod(theta_deg + yaw_deg + 720.0, 360.0);
        if (azimuth < 2.0 || azimuth > 358.0) continue;  // the made colour jumps at north
        const cv::Vec3b seen = Look(pictures, theta_deg, elevation_deg);
        EXPECT_NEAR(seen[0], 20.0 + azimuth * 0.6, 1.6)
            << "yaw " << yaw_deg << " theta " << theta_deg;
        EXPECT_NEAR(seen[1], 128.0 + elevation_deg, 1.6);
      }
    }
  }
}

TEST_F(DoughnutTest, OutsideTheRingItIsBlack) {
  DoughnutPictures pictures = Open();
  ASSERT_TRUE(pictures.Expose(0.0, {}));
  EXPECT_EQ(pictures.image().at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
  EXPECT_EQ(pictures.image().at<cv::Vec3b>(511, 511), cv::Vec3b(0, 0, 0));
}

TEST_F(DoughnutTest, CaptionIsUprightInTheUnwrappedPictureAndReadsBackAfterJpeg) {
  DoughnutPictures pictures = Open();
  const Caption caption{.trigger_sequence = 4711,
                        .exposure = core::FromWeek({2374, core::Milliseconds(243'300'499)})};
  const auto picture = pictures.Expose(1.0, caption);
  ASSERT_TRUE(picture);
  const cv::Mat decoded = cv::imdecode(picture->jpeg, cv::IMREAD_COLOR);
  ASSERT_EQ(decoded.cols, 1024);
  // Unwrap just the caption's place: left is left (smaller theta), up is up.
  const vision::DoughnutCamera camera = vision::DoughnutCamera::Create(geometry_).value();
  cv::Mat map_u(120, 960, CV_32FC1);
  cv::Mat map_v(120, 960, CV_32FC1);
  const double bottom_deg = camera.Elevations().bottom_rad * core::kDegFromRad + kCaptionMargin_deg;
  for (int v = 0; v < map_u.rows; ++v) {
    for (int u = 0; u < map_u.cols; ++u) {
      const double theta = ((u + 0.5) / map_u.cols - 0.5) * kCaptionWidth_deg * core::kRadFromDeg;
      const double phi =
          (bottom_deg + (1.0 - (v + 0.5) / map_u.rows) * kCaptionHeight_deg) * core::kRadFromDeg;
      const auto at = camera.Project(
          {std::sin(phi), std::cos(phi) * std::sin(theta), std::cos(phi) * std::cos(theta)});
      map_u.at<float>(v, u) = static_cast<float>(at->x());
      map_v.at<float>(v, u) = static_cast<float>(at->y());
    }
  }
  cv::Mat unwrapped;
  cv::remap(decoded, unwrapped, map_u, map_v, cv::INTER_LINEAR);
  const auto reading = ReadCaption(unwrapped);
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->trigger_sequence, 4711U);
  EXPECT_EQ(reading->exposure_ms_of_week, 243'300'499U);
}

TEST_F(DoughnutTest, PreparedPictureIsUsedAndAWrongGuessIsNot) {
  DoughnutPictures pictures = Open();
  pictures.Prepare(1.0);
  ASSERT_TRUE(pictures.Expose(1.0 + 2.0 * core::kPi, {}));  // the same direction
  EXPECT_EQ(pictures.rendered_late(), 0U);
  ASSERT_TRUE(pictures.Expose(1.1, {}));
  EXPECT_EQ(pictures.rendered_late(), 1U);
  EXPECT_NEAR(Look(pictures, 90.0, 0.0)[0], 20.0 + (90.0 + 1.1 * core::kDegFromRad) * 0.6, 1.6);
}

TEST_F(DoughnutTest, WrongPanoramasAreRefused) {
  cv::imwrite((folder_ / "square.png").string(), cv::Mat::zeros(100, 100, CV_8UC3));
  EXPECT_EQ(DoughnutPictures::Open(folder_ / "square.png", geometry_, 90).error().code,
            core::ErrorCode::kFormat);
  EXPECT_EQ(DoughnutPictures::Open(folder_ / "none.jpg", geometry_, 90).error().code,
            core::ErrorCode::kNotFound);
  geometry_.l_in_px = 600.0;
  EXPECT_EQ(DoughnutPictures::Open(folder_ / "world.png", geometry_, 90).error().code,
            core::ErrorCode::kInvalidArgument);
}

TEST(Caption, SurvivesReductionButNotDamage) {
  const Caption caption{.trigger_sequence = 0xDEADBEEF,
                        .exposure = core::FromWeek({2374, core::Milliseconds(604'799'999)})};
  const cv::Mat drawn = DrawCaption(caption);
  for (const int width : {2000, 640, 320, 160}) {
    cv::Mat small;
    cv::resize(drawn, small, {width, std::max(width / 8, 24)}, 0, 0, cv::INTER_AREA);
    const auto reading = ReadCaption(small);
    ASSERT_TRUE(reading) << width;
    EXPECT_EQ(reading->trigger_sequence, 0xDEADBEEFU);
    EXPECT_EQ(reading->exposure_ms_of_week, 604'799'999U);
  }
  cv::Mat damaged = drawn.clone();
  cv::bitwise_not(damaged.colRange(320, 336), damaged.colRange(320, 336));
  EXPECT_FALSE(ReadCaption(damaged));
  EXPECT_FALSE(ReadCaption(cv::Mat::zeros(100, 800, CV_8UC1)));
  EXPECT_FALSE(ReadCaption(cv::Mat()));
}

TEST_F(DoughnutTest, FolderGivesItsPicturesInOrderAndAround) {
  std::filesystem::remove(folder_ / "world.png");
  EXPECT_EQ(FolderPictures::Open(folder_).error().code, core::ErrorCode::kNotFound);
  cv::imwrite((folder_ / "b.jpg").string(), cv::Mat::zeros(30, 20, CV_8UC3));
  cv::imwrite((folder_ / "a.JPG").string(), cv::Mat::zeros(10, 50, CV_8UC3));
  auto pictures = FolderPictures::Open(folder_);
  ASSERT_TRUE(pictures) << pictures.error().message;
  for (const std::uint32_t width : {50U, 20U, 50U}) {
    const auto picture = pictures->Expose({});
    ASSERT_TRUE(picture);
    EXPECT_EQ(picture->width, width);
    EXPECT_EQ(picture->height, width == 50U ? 10U : 30U);
  }
  cv::imwrite((folder_ / "c.png").string(), cv::Mat::zeros(10, 10, CV_8UC3));
  std::filesystem::rename(folder_ / "c.png", folder_ / "c.jpg");
  EXPECT_EQ(FolderPictures::Open(folder_).error().code, core::ErrorCode::kFormat);
}

}  // namespace
}  // namespace kawara::sim
