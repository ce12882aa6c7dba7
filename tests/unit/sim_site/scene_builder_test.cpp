#include "sim/site/scene_builder.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <set>

#include "committed_sites.hpp"
#include "sim/site/solid_builder.hpp"

namespace kawara::sim {
namespace {

std::uint64_t Hash(std::uint64_t hash, const void* bytes, std::size_t size) {
  const auto* p = static_cast<const unsigned char*>(bytes);
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ p[i]) * 0x100000001b3ULL;
  return hash;
}

/// Over everything the meshes of one object hold.
std::uint64_t HashOf(const Scene& scene, std::uint32_t object) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const Mesh& mesh : scene.meshes) {
    if (mesh.object != object) continue;
    hash = Hash(hash, mesh.vertices_m.data(), mesh.vertices_m.size() * sizeof(mesh.vertices_m[0]));
    hash = Hash(hash, mesh.uv_m.data(), mesh.uv_m.size() * sizeof(mesh.uv_m[0]));
    hash = Hash(hash, mesh.triangles.data(), mesh.triangles.size() * sizeof(mesh.triangles[0]));
    const Material& m = scene.materials[mesh.material];
    hash = Hash(hash, m.base_rgb.data(), sizeof m.base_rgb);
    hash = Hash(hash, m.second_rgb.data(), sizeof m.second_rgb);
    hash = Hash(hash, &m.seed, sizeof m.seed);
  }
  return hash;
}

std::map<std::string, std::uint64_t> HashesByName(const Scene& scene) {
  std::map<std::string, std::uint64_t> hashes;
  for (const SceneObject& object : scene.objects) hashes[object.name] = HashOf(scene, object.id);
  return hashes;
}

class CommittedSite : public testing::TestWithParam<const char*> {
 protected:
  const SiteConfig& site_ = Built(GetParam()).site;
  const Scene& before_ = Built(GetParam()).before;
  const Scene& after_ = Built(GetParam()).after;
};
INSTANTIATE_TEST_SUITE_P(All, CommittedSite, testing::ValuesIn(kCommittedSites));

TEST_P(CommittedSite, StaysWithinTheTriangleBudget) {
  std::size_t triangles = 0;
  for (const Mesh& mesh : after_.meshes) triangles += mesh.triangles.size();
  RecordProperty("triangles", static_cast<int>(triangles));
  EXPECT_GT(triangles, 50'000U);
  EXPECT_LT(triangles, 2'000'000U);
}

TEST_P(CommittedSite, MeshesAreWellFormed) {
  for (const Mesh& mesh : after_.meshes) {
    ASSERT_EQ(mesh.vertices_m.size(), mesh.uv_m.size());
    ASSERT_LT(mesh.material, after_.materials.size());
    ASSERT_FALSE(mesh.triangles.empty());
    const auto in_range = [&mesh](const std::array<std::uint32_t, 3>& t) {
      return std::max({t[0], t[1], t[2]}) < mesh.vertices_m.size();
    };
    const auto finite = [](const auto& v) { return v.allFinite(); };
    ASSERT_TRUE(std::all_of(mesh.triangles.begin(), mesh.triangles.end(), in_range));
    ASSERT_TRUE(std::all_of(mesh.vertices_m.begin(), mesh.vertices_m.end(), finite));
    ASSERT_TRUE(std::all_of(mesh.uv_m.begin(), mesh.uv_m.end(), finite));
  }
}

TEST_P(CommittedSite, NoTriangleIsDegenerate) {
  constexpr float kLeast_m2 = 1e-9F;
  for (const Mesh& mesh : after_.meshes) {
    const auto area_m2 = [&mesh](const std::array<std::uint32_t, 3>& t) {
      const Eigen::Vector3f& a = mesh.vertices_m[t[0]];
      return (mesh.vertices_m[t[1]] - a).cross(mesh.vertices_m[t[2]] - a).norm() / 2.0F;
    };
    const auto flat = std::find_if(mesh.triangles.begin(), mesh.triangles.end(),
                                   [&](const auto& t) { return !(area_m2(t) > kLeast_m2); });
    ASSERT_EQ(flat, mesh.triangles.end())
        << "object " << mesh.object << " at " << mesh.vertices_m[(*flat)[0]].transpose();
  }
}

TEST_P(CommittedSite, TextureCoordinatesAreMetresAlongTheSurface) {
  // The share of edges whose texture length is their true length: all plane faces; cones and the
  // slopes of the ground come close.
  std::size_t edges = 0, true_edges = 0;
  for (const Mesh& mesh : after_.meshes) {
    for (const auto& t : mesh.triangles) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t p = t[i], q = t[(i + 1) % 3];
        const float length = (mesh.vertices_m[p] - mesh.vertices_m[q]).norm();
        const float texture = (mesh.uv_m[p] - mesh.uv_m[q]).norm();
        ++edges;
        if (std::abs(texture - length) < 0.10F * length + 1e-4F) ++true_edges;
      }
    }
  }
  EXPECT_GT(static_cast<double>(true_edges) / static_cast<double>(edges), 0.85);
}

