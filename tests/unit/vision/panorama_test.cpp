#include "vision/panorama.hpp"

#include <gtest/gtest.h>

#include "vision_test_support.hpp"

namespace kawara::vision {
namespace {

constexpr double kDeg = core::kRadFromDeg;

struct Lamp {
  const char* name;
  Eigen::Vector3d direction_body;  // forward, right, down
  std::uint8_t rgb[3];
};
const Lamp kLamps[] = {
    {"forward", {1, 0, 0}, {255, 0, 0}},
    {"right", {0, 1, 0}, {0, 255, 0}},
    {"left", {0, -1, 0}, {0, 0, 255}},
    {"back, a little left and low", {-1, -0.1, 0.3}, {255, 255, 0}},
};

// The ring picture of a dark world with lamps, drawn ray by ray from the camera model alone.
TestImage RingWithLamps(const DoughnutCamera& camera, const Eigen::Matrix3d& R_camera_body) {
  TestImage ring(camera.width_px(), camera.height_px());
  for (int v = 0; v < ring.height; ++v) {
    for (int u = 0; u < ring.width; ++u) {
      const auto ray = camera.Unproject({u, v});
      if (!ray) continue;
      ring.at(u, v)[0] = ring.at(u, v)[1] = ring.at(u, v)[2] = 20;
      for (const Lamp& lamp : kLamps) {
        const Eigen::Vector3d direction = R_camera_body * lamp.direction_body.normalized();
        if (ray->dot(direction) > std::cos(4.0 * kDeg)) std::copy_n(lamp.rgb, 3, ring.at(u, v));
      }
    }
  }
  return ring;
}

// Heading and elevation at which a lamp's colour is centred in a panorama; NaN: not there.
Eigen::Vector2d Find(const TestImage& picture, const PanoramaGeometry& geometry, const Lamp& lamp) {
  const auto camera = EquirectangularCamera::Create(geometry);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int v = 0; v < picture.height; ++v) {
    for (int u = 0; u < picture.width; ++u) {
      int difference = 0;
      for (int c = 0; c < 3; ++c) difference += std::abs(picture.at(u, v)[c] - lamp.rgb[c]);
      if (difference < 60) sum += *camera->Unproject({u, v});
    }
  }
  return {std::atan2(sum.y(), sum.z()) / kDeg,
          std::atan2(sum.x(), std::hypot(sum.y(), sum.z())) / kDeg};
}

struct Case {
  const char* name;
  bool mirrored;
  double forward_deg;
  core::Attitude mount;
  core::Attitude body;
  bool level, north_up;
};

class PanoramaOrientation : public ::testing::TestWithParam<Case> {};

// Left in the picture is left of the robot, whatever the mirror, the mounting and the switches:
// every lamp must be seen where the picture's own attitude (the one that goes into GPano) says.
TEST_P(PanoramaOrientation, EveryLampIsWhereItBelongs) {
  const Case& c = GetParam();
  DoughnutParameters p = TestDoughnut(400);
  p.mirrored = c.mirrored;
  p.forward_deg = c.forward_deg;
  const auto camera = std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(p));
  PanoramaConfig config;
  config.width_px = 720;
  config.mount_roll_deg = c.mount.roll_rad / kDeg;
  config.mount_pitch_deg = c.mount.pitch_rad / kDeg;
  config.mount_yaw_deg = c.mount.yaw_rad / kDeg;
  config.level = c.level;
  config.north_up = c.north_up;
  auto unwrapper = PanoramaUnwrapper::Create(camera, config);
  ASSERT_TRUE(unwrapper) << unwrapper.error().message;
  ASSERT_TRUE(unwrapper->SetAttitude(c.body));

  const Eigen::Matrix3d R_body_mount = core::RotationNedFromBody(c.mount);
  const TestImage ring =
      RingWithLamps(*camera, BodyFromCamera().transpose() * R_body_mount.transpose());
  const PanoramaGeometry g = unwrapper->geometry();
  TestImage panorama(g.width_px, g.height_px);
  unwrapper->Unwrap(ring.view(), panorama.view());

  const core::Attitude picture = unwrapper->PictureAttitude(c.body);
  if (c.level) {
    EXPECT_NEAR(picture.roll_rad, 0.0, 1e-12);
    EXPECT_NEAR(picture.pitch_rad, 0.0, 1e-12);
  }
  if (c.north_up) {
    EXPECT_NEAR(picture.yaw_rad, 0.0, 1e-12);
  }
  const Eigen::Matrix3d R_picture_body =
      core::RotationNedFromBody(picture).transpose() * core::RotationNedFromBody(c.body);
  for (const Lamp& lamp : kLamps) {
    const Eigen::Vector3d d = R_picture_body * lamp.direction_body.normalized();
    const Eigen::Vector2d expected(std::atan2(d.y(), d.x()) / kDeg, std::asin(-d.z()) / kDeg);
    const Eigen::Vector2d seen = Find(panorama, g, lamp);
    EXPECT_NEAR(core::WrapPi((seen.x() - expected.x()) * kDeg) / kDeg, 0.0, 0.3) << lamp.name;
    EXPECT_NEAR(seen.y(), expected.y(), 0.3) << lamp.name;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cases, PanoramaOrientation,
    ::testing::Values(
        Case{"plain", false, 0, {}, {}, false, false},
        Case{"mirrored", true, -90, {}, {}, false, false},
        Case{"body_attitude_without_switches", true, 30, {}, {0.1, 0.1, 2.0}, false, false},
        Case{"camera_turned_and_tilted", true, 10, {0.05, -0.1, 1.2}, {}, false, false},
        Case{"level", false, 0, {}, {0.12, -0.1, 2.5}, true, false},
        Case{"north_up", true, 0, {}, {0.1, 0.05, -2.0}, false, true},
        Case{"level_north_up_tilted_mount",
             true,
             45,
             {0.03, 0.08, -0.5},
             {-0.1, 0.1, 1.0},
             true,
             true}),
    [](const auto& instance) { return std::string(instance.param.name); });

TEST(PanoramaUnwrapper, GeometryIsTheCamerasBand) {
  const auto camera = std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(TestDoughnut(400)));
  const auto natural = PanoramaUnwrapper::Create(camera, {.width_px = 720});
  EXPECT_EQ(natural->geometry(), (PanoramaGeometry{720, 160, 720, 360, 0, 120}));
  const auto cropped = PanoramaUnwrapper::Create(
      camera, {.width_px = 720, .elevation_top_deg = 10, .elevation_bottom_deg = -20});
  EXPECT_EQ(cropped->geometry(), (PanoramaGeometry{720, 60, 720, 360, 0, 160}));
}

TEST(PanoramaUnwrapper, RefusesWhatCannotBe) {
  const auto camera = std::make_shared<DoughnutCamera>(*DoughnutCamera::Create(TestDoughnut(400)));
  for (const PanoramaConfig& config :
       {PanoramaConfig{.width_px = 721}, PanoramaConfig{.width_px = 0},
        PanoramaConfig{.width_px = 720, .elevation_top_deg = -5, .elevation_bottom_deg = 5},
        PanoramaConfig{.width_px = 720, .elevation_top_deg = 100}}) {
    const auto unwrapper = PanoramaUnwrapper::Create(camera, config);
    ASSERT_FALSE(unwrapper);
    EXPECT_NE(unwrapper.error().message.find("expected"), std::string::npos);
  }
}

}  // namespace
}  // namespace kawara::vision
