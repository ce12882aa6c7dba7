#include "sim/render/ray_scene.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "sim/dice.hpp"
#include "tests/unit/sim_render/test_scenes.hpp"

namespace kawara::sim {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

constexpr double kTolerance_m = 1e-3;  // the word: exact to 1 mm
const RayScene::Moment kStart{};

Vector3d RandomDirection(Dice& dice) {
  const double z = 2.0 * dice.Uniform() - 1.0;
  const double turn = 2.0 * core::kPi * dice.Uniform();
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(turn), r * std::sin(turn), z};
}

TEST(RayScene, AGroundIsMetWhereThePlaneIsAlsoAtGrazingAngles) {
  Scene scene;
  AddGround(scene, 500.0, 1, AddMaterial(scene));
  const RayScene rays = *RayScene::Create(scene);
  const Vector3d eye(123.4, -77.7, 1.513);
  for (const double down_deg : {80.0, 45.0, 10.0, 2.0, 0.7, 0.4}) {
    for (double around = 0.05; around < 6.28; around += 0.61) {
      const double down = down_deg * core::kRadFromDeg;
      const Vector3d d(std::cos(down) * std::cos(around), std::cos(down) * std::sin(around),
                       -std::sin(down));
      const RayHit hit = rays.Cast(eye, d, kStart);
      ASSERT_EQ(hit.object, 1U) << down_deg << " " << around;
      EXPECT_NEAR(hit.range_m, 1.513 / std::sin(down), 1e-6) << down_deg << " " << around;
    }
  }
}

TEST(RayScene, ABallIsMetWithinItsFacets) {
  // Facets lie up to (pi / 160)^2 / 4 = 0.1 mm inside the ball of 1 m.
  Scene scene;
  const Vector3d center(3.0, -2.0, 1.0);
  AddSphere(scene, center, 1.0, 160, 1, AddMaterial(scene));
  const RayScene rays = *RayScene::Create(scene);
  Dice dice(4);
  for (int i = 0; i < 3000; ++i) {
    const Vector3d eye = center + 5.0 * RandomDirection(dice);
    const Vector3d d = (center + 0.8 * RandomDirection(dice) - eye).normalized();
    const Vector3d to = center - eye;
    const double closest = to.dot(d);
    const double inside = 1.0 - (to.squaredNorm() - closest * closest);
    if (inside < 0.05) continue;  // the limb: a facet's depth becomes any length along the ray
    const RayHit hit = rays.Cast(eye, d, kStart);
    ASSERT_TRUE(hit.hit());
    EXPECT_NEAR(hit.range_m, closest - std::sqrt(inside), kTolerance_m);
    const Vector3d normal = (eye + hit.range_m * d - center).normalized();
    EXPECT_GT(hit.normal_enu.cast<double>().dot(normal), 0.9999);
  }
}

TEST(RayScene, ABoxTellsRangeFaceAndPlaceOnTheFace) {
  Scene scene;
  AddBox(scene, {2, -1, 0}, {4, 1, 3}, 7, AddMaterial(scene));
  const RayScene rays = *RayScene::Create(scene);
  struct Case {
    Vector3d eye, direction;
    double range_m;
    Eigen::Vector3f normal;
  };
  const std::vector<Case> cases = {
      {{0, 0.25, 1}, {1, 0, 0}, 2.0, {-1, 0, 0}},
      {{7, 0.25, 1}, {-1, 0, 0}, 3.0, {1, 0, 0}},
      {{3, 5, 1}, {0, -1, 0}, 4.0, {0, 1, 0}},
      {{3, 0.5, 9}, {0, 0, -1}, 6.0, {0, 0, 1}},
      {{0, 0, 1}, {1, 0.25, 0}, 2.0 * std::sqrt(1.0625), {-1, 0, 0}},
  };
  for (const Case& c : cases) {
    const RayHit hit = rays.Cast(c.eye, c.direction, kStart);
    EXPECT_EQ(hit.object, 7U);
    EXPECT_NEAR(hit.range_m, c.range_m, 1e-6);
    EXPECT_LT((hit.normal_enu - c.normal).norm(), 1e-6F);
  }
  EXPECT_FALSE(rays.Cast({0, 0, 5}, {1, 0, 0}, kStart).hit());
  EXPECT_TRUE(std::isinf(rays.Cast({0, 0, 5}, {1, 0, 0}, kStart).range_m));
}

TEST(RayScene, UvAreMetresAlongTheSurface) {
  Scene scene;
  AddGround(scene, 10.0, 1, AddMaterial(scene));
  const RayScene rays = *RayScene::Create(scene);
  const RayHit hit = rays.Cast({1.25, -3.5, 2}, {0, 0, -1}, kStart);
  EXPECT_NEAR(hit.uv_m.x(), 11.25F, 1e-5F);
  EXPECT_NEAR(hit.uv_m.y(), 6.5F, 1e-5F);
  EXPECT_LT((hit.gradient_u - Eigen::Vector3f(1, 0, 0)).norm(), 1e-6F);
  EXPECT_LT((hit.gradient_v - Eigen::Vector3f(0, 1, 0)).norm(), 1e-6F);
}

