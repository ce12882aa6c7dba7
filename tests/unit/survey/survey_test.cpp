#include "onboard/survey/survey.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "onboard/survey/frame_matching.hpp"
#include "tests/support/test_folder.hpp"

namespace kawara::survey {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr char kLens[] =
    "kb4: {width_px: 8, height_px: 6, fx_px: 5, fy_px: 5, center_u_px: 3.5, center_v_px: 2.5}\n";
constexpr char kPoses[] = "frame,x,y,z,qw,qx,qy,qz\n1,0,0,0,1,0,0,0\n2,1,0,0,1,0,0,0\n";

void Write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

void WritePicture(const fs::path& file, int width_px = 8, int height_px = 6, int type = CV_8UC3,
                  const cv::Scalar& bgr = {30, 20, 10}) {
  fs::create_directories(file.parent_path());
  ASSERT_TRUE(cv::imwrite(file.string(), cv::Mat(height_px, width_px, type, bgr)));
}

/// A folder with two frames of one camera.
void WriteSmall(const fs::path& folder) {
  Write(folder / "camera.yaml", std::string("camera: kb4\n") + kLens);
  Write(folder / "poses.csv", kPoses);
  WritePicture(folder / "frames" / "0001.png");
  WritePicture(folder / "frames" / "0002.png");
}

std::string ErrorOf(const fs::path& folder) {
  const auto survey = OpenSurvey(folder);
  return survey ? "no error" : survey.error().message;
}

TEST(Survey, FramesFindTheirPosesByName) {
  testing::TestFolder folder;
  WriteSmall(folder.path());
  WritePicture(folder / "frames/0010.png");
  const auto survey = OpenSurvey(folder.path());
  ASSERT_TRUE(survey) << survey.error().message;
  ASSERT_EQ(survey->frames.size(), 2U);
  EXPECT_EQ(survey->frames[1].name, "0002");
  EXPECT_EQ(survey->frames[1].pose.map_from_body.translation().x(), 1.0);
  EXPECT_EQ(survey->pictures_without_pose, 1);
  EXPECT_EQ(survey->poses_without_picture, 0);
  const auto picture = LoadFrame(*survey, survey->frames[0]);
  ASSERT_TRUE(picture);
  EXPECT_THAT(std::vector<int>(picture->rgb.begin(), picture->rgb.begin() + 3),
              ::testing::ElementsAre(10, 20, 30));
}

TEST(Survey, SeveralCamerasShareTheBodysPoses) {
  testing::TestFolder folder;
  Write(folder / "camera.yaml",
        std::string("cameras:\n  - name: a\n    camera: kb4\n    ") + kLens +
            "  - name: b\n    camera: kb4\n    frames: other/b_*.png\n    mask: mask.png\n    " +
            kLens);
  Write(folder / "poses.csv",
        "camera,x,y,z,qw,qx,qy,qz\n,0,0,0,1,0,0,0\n,1,0,0,1,0,0,0\nb,2,0,0,1,0,0,0\n");
  for (const char* name : {"frames/a/x1.png", "frames/a/x2.png", "other/b_1.png", "other/b_2.png",
                           "other/b_10.png", "other/c.png"}) {
    WritePicture(folder / name);
  }
  WritePicture(folder / "mask.png", 8, 6, CV_8UC1, {255});
  const auto survey = OpenSurvey(folder.path());
  ASSERT_TRUE(survey) << survey.error().message;
  EXPECT_EQ(survey->cameras.size(), 2U);
  ASSERT_EQ(survey->frames.size(), 5U);
  EXPECT_EQ(survey->frames[4].camera, 1);
  EXPECT_EQ(survey->frames[4].pose.map_from_body.translation().x(), 2.0);
  EXPECT_EQ(survey->cameras[1].mask, std::vector<std::uint8_t>(48, 255));
}

TEST(Survey, GreyAndSixteenBitPicturesBecomeRgb) {
  testing::TestFolder folder;
  WritePicture(folder / "g.png", 8, 6, CV_8UC1, {77});
  WritePicture(folder / "g16.png", 8, 6, CV_16UC1, {77 * 256 + 200});
  for (const char* name : {"g.png", "g16.png"}) {
    const auto picture = LoadPicture(folder / name);
    ASSERT_TRUE(picture) << picture.error().message;
    EXPECT_EQ(picture->rgb, std::vector<std::uint8_t>(8 * 6 * 3, 77)) << name;
  }
}

TEST(Survey, ReducedPicturesMustBeAskedFor) {
  testing::TestFolder folder;
  WriteSmall(folder.path());
  WritePicture(folder / "frames/0001.png", 4, 3);
  WritePicture(folder / "frames/0002.png", 4, 3);
  EXPECT_THAT(ErrorOf(folder.path()),
              HasSubstr("0001.png has 4 x 3 px, the calibration is for 8 x 6"));
  Write(folder / "camera.yaml", std::string("camera: kb4\nscale_to_picture: true\n") + kLens);
  const auto survey = OpenSurvey(folder.path());
  ASSERT_TRUE(survey) << survey.error().message;
  const vision::CameraModel& model = *survey->cameras[0].model;
  EXPECT_EQ(model.width_px(), 4);
  const auto middle = model.Project({0, 0, 1});
  ASSERT_TRUE(middle);
  EXPECT_NEAR(middle->x(), 1.5, 1e-12) << "the picture's middle stays its middle";
  EXPECT_TRUE(model.Symmetry());
}

TEST(Survey, WhatIsMissingIsNamed) {
  testing::TestFolder folder;
  EXPECT_THAT(ErrorOf(folder / "nowhere"), HasSubstr("nowhere: no such folder"));
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("camera.yaml"));
  Write(folder / "camera.yaml", std::string("camera: kb4\n") + kLens);
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("poses.csv: no such file"));
  Write(folder / "poses.csv", kPoses);
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("frames"));
  fs::create_directories(folder / "frames");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("no .jpg, .jpeg or .png"));
  Write(folder / "frames/1.png", "no picture");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("1.png: neither JPEG nor PNG"));
  fs::remove(folder / "frames/1.png");
  WritePicture(folder / "frames/7.png");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("no pose fits a picture"));
  Write(folder / "poses.csv", "x,y,z,qw,qx,qy,qz\n0,0,0,1,0,0,0\n1,0,0,1,0,0,0\n");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("2 poses and 1 pictures"));
  Write(folder / "camera.yaml", "calibration: lost.yaml\n");
  EXPECT_THAT(ErrorOf(folder.path()), HasSubstr("lost.yaml"));
}

