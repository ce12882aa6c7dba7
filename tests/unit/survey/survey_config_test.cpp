#include "onboard/survey/survey_config.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "vision/camera/camera_model.hpp"

namespace kawara::survey {
namespace {

using ::testing::HasSubstr;
using vision::OpticalAxis;

constexpr double kTolerance = 1e-12;

Eigen::Isometry3d PoseOf(const MountingConfig& mounting,
                         BodyAxes body = BodyAxes::kForwardRightDown,
                         OpticalAxis axis = OpticalAxis::kForward) {
  const auto pose = BodyFromCamera(mounting, body, axis);
  EXPECT_TRUE(pose) << pose.error().message;
  return pose ? *pose : Eigen::Isometry3d::Identity();
}

// Camera frame: X up, Y right, Z forward.
TEST(Mounting, WithoutOneTheCameraIsUprightAndLooksAhead) {
  EXPECT_TRUE(PoseOf({}).linear().isApprox(vision::BodyFromCamera(), kTolerance));
  const Eigen::Matrix3d up = PoseOf({}, BodyAxes::kForwardLeftUp).linear();
  EXPECT_TRUE((up * Eigen::Vector3d(1, 0, 0)).isApprox(Eigen::Vector3d(0, 0, 1), kTolerance));
  EXPECT_TRUE((up * Eigen::Vector3d(0, 1, 0)).isApprox(Eigen::Vector3d(0, -1, 0), kTolerance));
  EXPECT_TRUE((up * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(1, 0, 0), kTolerance));
}

TEST(Mounting, AnglesTurnTheLookingCamera) {
  MountingConfig mounting;
  mounting.yaw_deg = 90.0;
  mounting.translation_m = {0.3, 0.0, -1.1};
  const auto pose = PoseOf(mounting);
  EXPECT_TRUE((pose.linear() * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12))
      << "forward-right-down: to the right";
  EXPECT_EQ(pose.translation(), mounting.translation_m);
  const auto left = PoseOf(mounting, BodyAxes::kForwardLeftUp);
  EXPECT_TRUE((left.linear() * Eigen::Vector3d(0, 0, 1)).isApprox(Eigen::Vector3d(0, 1, 0), 1e-12))
      << "forward-left-up: to the left";
}

TEST(Mounting, QuaternionAndMatrixSayTheSameInEitherAxes) {
  // A lens looking ahead from a forward-left-up body: optical z = x, optical x = -y, optical y =
  // -z.
  const Eigen::Isometry3d expected = PoseOf({}, BodyAxes::kForwardLeftUp);
  MountingConfig matrix;
  matrix.body_from_camera = {{0, 0, 1, 0.1}, {-1, 0, 0, 0.2}, {0, -1, 0, 0.3}, {0, 0, 0, 1}};
  EXPECT_TRUE(PoseOf(matrix).linear().isApprox(expected.linear(), kTolerance));
  EXPECT_EQ(PoseOf(matrix).translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  MountingConfig quaternion;
  quaternion.quaternion_wxyz = {0.5, -0.5, 0.5, -0.5};
  EXPECT_TRUE(PoseOf(quaternion).linear().isApprox(expected.linear(), kTolerance));
  MountingConfig ours;
  ours.axes = CameraAxes::kKawara;
  const Eigen::Quaterniond q(expected.linear());
  ours.quaternion_wxyz = {q.w(), q.x(), q.y(), q.z()};
  EXPECT_TRUE(PoseOf(ours).linear().isApprox(expected.linear(), kTolerance));
}

// Wherever the model's axis points in its own camera frame, the optical frame is what is mounted.
TEST(Mounting, OfTheOpticalFrameDoesNotDependOnTheAxis) {
  MountingConfig mounting;
  mounting.quaternion_wxyz = {0.8, 0.0, 0.6, 0.0};
  const Eigen::Vector3d axis_in_body =
      Eigen::Quaterniond(0.8, 0.0, 0.6, 0.0) * Eigen::Vector3d(0, 0, 1);
  for (const OpticalAxis axis : {OpticalAxis::kForward, OpticalAxis::kUp, OpticalAxis::kDown}) {
    const Eigen::Vector3d axis_in_camera = vision::CameraFromOptical(axis).col(2);
    const Eigen::Vector3d seen =
        PoseOf(mounting, BodyAxes::kForwardRightDown, axis).linear() * axis_in_camera;
    EXPECT_TRUE(seen.isApprox(axis_in_body, kTolerance));
  }
}

TEST(Mounting, ThatIsNoRotationIsRefused) {
  MountingConfig matrix;
  matrix.body_from_camera = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, -1, 0}, {0, 0, 0, 1}};
  EXPECT_FALSE(BodyFromCamera(matrix, BodyAxes::kForwardRightDown, OpticalAxis::kForward));
  matrix.body_from_camera = {{1, 0, 0}};
  EXPECT_FALSE(BodyFromCamera(matrix, BodyAxes::kForwardRightDown, OpticalAxis::kForward));
  MountingConfig quaternion;
  quaternion.quaternion_wxyz = {1.0, 1.0, 0.0, 0.0};
  EXPECT_FALSE(BodyFromCamera(quaternion, BodyAxes::kForwardRightDown, OpticalAxis::kForward));
}

TEST(SurveyConfig, MistakesAreToldWithTheirPlace) {
  const struct {
    const char* text;
    const char* expected;
  } cases[] = {
      {"camera: kb5\n", "camera.yaml:1:9: camera = kb5: expected one of"},
      {"camera: eucm\neucm: {width_px: 10}\n", "eucm.alpha: missing"},
      {"calibration: a.txt\nline_delay_ms: 3\n", "camera.yaml:2:1: line_delay_ms = 3: unknown"},
      {"body_axes: forward-right-down\n", "expected either camera"},
      {"camera: kb4\ncalibration: a.txt\n", "expected either camera"},
      {"cameras:\n  - calibration: a\n  - calibration: b\n", "expected a name"},
      {"cameras:\n  - {name: a, calibration: a}\n  - {name: a, calibration: b}\n",
       "another camera"},
      {"calibration: a\nmounting: {yaw_deg: 3, quaternion_wxyz: [1, 0, 0, 0]}\n", "one rotation"},
      {"- 1\n", "camera.yaml"},
  };
  for (const auto& c : cases) {
    const auto config = ParseSurveyConfig(c.text, "camera.yaml");
    ASSERT_FALSE(config) << c.text;
    EXPECT_THAT(config.error().message, HasSubstr(c.expected)) << c.text;
  }
}

}  // namespace
}  // namespace kawara::survey