TEST_P(CommittedSite, EveryMeshBelongsToAnObjectAndEveryObjectHasAMesh) {
  std::set<std::uint32_t> of_meshes, of_objects;
  for (const Mesh& mesh : after_.meshes) of_meshes.insert(mesh.object);
  for (const SceneObject& object : after_.objects) of_objects.insert(object.id);
  EXPECT_EQ(of_meshes, of_objects);
}

TEST_P(CommittedSite, IdsAscendFromOneAndNamesAreUnique) {
  std::set<std::string> names;
  std::uint32_t last = 0;
  for (const SceneObject& object : after_.objects) {
    EXPECT_GT(object.id, last);
    last = object.id;
    EXPECT_TRUE(names.insert(object.name).second) << object.name;
  }
  EXPECT_EQ(after_.objects.front().id, 1U);
}

TEST_P(CommittedSite, BoxesHoldAllVerticesAndAreTight) {
  constexpr double kRound_m = 1e-3;
  std::map<std::uint32_t, const SceneObject*> objects;
  for (const SceneObject& object : after_.objects) objects[object.id] = &object;
  std::map<std::uint32_t, Eigen::AlignedBox3d> extents;  // in each box's own axes
  for (const Mesh& mesh : after_.meshes) {
    const UprightBox& box = objects.at(mesh.object)->box;
    const Frame box_from_enu = StandingFrame(box.centre_enu_m.x(), box.centre_enu_m.y(),
                                             box.centre_enu_m.z(), box.heading_rad)
                                   .inverse();
    for (const Eigen::Vector3f& v : mesh.vertices_m)
      extents[mesh.object].extend(
          Eigen::Vector3d(box_from_enu * Eigen::Vector3d(v.cast<double>())));
  }
  for (const auto& [id, extent] : extents) {
    const Eigen::Vector3d half = objects.at(id)->box.size_m / 2.0;
    EXPECT_TRUE(extent.max().isApprox(half, 1e-4) || (extent.max() - half).norm() < kRound_m)
        << objects.at(id)->name;
    EXPECT_TRUE(extent.min().isApprox(-half, 1e-4) || (extent.min() + half).norm() < kRound_m)
        << objects.at(id)->name;
  }
}

TEST_P(CommittedSite, ThingsAreClosedAndFaceOutwards) {
  // A closed surface has no net area in any direction, and with its faces outwards a positive
  // volume. The ground is no solid; hedges and trees wear single leaves.
  for (const SceneObject& object : after_.objects) {
    if (object.cls == ObjectClass::kGround || object.cls == ObjectClass::kKerb ||
        object.cls == ObjectClass::kTree)
      continue;
    Eigen::Vector3d net = Eigen::Vector3d::Zero();
    double area = 0.0, volume = 0.0;
    for (const Mesh& mesh : after_.meshes) {
      if (mesh.object != object.id) continue;
      if (after_.materials[mesh.material].pattern == Pattern::kLeaves) continue;
      for (const auto& t : mesh.triangles) {
        const auto at = [&](std::size_t i) {
          return Eigen::Vector3d(mesh.vertices_m[t[i]].cast<double>() - object.box.centre_enu_m);
        };
        const Eigen::Vector3d twice = (at(1) - at(0)).cross(at(2) - at(0));
        net += twice / 2.0;
        area += twice.norm() / 2.0;
        volume += at(0).dot(at(1).cross(at(2))) / 6.0;
      }
    }
    if (area == 0.0) continue;
    EXPECT_LT(net.norm(), 1e-4 * area) << object.name;
    EXPECT_GT(volume, 0.0) << object.name;
  }
}