TEST(Survey, CalibrationsMountingIsTheBodys) {
  testing::TestFolder folder;
  WriteSmall(folder.path());
  Write(folder / "camera.yaml", "calibration: k.yaml\n");
  Write(folder / "k.yaml",
        "cam0:\n  camera_model: pinhole\n  intrinsics: [5, 5, 3.5, 2.5]\n"
        "  distortion_model: equidistant\n  distortion_coeffs: [0, 0, 0, 0]\n  resolution: [8, 6]\n"
        "  T_cam_imu: [[0, -1, 0, 0], [0, 0, -1, 0], [1, 0, 0, -0.5], [0, 0, 0, 1]]\n");
  const auto survey = OpenSurvey(folder.path());
  ASSERT_TRUE(survey) << survey.error().message;
  const Eigen::Isometry3d& pose = survey->cameras[0].body_from_camera;
  EXPECT_TRUE(pose.translation().isApprox(Eigen::Vector3d(0.5, 0, 0), 1e-12));
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1, 0, 0), 1e-12));
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 0, 1), 1e-12));
}

TEST(FrameMatching, StampsInNamesAreUnderstood) {
  std::vector<PoseRow> rows(2);
  rows[0].time = core::GpsTime::FromNs(1305031102175304000);
  rows[1].time = core::GpsTime::FromNs(1305031102211214000);
  const auto seconds =
      MatchPictures(rows, "", {"f/1305031102.211300.png", "f/1305031102.175304.png"});
  ASSERT_TRUE(seconds);
  EXPECT_THAT(*seconds, ::testing::ElementsAre(1, 0));
  const auto nanoseconds = MatchPictures(rows, "", {"f/1305031102211214000.png"});
  ASSERT_TRUE(nanoseconds);
  EXPECT_THAT(*nanoseconds, ::testing::ElementsAre(-1, 0));
}

}  // namespace
}  // namespace kawara::survey
