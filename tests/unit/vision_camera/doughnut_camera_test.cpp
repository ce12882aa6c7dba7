#include "vision/camera/doughnut_camera.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "tests/support/test_doughnut.hpp"

namespace kawara::vision {
namespace {

constexpr double kVectorTolerancePx = 1e-6;

struct VectorSet {
  std::string name;
  DoughnutParameters parameters;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector2d>> vectors;
  double a = 0, b = 0;
};

// The file's r = a theta + b, theta from the axis, is eq. (2) with phi = 90 deg - theta: slope 1 /
// a and L_base = a pi / 2 + b. The circles are put where phi = 90 deg (or r = 0) and 6 deg past the
// horizon.
std::vector<VectorSet> ReadVectors() {
  std::ifstream file(std::string(KAWARA_SOURCE_DIR) + "/data/camera/linear_doughnut_vectors.txt");
  std::vector<VectorSet> sets;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    if (line.starts_with("#")) continue;
    if (line.starts_with("camera")) {
      VectorSet set;
      std::string word;
      DoughnutParameters& p = set.parameters;
      words >> word >> set.name >> p.center_u_px >> p.center_v_px >> p.v_scale >> set.a >> set.b;
      p.width_px = p.height_px = 2048;
      p.l_base_px = set.a * core::kPi / 2 + set.b;
      p.l_in_px = std::max(0.0, set.b);
      p.l_out_px = set.a * 96.0 * core::kRadFromDeg + set.b;
      p.phi_top_deg = (p.l_base_px - p.l_in_px) / set.a * core::kDegFromRad;
      p.phi_bottom_deg = (p.l_base_px - p.l_out_px) / set.a * core::kDegFromRad;
      sets.push_back(set);
    } else {
      double x, y, z, u, v;
      words >> x >> y >> z >> u >> v;
      // The file's z is the mirror's axis, our X; its x lies along u, our Z.
      sets.back().vectors.push_back({Eigen::Vector3d(z, y, x), Eigen::Vector2d(u, v)});
    }
  }
  return sets;
}

TEST(DoughnutCamera, ProjectsTheVectorsOfFourRealCameras) {
  const auto sets = ReadVectors();
  ASSERT_EQ(sets.size(), 4u);
  int seen = 0, hidden = 0;
  for (const VectorSet& set : sets) {
    const auto camera = DoughnutCamera::Create(set.parameters);
    ASSERT_TRUE(camera) << set.name << ": " << camera.error().message;
    ASSERT_EQ(set.vectors.size(), 233u);
    for (const auto& [ray, expected] : set.vectors) {
      const double theta = std::atan2(std::hypot(ray.y(), ray.z()), ray.x());
      const auto pixel = camera->Project(ray);
      if (set.a * theta + set.b < 0.0) {
        EXPECT_FALSE(pixel);  // a negative radius is no pixel of a ring
        ++hidden;
        continue;
      }
      ASSERT_TRUE(pixel) << set.name;
      EXPECT_NEAR(pixel->x(), expected.x(), kVectorTolerancePx) << set.name;
      EXPECT_NEAR(pixel->y(), expected.y(), kVectorTolerancePx) << set.name;
      ++seen;
    }
  }
  EXPECT_EQ(seen, 922);
  EXPECT_EQ(hidden, 10);
}

TEST(DoughnutCamera, UnprojectInvertsProject) {
  for (bool mirrored : {false, true}) {
    for (double forward_deg : {0.0, 73.0, -140.0}) {
      DoughnutParameters p = TestDoughnut();
      p.mirrored = mirrored;
      p.forward_deg = forward_deg;
      p.v_scale = 1.03;
      const auto camera = DoughnutCamera::Create(p);
      ASSERT_TRUE(camera);
      for (double phi_deg = -49.9; phi_deg < 30.0; phi_deg += 5.3) {
        for (double theta_deg = -180.0; theta_deg <= 180.0; theta_deg += 7.1) {
          const double phi = phi_deg * core::kRadFromDeg, theta = theta_deg * core::kRadFromDeg;
          const Eigen::Vector3d ray(std::sin(phi), std::cos(phi) * std::sin(theta),
                                    std::cos(phi) * std::cos(theta));
          const auto pixel = camera->Project(3.7 * ray);
          ASSERT_TRUE(pixel);
          const auto back = camera->Unproject(*pixel);
          ASSERT_TRUE(back);
          EXPECT_LT((*back - ray).norm(), 1e-12);
        }
      }
    }
  }
}

// Where forward, right and up of the camera frame appear: eq. (1) with u to the right and v down.
TEST(DoughnutCamera, AxesAreWhereTheContractSays) {
  struct Case {
    const char* name;
    bool mirrored;
    double forward_deg;
    Eigen::Vector3d ray;
    Eigen::Vector2d offset_px;  // from the principal point
  };
  const Eigen::Vector3d forward(0, 0, 1), right(0, 1, 0);
  const Case cases[] = {
      {"forward is along u", false, 0, forward, {262.5, 0}},
      {"right is along v", false, 0, right, {0, 262.5}},
      {"mirrored: right is against v", true, 0, right, {0, -262.5}},
      {"mirrored: forward stays", true, 0, forward, {262.5, 0}},
      {"forward turned to the top of the picture", false, -90, forward, {0, -262.5}},
      {"then right is at the right", false, -90, right, {262.5, 0}},
      {"mirrored and turned: right is at the left", true, -90, right, {-262.5, 0}},
      {"10 deg up is nearer the centre",
       false,
       0,
       {std::tan(10 * core::kRadFromDeg), 0, 1},
       {262.5 - 47.5, 0}},
  };
  for (const Case& c : cases) {
    DoughnutParameters p = TestDoughnut();
    p.mirrored = c.mirrored;
    p.forward_deg = c.forward_deg;
    const auto camera = DoughnutCamera::Create(p);
    ASSERT_TRUE(camera);
    const auto pixel = camera->Project(c.ray);
    ASSERT_TRUE(pixel) << c.name;
    EXPECT_LT((*pixel - Eigen::Vector2d(511.5, 511.5) - c.offset_px).norm(), 1e-9) << c.name;
  }
}

TEST(DoughnutCamera, SeesNothingOutsideTheRing) {
  const auto camera = DoughnutCamera::Create(TestDoughnut());
  ASSERT_TRUE(camera);
  EXPECT_FALSE(camera->Unproject({511.5 + 119.9, 511.5}));
  EXPECT_TRUE(camera->Unproject({511.5 + 120.1, 511.5}));
  EXPECT_FALSE(camera->Unproject({511.5, 511.5 + 500.1}));
  EXPECT_FALSE(camera->Project({1, 0, 0}));   // up
  EXPECT_FALSE(camera->Project({-1, 0, 0}));  // down
  EXPECT_FALSE(camera->Project({0, 0, 0}));
  const double nan = std::nan("");
  EXPECT_FALSE(camera->Project({nan, 0, 1}));
  EXPECT_FALSE(camera->Unproject({nan, 0}));
}

TEST(DoughnutCamera, EitherCircleMayBeTheUpperOne) {
  DoughnutParameters p = TestDoughnut();
  std::swap(p.phi_top_deg, p.phi_bottom_deg);     // a mirror over an upward camera
  p.l_base_px = p.l_in_px + 380.0 * 50.0 / 80.0;  // the inner circle shows -50 deg
  const auto camera = DoughnutCamera::Create(p);
  ASSERT_TRUE(camera) << camera.error().message;
  EXPECT_NEAR(camera->Elevations().top_rad, 30 * core::kRadFromDeg, 1e-12);
  EXPECT_NEAR(camera->Elevations().bottom_rad, -50 * core::kRadFromDeg, 1e-12);
  EXPECT_NEAR(camera->Unproject({511.5 + 499.9, 511.5})->x(), std::sin(30 * core::kRadFromDeg),
              1e-3);
}

// libjpeg's reduced picture: pixel (u, v) covers 8 / eighths source pixels.
TEST(DoughnutCamera, ScaledSeesTheSameRays) {
  const DoughnutParameters p = TestDoughnut();
  const auto full = DoughnutCamera::Create(p);
  for (int eighths = 1; eighths <= 8; ++eighths) {
    const auto small = DoughnutCamera::Create(p.Scaled(eighths));
    ASSERT_TRUE(small);
    EXPECT_EQ(small->width_px(), 128 * eighths);
    const double scale = eighths / 8.0;
    const Eigen::Vector2d pixel(700.25, 333.5);
    const auto ray = full->Unproject(pixel);
    ASSERT_TRUE(ray);
    const Eigen::Vector2d expected =
        (pixel + Eigen::Vector2d(0.5, 0.5)) * scale - Eigen::Vector2d(0.5, 0.5);
    EXPECT_LT((*small->Project(*ray) - expected).norm(), 1e-9);
  }
}

TEST(DoughnutCamera, ResizedSeesTheSameRaysInUnequalScales) {
  const DoughnutParameters p = TestDoughnut();
  const auto full = DoughnutCamera::Create(p);
  const auto other = DoughnutCamera::Create(p.Resized(2048, 1536));
  ASSERT_TRUE(other);
  const Eigen::Vector2d pixel(700.25, 333.5);
  const Eigen::Vector2d expected(2.0 * 700.75 - 0.5, 1.5 * 334.0 - 0.5);
  EXPECT_LT((*other->Project(*full->Unproject(pixel)) - expected).norm(), 1e-9);
}

TEST(DoughnutCamera, RefusesWhatCannotBe) {
  struct Case {
    const char* expected_in_message;
    void (*spoil)(DoughnutParameters&);
  };
  const Case cases[] = {
      {"at least 2 x 2", [](DoughnutParameters& p) { p.width_px = 0; }},
      {"l_in_px < l_out_px", [](DoughnutParameters& p) { p.l_out_px = 100; }},
      {"l_in_px < l_out_px", [](DoughnutParameters& p) { p.l_in_px = -1; }},
      {"l_base_px = 262.5 would fit", [](DoughnutParameters& p) { p.l_base_px = 290; }},
      {"two elevations", [](DoughnutParameters& p) { p.phi_top_deg = p.phi_bottom_deg; }},
      {"finite", [](DoughnutParameters& p) { p.center_u_px = std::nan(""); }},
      {"v_scale", [](DoughnutParameters& p) { p.v_scale = 0; }},
  };
  for (const Case& c : cases) {
    DoughnutParameters p = TestDoughnut();
    c.spoil(p);
    const auto camera = DoughnutCamera::Create(p);
    ASSERT_FALSE(camera) << c.expected_in_message;
    EXPECT_EQ(camera.error().code, core::ErrorCode::kInvalidArgument);
    EXPECT_NE(camera.error().message.find(c.expected_in_message), std::string::npos)
        << camera.error().message;
  }
}

TEST(DoughnutCamera, CorrectionKeepsCirclesAndHorizonAndBendsBetween) {
  const DoughnutParameters p = CorrectedDoughnut(TestDoughnut());
  const auto camera = DoughnutCamera::Create(p);
  ASSERT_TRUE(camera) << camera.error().message;
  const auto elevation_deg = [&](double r_px) {
    const auto ray = camera->Unproject({p.center_u_px + r_px, p.center_v_px});
    return ray ? std::asin(ray->x()) * core::kDegFromRad : 1e9;
  };
  EXPECT_NEAR(elevation_deg(p.l_in_px), p.phi_top_deg, 1e-9);
  EXPECT_NEAR(elevation_deg(p.l_base_px), 0.0, 1e-9);
  EXPECT_NEAR(elevation_deg(p.l_out_px), p.phi_bottom_deg, 1e-9);
  // P(a) = a + k1 a^3 + k2 a^5 + k3 a^7 with a = 90 deg - elevation is linear in the radius.
  const OddPolynomial unit{p.correction};
  const auto P = [&](double r_px) {
    return unit.Value((90.0 - elevation_deg(r_px)) * core::kRadFromDeg);
  };
  const double slope = (P(400.0) - P(200.0)) / 200.0;
  EXPECT_NEAR((P(300.0) - P(200.0)) / 100.0, slope, 1e-12);
  EXPECT_GT(std::abs(elevation_deg(300.0) - 0.5 * (elevation_deg(200.0) + elevation_deg(400.0))),
            0.1);
}

TEST(DoughnutCamera, RefusesACorrectionThatFolds) {
  DoughnutParameters p = TestDoughnut();
  p.correction = {-0.5, 0.0, 0.0, 0.0};
  EXPECT_FALSE(DoughnutCamera::Create(p));
}

}  // namespace
}  // namespace kawara::vision