TEST(RayScene, ThingsAreThereFromTheirBeginToTheirEnd) {
  Scene scene;
  AddBox(scene, {2, -1, 0}, {3, 1, 3}, 1, AddMaterial(scene));
  AddBox(scene, {5, -1, 0}, {6, 1, 3}, 2, 0);
  AddObject(scene, 1).begin_s = 10.0;
  scene.objects.back().end_s = 20.0;
  AddObject(scene, 2);
  const RayScene rays = *RayScene::Create(scene);
  for (const auto& [time_s, object] : std::vector<std::pair<double, std::uint32_t>>{
           {-1e9, 2U}, {9.999, 2U}, {10.0, 1U}, {19.999, 1U}, {20.0, 2U}, {1e9, 2U}}) {
    EXPECT_EQ(rays.Cast({0, 0, 1}, {1, 0, 0}, rays.MomentAt(time_s)).object, object) << time_s;
  }
}

TEST(RayScene, AHundredChangesAreMoreThanAMaskHasBits) {
  Scene scene;
  AddMaterial(scene);
  for (std::uint32_t id = 1; id <= 100; ++id) {
    AddBox(scene, {2, -1, 0}, {3, 1, 3}, id, 0);
    AddObject(scene, id).begin_s = id;
    scene.objects.back().end_s = id + 0.5;
  }
  const RayScene rays = *RayScene::Create(scene);
  for (std::uint32_t id = 1; id <= 100; ++id) {
    EXPECT_EQ(rays.Cast({0, 0, 1}, {1, 0, 0}, rays.MomentAt(id + 0.25)).object, id);
    EXPECT_EQ(rays.Cast({0, 0, 1}, {1, 0, 0}, rays.MomentAt(id + 0.75)).object, 0U);
  }
}

TEST(RayScene, BlockedIsWhatCastWouldMeet) {
  const RayScene rays = *RayScene::Create(CornerScene());
  Dice dice(9);
  int blocked = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d eye(4.0 * dice.Uniform(), 4.0 * dice.Uniform(), 1.2 + dice.Uniform());
    const Vector3d d = RandomDirection(dice);
    const double range = rays.Cast(eye, d, kStart).range_m;
    EXPECT_EQ(rays.Blocked(eye, d, 1e6, kStart), std::isfinite(range));
    if (!std::isfinite(range)) continue;
    ++blocked;
    EXPECT_FALSE(rays.Blocked(eye, d, range - 0.01, kStart));
    EXPECT_TRUE(rays.Blocked(eye, d, range + 0.01, kStart));
  }
  EXPECT_GT(blocked, 500);
}

TEST(RayScene, ManyThreadsSeeTheSame) {
  const RayScene rays = *RayScene::Create(CornerScene());
  const auto look = [&] {
    Dice dice(5);
    double sum = 0.0;
    for (int i = 0; i < 3000; ++i) {
      const RayHit hit = rays.Cast({0, 0, 1.5}, RandomDirection(dice), kStart);
      if (hit.hit()) sum += hit.range_m * hit.object;
    }
    return sum;
  };
  const double alone = look();
  std::vector<double> sums(4);
  std::vector<std::thread> threads;
  for (double& sum : sums) threads.emplace_back([&] { sum = look(); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(sums, testing::Each(alone));
}

TEST(RayScene, AnEmptySceneIsAllSky) {
  const RayScene rays = *RayScene::Create(Scene{});
  EXPECT_FALSE(rays.Cast({0, 0, 1}, {0, 0, -1}, kStart).hit());
}

TEST(RayScene, MeshesThatCannotBeAreRefusedByNumber) {
  Scene good;
  AddGround(good, 1.0, 1, AddMaterial(good));
  const auto refused = [&](auto spoil) {
    Scene scene = good;
    spoil(scene.meshes[0]);
    const auto made = RayScene::Create(scene);
    return made ? std::string("accepted") : made.error().message;
  };
  EXPECT_THAT(refused([](Mesh& m) { m.object = 0; }), HasSubstr("mesh 0 belongs to object 0"));
  EXPECT_THAT(refused([](Mesh& m) { m.material = 1; }), HasSubstr("material 1 of 1"));
  EXPECT_THAT(refused([](Mesh& m) { m.uv_m.pop_back(); }), HasSubstr("4 vertices and 3 uv"));
  EXPECT_THAT(refused([](Mesh& m) { m.triangles[0][2] = 4; }), HasSubstr("does not exist"));
  EXPECT_THAT(refused([](Mesh& m) { m.vertices_m[0].x() = std::nanf(""); }),
              HasSubstr("not finite"));
}

}  // namespace
}  // namespace kawara::sim
