#include "vision/camera/lens_camera.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "tests/support/camera_vectors.hpp"
#include "vision/camera/camera_choice.hpp"
#include "vision/camera/radial_projection.hpp"

namespace kawara::vision {
namespace {

constexpr double kVectorPx = 1e-6;
constexpr double kInverseRad = 1e-9;

std::shared_ptr<const CameraModel> Made(const CameraChoice& choice) {
  auto camera = MakeCamera(choice);
  EXPECT_TRUE(camera) << camera.error().message;
  return camera ? *camera : nullptr;
}

Eigen::Vector3d FromOptical(const Eigen::Vector3d& ray) {
  return CameraFromOptical(OpticalAxis::kForward) * ray;
}

/// Cameras that no vector covers: what is not symmetric, and every option.
std::vector<std::pair<std::string, CameraChoice>> OtherCameras() {
  std::vector<std::pair<std::string, CameraChoice>> all;
  LensCommon common;
  common.width_px = 752;
  common.height_px = 480;
  common.center_u_px = 363.1;
  common.center_v_px = 248.1;
  CameraChoice c;
  c.camera = "mei";
  c.mei = {common, {912.3, 910.7, 0.0}, 1.97, -0.27, 1.31, 0.0, -0.0007, 0.0009};
  all.emplace_back("mei with p1, p2", c);
  c.mei = {common, {458.6, 457.3, 0.4}, 0.0, -0.283, 0.074, 0.0, 0.00019, 1.8e-05};
  all.emplace_back("pinhole with radial and tangential terms", c);
  c.camera = "ocam";
  c.ocam = {common, {-220.1, 0.0, 1.6e-3, -1.5e-6, 6.2e-9}, 0.9996, 3.1e-4, -2.2e-4};
  all.emplace_back("ocam with its affine", c);
  c.ocam.common.mirrored = true;
  c.ocam.common.axis = OpticalAxis::kUp;
  all.emplace_back("ocam of a mirror", c);
  c.camera = "kb4";
  c.kb4 = {common, {190.9, 190.9, -0.3}, {0.0034, 0.0007, -0.0020, 0.0002}};
  c.kb4.common.axis = OpticalAxis::kDown;
  c.kb4.common.max_angle_deg = 88.0;
  all.emplace_back("kb4 with skew, hanging, cut at 88 deg", c);
  return all;
}

std::vector<std::pair<std::string, CameraChoice>> AllCameras() {
  auto all = OtherCameras();
  for (const CameraVectors& v : ReadCameraVectors()) {
    if (v.model != "eq2-linear") all.emplace_back(v.set + "/" + v.model, ChoiceOf(v));
  }
  return all;
}

TEST(LensCamera, MeetsTheVectorsOfEveryModel) {
  int models = 0, beyond_fold = 0;
  for (const CameraVectors& v : ReadCameraVectors()) {
    if (v.model == "eq2-linear") continue;
    const auto camera = Made(ChoiceOf(v));
    ASSERT_TRUE(camera);
    const auto& law = dynamic_cast<const LensCamera&>(*camera).law();
    for (std::size_t i = 0; i < v.rays_optical.size(); ++i) {
      const Eigen::Vector3d& ray = v.rays_optical[i];
      const auto pixel = camera->Project(FromOptical(ray));
      if (std::atan2(ray.head<2>().norm(), ray.z()) > law.max_angle_rad()) {
        EXPECT_FALSE(pixel) << "beyond the fold no pixel is right";
        // The formula is the vectors' all the same.
        const double radius =
            dynamic_cast<const RadialLaw&>(law).Radius({ray.head<2>().norm(), ray.z()});
        const double expected =
            (v.pixels[i].x() - v.parameters[0]) / ray.x() * ray.head<2>().norm() / v.parameters[3];
        EXPECT_NEAR(radius, expected, 1e-6) << v.set << "/" << v.model << " " << i;
        ++beyond_fold;
        continue;
      }
      ASSERT_TRUE(pixel) << v.set << "/" << v.model << " ray " << i;
      // Of a pixel far outside (1e4 px) the rays' 12 decimals are part of the difference.
      const double tolerance = kVectorPx + 1e-11 * v.pixels[i].norm();
      EXPECT_NEAR(pixel->x(), v.pixels[i].x(), tolerance) << v.set << "/" << v.model << " " << i;
      EXPECT_NEAR(pixel->y(), v.pixels[i].y(), tolerance) << v.set << "/" << v.model << " " << i;
    }
    ++models;
  }
  EXPECT_EQ(models, 28);
  EXPECT_EQ(beyond_fold, 79) << "all of Fisheye190deg/KB4, see below";
}

TEST(LensCamera, IsFoldedOnlyWhereTheVectorsFold) {
  for (const CameraVectors& v : ReadCameraVectors()) {
    if (v.model == "eq2-linear") continue;
    const auto camera = Made(ChoiceOf(v));
    const double end = dynamic_cast<const LensCamera&>(*camera).law().max_angle_rad();
    if (v.set == "Fisheye190deg" && v.model == "KB4") {
      // Where 1 + 3 k1 a^2 + 5 k2 a^4 + 7 k3 a^6 + 9 k4 a^8 is zero, to the steps of FindDomain.
      const OddPolynomial law{{v.parameters[4], v.parameters[5], v.parameters[6], v.parameters[7]}};
      EXPECT_GT(law.Slope(end - 0.03 * core::kRadFromDeg), 0.0);
      EXPECT_LT(law.Slope(end + 0.03 * core::kRadFromDeg), 0.0);
    } else {
      EXPECT_GT(end * core::kDegFromRad, 94.9) << v.set << "/" << v.model;
    }
  }
}

TEST(LensCamera, RaysOfTheWholeDomainComeBack) {
  for (const auto& [name, choice] : AllCameras()) {
    const auto camera = Made(choice);
    ASSERT_TRUE(camera) << name;
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    int seen = 0;
    double worst_rad = 0.0;
    for (int i = 0; i < 20000; ++i) {
      const double x = normal(random), y = normal(random), z = normal(random);
      const Eigen::Vector3d ray = Eigen::Vector3d(x, y, z).normalized();
      const auto pixel = camera->Project(3.7 * ray);
      if (!pixel) continue;
      const auto back = camera->Unproject(*pixel);
      ASSERT_TRUE(back) << name << " at " << pixel->transpose();
      worst_rad = std::max(worst_rad, std::atan2(back->cross(ray).norm(), back->dot(ray)));
      ++seen;
    }
    EXPECT_GT(seen, 2000) << name;
    EXPECT_LT(worst_rad, kInverseRad) << name;
  }
}

TEST(LensCamera, PixelsComeBackAndNoTwoRaysShareOne) {
  for (const auto& [name, choice] : AllCameras()) {
    const auto camera = Made(choice);
    int seen = 0;
    for (int v = 0; v < camera->height_px(); v += 7) {
      for (int u = 0; u < camera->width_px(); u += 7) {
        const Eigen::Vector2d pixel(u + 0.3, v + 0.6);
        const auto ray = camera->Unproject(pixel);
        if (!ray) continue;
        ASSERT_NEAR(ray->norm(), 1.0, 1e-12) << name;
        const auto back = camera->Project(*ray);
        ASSERT_TRUE(back) << name << " at " << pixel.transpose();
        ASSERT_LT((*back - pixel).norm(), 1e-6) << name;
        ++seen;
      }
    }
    EXPECT_GT(seen, 1000) << name;
  }
}

TEST(LensCamera, RadiusGrowsOverTheWholeDomain) {
  for (const auto& [name, choice] : AllCameras()) {
    const auto camera = Made(choice);
    const auto* law =
        dynamic_cast<const RadialLaw*>(&dynamic_cast<const LensCamera&>(*camera).law());
    if (law == nullptr) continue;
    double last = -1.0;
    for (int i = 0; i <= 5000; ++i) {
      const double angle = law->max_angle_rad() * i / 5000;
      const double radius = law->Radius({std::sin(angle), std::cos(angle)});
      ASSERT_GT(radius, last) << name << " at " << angle * core::kDegFromRad << " deg";
      last = radius;
    }
  }
}

TEST(LensCamera, FastProjectionAgrees) {
  for (const auto& [name, choice] : AllCameras()) {
    const auto camera = Made(choice);
    const auto fast = RadialProjection::Create(*camera);
    ASSERT_EQ(fast.has_value(), camera->Symmetry().has_value()) << name;
    if (!fast) continue;
    EXPECT_LE(fast->table_error_px(), RadialProjection::kTableTolerancePx) << name;
    double worst_px = 0.0;
    int seen = 0;
    for (int v = 1; v < camera->height_px(); v += 5) {
      for (int u = 1; u < camera->width_px(); u += 5) {
        const auto ray = camera->Unproject({u, v});
        if (!ray) continue;
        const Eigen::Vector3f o = (fast->R_optical_camera() * *ray).cast<float>();
        float fu = 0, fv = 0;
        if (!fast->Project(o.x(), o.y(), o.z(), &fu, &fv)) continue;
        worst_px = std::max(
            worst_px, (Eigen::Vector2f(fu, fv).cast<double>() - Eigen::Vector2d(u, v)).norm());
        ++seen;
      }
    }
    EXPECT_GT(seen, 2000) << name;
    EXPECT_LT(worst_px, 1e-3) << name;
  }
}

// The scene: something bright ahead, something to the right, something above. Which way it lies in
// the picture is what no calibration board can tell.
TEST(LensCamera, FramesAndHandedness) {
  struct Case {
    OpticalAxis axis;
    bool mirrored;
    Eigen::Vector3d along_axis, to_right_of_picture,
        to_top_of_picture;  // camera frame: up right fwd
  };
  const Eigen::Vector3d up(1, 0, 0), right(0, 1, 0), forward(0, 0, 1);
  const std::vector<Case> cases = {
      {OpticalAxis::kForward, false, forward, right, up},
      {OpticalAxis::kForward, true, forward, -right, up},
      {OpticalAxis::kUp, false, up, -right, forward},
      {OpticalAxis::kUp, true, up, right, forward},
      {OpticalAxis::kDown, false, -up, right, forward},
      {OpticalAxis::kDown, true, -up, -right, forward},
  };
  for (const Case& c : cases) {
    KannalaBrandtParameters p;
    p.common = {401, 401, 200.0, 200.0, c.mirrored, c.axis, 180.0};
    p.focal = {100.0, 100.0, 0.0};
    const auto camera = MakeLens(p);
    ASSERT_TRUE(camera);
    const Eigen::Vector2d middle(200, 200);
    const auto axis = camera->Project(c.along_axis);
    const auto at_right = camera->Project(c.along_axis + 0.2 * c.to_right_of_picture);
    const auto at_top = camera->Project(c.along_axis + 0.2 * c.to_top_of_picture);
    ASSERT_TRUE(axis && at_right && at_top);
    EXPECT_LT((*axis - middle).norm(), 1e-9);
    EXPECT_GT(at_right->x(), 210.0);
    EXPECT_NEAR(at_right->y(), 200.0, 1e-9);
    EXPECT_LT(at_top->y(), 190.0);
    EXPECT_NEAR(at_top->x(), 200.0, 1e-9);
  }
}

TEST(LensCamera, MaxAngleCutsTheField) {
  KannalaBrandtParameters p;
  p.common = {800, 800, 399.5, 399.5, false, OpticalAxis::kForward, 70.0};
  p.focal = {300.0, 300.0, 0.0};
  const auto camera = MakeLens(p);
  ASSERT_TRUE(camera);
  const auto at = [](double deg) {
    const double a = deg * core::kRadFromDeg;
    return Eigen::Vector3d(0.0, std::sin(a), std::cos(a));
  };
  EXPECT_TRUE(camera->Project(at(69.99)));
  EXPECT_FALSE(camera->Project(at(70.01)));
  EXPECT_FALSE(camera->Unproject({399.5 + 300.0 * 70.01 * core::kRadFromDeg, 399.5}));
}

TEST(LensCamera, OcamTakesEitherSignOfItsAxis) {
  CameraChoice ours = OtherCameras()[2].second;
  const auto first = Made(ours);
  for (double& a : ours.ocam.polynomial) a = -a;
  const auto second = Made(ours);
  const Eigen::Vector3d ray(0.3, -0.4, 0.9);
  EXPECT_EQ(*first->Project(ray), *second->Project(ray));
}

TEST(LensCamera, RefusesWhatIsNoLens) {
  KannalaBrandtParameters flat;
  flat.common = {640, 480, 320.0, 240.0, false, OpticalAxis::kForward, 180.0};
  flat.focal = {0.0, 100.0, 0.0};
  EXPECT_FALSE(MakeLens(flat));
  flat.focal = {100.0, 100.0, 0.0};
  flat.k[1] = std::nan("");
  EXPECT_FALSE(MakeLens(flat));
  OcamParameters none;
  none.common = flat.common;
  EXPECT_FALSE(MakeLens(none));
  none.polynomial = {0.0, 1.0};
  EXPECT_FALSE(MakeLens(none));
  DoubleSphereParameters ds{flat.common, {100.0, 100.0, 0.0}, -1.5, 0.5};
  EXPECT_FALSE(MakeLens(ds));
}

TEST(LensCamera, BadRaysAndPixelsAreNotSeen) {
  const double nan = std::nan("");
  for (const auto& [name, choice] : AllCameras()) {
    const auto camera = Made(choice);
    EXPECT_FALSE(camera->Project({0, 0, 0})) << name;
    EXPECT_FALSE(camera->Project({nan, 0, 1})) << name;
    EXPECT_FALSE(camera->Unproject({nan, 3.0})) << name;
    EXPECT_FALSE(camera->Unproject({1e300, 3.0})) << name;
  }
}

}  // namespace
}  // namespace kawara::vision
