#include "onboard/survey/calibration_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace kawara::survey {
namespace {

using ::testing::HasSubstr;

constexpr char kKalibr[] = R"(cam0:
  camera_model: ds
  intrinsics: [-0.2, 0.6, 300, 301, 320, 240]
  distortion_model: none
  distortion_coeffs: []
  resolution: [640, 480]
  T_cam_imu: [[0, -1, 0, 0.1], [0, 0, -1, 0.2], [1, 0, 0, 0.3], [0, 0, 0, 1]]
  timeshift_cam_imu: -0.003
  rostopic: /cam0
cam1:
  camera_model: eucm
  intrinsics: [0.6, 1.1, 310, 311, 321, 241]
  distortion_model: none
  resolution: [640, 480]
  T_cn_cnm1: [[1, 0, 0, -0.5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
)";

constexpr char kOcam[] = "# comment\n3 -200.0 0.0 0.002\n%s 300.5 400.5\n1.01 0.02 0.03\n480 640\n";

std::string Ocam(const char* inverse) {
  std::string text = kOcam;
  return text.replace(text.find("%s"), 2, inverse);
}

TEST(CalibrationFile, KalibrsChainOfCameras) {
  const auto all = ParseCalibration(kKalibr, "k.yaml");
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->size(), 2U);
  EXPECT_EQ((*all)[0].optics.double_sphere.xi, -0.2);
  EXPECT_EQ((*all)[0].optics.double_sphere.alpha, 0.6);
  EXPECT_EQ((*all)[0].time_offset_s, -0.003);
  EXPECT_EQ((*all)[1].optics.eucm.beta, 1.1);
  EXPECT_EQ((*all)[1].optics.eucm.focal.fy_px, 311.0);
  EXPECT_EQ((*all)[1].optics.eucm.common.center_v_px, 241.0);
  // T_cam_imu takes body points to the camera: the camera's centre is -R^T t.
  EXPECT_TRUE(
      (*all)[0].body_from_optical.translation().isApprox(Eigen::Vector3d(-0.3, 0.1, 0.2), 1e-12));
  // cam1 stands half a metre along cam0's x, which is the body's -y.
  EXPECT_TRUE((*all)[1].body_from_optical.translation().isApprox(
      Eigen::Vector3d(-0.3, 0.1 - 0.5, 0.2), 1e-12));
  EXPECT_TRUE((*all)[1].has_mounting);
}

TEST(CalibrationFile, OcamsRowsAndColumns) {
  for (const char* inverse : {"", "2 310.0 100.0\n"}) {
    const auto all = ParseCalibration(Ocam(inverse), "calib_results.txt");
    ASSERT_TRUE(all) << all.error().message;
    const vision::OcamParameters& ocam = (*all)[0].optics.ocam;
    EXPECT_EQ(ocam.common.center_v_px, 300.5) << "the row comes first";
    EXPECT_EQ(ocam.common.center_u_px, 400.5);
    EXPECT_EQ(ocam.common.height_px, 480) << "the height comes first";
    EXPECT_EQ(ocam.common.width_px, 640);
    const auto camera = vision::MakeLens(ocam);
    ASSERT_TRUE(camera);
    // At x' = 100 px down, y' = 0: v = c x' + centre, u = e x' + centre.
    const double depth = 200.0 - 0.002 * 100.0 * 100.0;
    const auto pixel = camera->Project({-100.0, 0.0, depth});  // X up, Y right, Z forward
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->y(), 300.5 + 1.01 * 100.0, 1e-9);
    EXPECT_NEAR(pixel->x(), 400.5 + 0.03 * 100.0, 1e-9);
  }
}

TEST(CalibrationFile, OpenCvsFourCoefficientsNeedAWord) {
  const std::string text =
      "K: [[500, 0, 320], [0, 501, 240], [0, 0, 1]]\nD: [0.1, 0.2, 0.3, 0.4]\n";
  const auto unclear = ParseCalibration(text, "c.yaml");
  ASSERT_FALSE(unclear);
  EXPECT_THAT(unclear.error().message, HasSubstr("calibration_as"));
  const auto fisheye = ParseCalibration(text, "c.yaml", OpenCvModel::kFisheye);
  ASSERT_TRUE(fisheye);
  EXPECT_EQ((*fisheye)[0].optics.camera, "kb4");
  EXPECT_EQ((*fisheye)[0].optics.kb4.k[3], 0.4);
  const auto pinhole = ParseCalibration(text, "c.yaml", OpenCvModel::kPinhole);
  ASSERT_TRUE(pinhole);
  EXPECT_EQ((*pinhole)[0].optics.mei.xi, 0.0);
  EXPECT_EQ((*pinhole)[0].optics.mei.p1, 0.3);
  const auto ros = ParseCalibration(text + "distortion_model: equidistant\n", "c.yaml");
  ASSERT_TRUE(ros);
  EXPECT_EQ((*ros)[0].optics.camera, "kb4");
}

TEST(CalibrationFile, MistakesAreToldWithTheirPlace) {
  std::string wrong_count = kKalibr;
  wrong_count.replace(wrong_count.find(", 240]"), 6, "]");
  std::string mirror = kKalibr;
  mirror.replace(mirror.find("[1, 0, 0, 0.3]"), 14, "[-1, 0, 0, 0.3]");
  const struct {
    std::string text;
    const char* expected;
  } cases[] = {
      {"", "not a calibration known here"},
      {"a: 1\n", "not a calibration known here"},
      {"<?xml version=\"1.0\"?>", "XML"},
      {wrong_count, "k:3:15: expected 6 numbers, found 5"},
      {mirror, "k:7:14: expected a rigid transform"},
      {"cam0: {camera_model: dome, resolution: [3, 4]}\n", "expected omni, eucm, ds or pinhole"},
      {"cam0: 3\n", "camera_model: missing"},
      {"value0: {intrinsics: [], T_imu_cam: [], resolution: []}\n", "as many of each"},
      {"3 -200 0 0.1\n1 2 3\n", "expected the direct polynomial"},
      {"2 -200 zero\n", "k:1:1: calib_results.txt: 'zero': expected a number"},
      {Ocam("7 1 2 3\n"), "found"},
  };
  for (const auto& c : cases) {
    const auto all = ParseCalibration(c.text, "k");
    ASSERT_FALSE(all) << c.text;
    EXPECT_THAT(all.error().message, HasSubstr(c.expected)) << c.text;
  }
}

}  // namespace
}  // namespace kawara::survey