TEST_P(CommittedSite, SameSeedSameBytes) {
  const Scene again = BuildScene(site_, SiteState::kAfter);
  EXPECT_EQ(HashesByName(after_), HashesByName(again));
}

TEST_P(CommittedSite, AnotherSeedAnotherSite) {
  SiteConfig other = site_;
  other.seed += 1;
  const auto mine = HashesByName(after_);
  const auto others = HashesByName(BuildScene(other, SiteState::kAfter));
  std::size_t shared = 0;
  for (const auto& [name, hash] : others) {
    const auto found = mine.find(name);
    if (found != mine.end() && found->second == hash) ++shared;
  }
  EXPECT_EQ(shared, 0U);
  EXPECT_NEAR(static_cast<double>(others.size()), static_cast<double>(mine.size()),
              0.4 * static_cast<double>(mine.size()));
}

TEST_P(CommittedSite, StatesDifferByWhatIsGoneAndNewOnly) {
  std::map<std::string, const SceneObject*> was, is;
  for (const SceneObject& object : before_.objects) was[object.name] = &object;
  for (const SceneObject& object : after_.objects) is[object.name] = &object;
  std::size_t added = 0;
  for (const auto& [name, object] : is) {
    if (was.contains(name)) {
      EXPECT_TRUE(object->in_reference) << name;
      EXPECT_EQ(object->id, was[name]->id);
      EXPECT_EQ(HashOf(after_, object->id), HashOf(before_, object->id)) << name;
    } else {
      EXPECT_FALSE(object->in_reference) << name;
      ++added;
    }
  }
  for (const auto& [name, object] : was) EXPECT_TRUE(object->in_reference) << name;
  EXPECT_GT(added, 0U);
}

TEST_P(CommittedSite, NothingNewStandsInTheVehiclesWay) {
  constexpr double kHalfVehicle_m = 0.4;
  const Terrain terrain(site_);
  const auto& points = site_.path.points;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Eigen::Vector2d from(points[i].at_m[0], points[i].at_m[1]);
    const Eigen::Vector2d to(points[i + 1].at_m[0], points[i + 1].at_m[1]);
    for (double s = 0; s < 1.0; s += 0.5 / (to - from).norm()) {
      const Eigen::Vector2d at = from + s * (to - from);
      for (const SceneObject& object : after_.objects) {
        if (object.cls == ObjectClass::kGround || object.cls == ObjectClass::kKerb ||
            object.cls == ObjectClass::kFence)
          continue;
        const Frame box_from_enu =
            StandingFrame(object.box.centre_enu_m.x(), object.box.centre_enu_m.y(), 0,
                          object.box.heading_rad)
                .inverse();
        const Eigen::Vector3d in = box_from_enu * Eigen::Vector3d(at.x(), at.y(), 0);
        const bool clear = std::abs(in.x()) > object.box.size_m.x() / 2 + kHalfVehicle_m ||
                           std::abs(in.y()) > object.box.size_m.y() / 2 + kHalfVehicle_m ||
                           object.box.centre_enu_m.z() - object.box.size_m.z() / 2 >
                               terrain.GroundHeight(at.x(), at.y()) + 2.0;
        ASSERT_TRUE(clear) << object.name << " at " << at.transpose();
      }
    }
  }
}

TEST(SceneBuilder, TruckAndWagonOfThePaperAreNewThingsOfTheFactoryRoad) {
  const Scene& after = Built("factory_road").after;
  for (const auto& [name, cls] :
       {std::pair{"truck", ObjectClass::kTruck}, std::pair{"wagon", ObjectClass::kCar}}) {
    const auto found = std::find_if(
        after.objects.begin(), after.objects.end(),
        [wanted = std::string(name)](const SceneObject& object) { return object.name == wanted; });
    ASSERT_NE(found, after.objects.end()) << name;
    EXPECT_EQ(found->cls, cls);
    EXPECT_FALSE(found->in_reference);
  }
}

}  // namespace
}  // namespace kawara::sim
