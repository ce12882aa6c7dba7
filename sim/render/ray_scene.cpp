#include "sim/render/ray_scene.hpp"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>
#include <unordered_map>

#include "core/check.hpp"

namespace kawara::sim {
namespace {

/// Embree masks have 32 bits: one for each span of time between two changes.
constexpr std::size_t kSpansAStage = 32;
/// A plane met at less than this sine is left to Embree: the division would only amplify rounding.
constexpr double kMinGrazingSine = 1e-7;
/// Embree and the exact plane may differ by this share of the range (and a millimetre); more means
/// that the ray ran along the triangle's edge, where Embree's word counts.
constexpr double kMaxRelativeDifference = 1e-3;

struct DeviceDeleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceDeleter>;
using EmbreeScene = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneDeleter>;

/// All a hit needs, side by side in memory.
struct Triangle {
  Eigen::Vector3d normal;  ///< unit
  Eigen::Vector3f corner;
  Eigen::Vector3f gradient_u, gradient_v;
  Eigen::Vector2f uv;  ///< at the corner
  std::uint32_t object;
  std::uint32_t material;
};

/// Triangles that exist during the same spans: one Embree geometry a stage.
struct Group {
  std::vector<bool> spans;
  std::vector<Eigen::Vector3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> corners;
  std::vector<std::uint32_t> triangle;  ///< corners[i] is Impl::triangles[triangle[i]]
};

core::Expected<void> CheckMesh(const Scene& scene, std::size_t number) {
  const Mesh& mesh = scene.meshes[number];
  std::ostringstream what;
  if (mesh.object == 0) {
    what << "belongs to object 0, which is the sky";
  } else if (mesh.material >= scene.materials.size()) {
    what << "has material " << mesh.material << " of " << scene.materials.size();
  } else if (mesh.uv_m.size() != mesh.vertices_m.size()) {
    what << "has " << mesh.vertices_m.size() << " vertices and " << mesh.uv_m.size() << " uv";
  } else if (!std::all_of(mesh.vertices_m.begin(), mesh.vertices_m.end(),
                          [](const auto& v) { return v.allFinite(); }) ||
             !std::all_of(mesh.uv_m.begin(), mesh.uv_m.end(),
                          [](const auto& uv) { return uv.allFinite(); })) {
    what << "has a vertex that is not finite";
  } else if (!std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
               return std::max({t[0], t[1], t[2]}) < mesh.vertices_m.size();
             })) {
    what << "has a triangle whose vertex does not exist";
  } else {
    return {};
  }
  return core::Fail(core::ErrorCode::kInvalidArgument,
                    "scene: mesh " + std::to_string(number) + " " + what.str());
}

/// u and v as linear functions of the place: the gradient lies in the triangle's plane.
bool Gradient(const Eigen::Vector3d& e1, const Eigen::Vector3d& e2, double d1, double d2,
              Eigen::Vector3f& gradient) {
  const double a = e1.dot(e1);
  const double b = e1.dot(e2);
  const double c = e2.dot(e2);
  const double determinant = a * c - b * b;
  if (!(determinant > 0.0)) return false;
  gradient =
      (((d1 * c - d2 * b) * e1 + (d2 * a - d1 * b) * e2) / determinant).template cast<float>();
  return true;
}

bool MakeTriangle(const Mesh& mesh, const std::array<std::uint32_t, 3>& corners, Triangle& out) {
  const Eigen::Vector3d p = mesh.vertices_m[corners[0]].cast<double>();
  const Eigen::Vector3d e1 = mesh.vertices_m[corners[1]].cast<double>() - p;
  const Eigen::Vector3d e2 = mesh.vertices_m[corners[2]].cast<double>() - p;
  const Eigen::Vector3d across = e1.cross(e2);
  const double area = across.norm();
  if (!(area > 0.0)) return false;
  out.normal = across / area;
  out.corner = mesh.vertices_m[corners[0]];
  out.uv = mesh.uv_m[corners[0]];
  const Eigen::Vector2d d1 = (mesh.uv_m[corners[1]] - out.uv).cast<double>();
  const Eigen::Vector2d d2 = (mesh.uv_m[corners[2]] - out.uv).cast<double>();
  if (!Gradient(e1, e2, d1.x(), d2.x(), out.gradient_u)) return false;
  if (!Gradient(e1, e2, d1.y(), d2.y(), out.gradient_v)) return false;
  out.object = mesh.object;
  out.material = mesh.material;
  return true;
}

}  // namespace

struct RayScene::Impl {
  Device device;
  std::vector<EmbreeScene> stages;
  std::vector<double> changes_s;  ///< ascending; span k ends at changes_s[k]
  std::vector<Triangle> triangles;
  std::vector<std::array<Eigen::Vector3f, 2>> edges;  ///< of a triangle, from its first corner
  std::vector<Group> groups;
  /// Of group g (Embree's geometry number), in `order`.
  std::vector<std::uint32_t> group_first;
  std::vector<std::uint32_t> order;
  std::vector<Material> materials;
  Sun sun;
  Eigen::Vector3f low = Eigen::Vector3f::Zero(), high = Eigen::Vector3f::Zero();

  std::uint32_t TriangleOf(unsigned geometry, unsigned primitive) const {
    return order[group_first[geometry] + primitive];
  }
  void AddMeshes(const Scene& scene);
  void Commit();
};

void RayScene::Impl::AddMeshes(const Scene& scene) {
  std::unordered_map<std::uint32_t, const SceneObject*> objects;
  for (const SceneObject& object : scene.objects) {
    objects[object.id] = &object;
    if (object.begin_s) changes_s.push_back(*object.begin_s);
    if (object.end_s) changes_s.push_back(*object.end_s);
  }
  std::sort(changes_s.begin(), changes_s.end());
  changes_s.erase(std::unique(changes_s.begin(), changes_s.end()), changes_s.end());
  const std::size_t spans = changes_s.size() + 1;

  std::map<std::vector<bool>, std::size_t> group_of;
  Eigen::AlignedBox3f box;
  for (const Mesh& mesh : scene.meshes) {
    std::vector<bool> alive(spans, true);
    if (const auto found = objects.find(mesh.object); found != objects.end()) {
      for (std::size_t k = 0; k < spans; ++k) {
        const double begin = k == 0 ? -std::numeric_limits<double>::infinity() : changes_s[k - 1];
        if (found->second->begin_s && begin < *found->second->begin_s) alive[k] = false;
        if (found->second->end_s && begin >= *found->second->end_s) alive[k] = false;
      }
    }
    const auto [place, fresh] = group_of.try_emplace(alive, groups.size());
    if (fresh) {
      groups.emplace_back();
      groups.back().spans = alive;
    }
    Group& group = groups[place->second];
    const auto first = static_cast<std::uint32_t>(group.vertices.size());
    for (const auto& corners : mesh.triangles) {
      Triangle triangle;
      if (!MakeTriangle(mesh, corners, triangle)) continue;
      group.triangle.push_back(static_cast<std::uint32_t>(triangles.size()));
      group.corners.push_back({first + corners[0], first + corners[1], first + corners[2]});
      triangles.push_back(triangle);
      edges.push_back({mesh.vertices_m[corners[1]] - triangle.corner,
                       mesh.vertices_m[corners[2]] - triangle.corner});
      for (const std::uint32_t c : corners) box.extend(mesh.vertices_m[c]);
    }
    group.vertices.insert(group.vertices.end(), mesh.vertices_m.begin(), mesh.vertices_m.end());
  }
  if (!box.isEmpty()) {
    low = box.min();
    high = box.max();
  }
}

// One Embree scene for 32 spans of time; a geometry's mask says in which of them it stands there.
void RayScene::Impl::Commit() {
  for (const Group& group : groups) {
    group_first.push_back(static_cast<std::uint32_t>(order.size()));
    order.insert(order.end(), group.triangle.begin(), group.triangle.end());
  }
  const std::size_t spans = changes_s.size() + 1;
  for (std::size_t first_span = 0; first_span < spans; first_span += kSpansAStage) {
    const EmbreeScene::pointer scene = rtcNewScene(device.get());
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Group& group = groups[g];
      std::uint32_t mask = 0;
      for (std::size_t k = 0; k < kSpansAStage && first_span + k < spans; ++k) {
        if (group.spans[first_span + k]) mask |= 1U << k;
      }
      if (mask == 0 || group.corners.empty()) continue;
      RTCGeometry geometry = rtcNewGeometry(device.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
      auto* vertices = static_cast<float*>(
          rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                  3 * sizeof(float), group.vertices.size()));
      auto* indices = static_cast<std::uint32_t*>(
          rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                  3 * sizeof(std::uint32_t), group.corners.size()));
      CORE_CHECK(vertices != nullptr && indices != nullptr);
      for (const Eigen::Vector3f& v : group.vertices) {
        for (int axis = 0; axis < 3; ++axis) *vertices++ = v[axis];
      }
      for (const auto& corners : group.corners) indices = std::copy_n(corners.begin(), 3, indices);
      rtcSetGeometryMask(geometry, mask);
      rtcCommitGeometry(geometry);
      rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(g));
      rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);
    stages.emplace_back(scene);
  }
  for (Group& group : groups) group = {};  // Embree has its own copy
}

core::Expected<RayScene> RayScene::Create(const Scene& scene) {
  for (std::size_t number = 0; number < scene.meshes.size(); ++number) {
    if (auto good = CheckMesh(scene, number); !good) return tl::unexpected(good.error());
  }
  auto impl = std::make_shared<Impl>();
  impl->device.reset(rtcNewDevice(nullptr));
  if (!impl->device) {
    return core::Fail(core::ErrorCode::kUnavailable,
                      "Embree: no device (error " +
                          std::to_string(static_cast<int>(rtcGetDeviceError(nullptr))) + ")");
  }
  impl->materials = scene.materials;
  impl->sun = scene.sun;
  impl->AddMeshes(scene);
  impl->Commit();
  if (const RTCError error = rtcGetDeviceError(impl->device.get()); error != RTC_ERROR_NONE) {
    return core::Fail(
        core::ErrorCode::kUnavailable,
        "Embree: error " + std::to_string(static_cast<int>(error)) + " while building the scene");
  }
  return RayScene(std::move(impl));
}

RayScene::RayScene(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

RayScene::Moment RayScene::MomentAt(double time_s) const {
  const auto& changes = impl_->changes_s;
  const auto span = static_cast<std::size_t>(
      std::upper_bound(changes.begin(), changes.end(), time_s) - changes.begin());
  return {static_cast<std::uint32_t>(span / kSpansAStage), 1U << (span % kSpansAStage)};
}

void RayPacket::Set(int lane, const Eigen::Vector3d& origin_enu_m,
                    const Eigen::Vector3d& direction_enu, float lane_max_range_m) {
  const auto i = static_cast<std::size_t>(lane);
  origin_x[i] = static_cast<float>(origin_enu_m.x());
  origin_y[i] = static_cast<float>(origin_enu_m.y());
  origin_z[i] = static_cast<float>(origin_enu_m.z());
  direction_x[i] = static_cast<float>(direction_enu.x());
  direction_y[i] = static_cast<float>(direction_enu.y());
  direction_z[i] = static_cast<float>(direction_enu.z());
  max_range_m[i] = lane_max_range_m;
  lanes |= 1U << lane;
}

namespace {

void FillRays(const RayPacket& rays, std::uint32_t mask, RTCRay16& out,
              std::array<int, kPacketRays>& valid) {
  std::copy_n(rays.origin_x.data(), kPacketRays, out.org_x);
  std::copy_n(rays.origin_y.data(), kPacketRays, out.org_y);
  std::copy_n(rays.origin_z.data(), kPacketRays, out.org_z);
  std::copy_n(rays.direction_x.data(), kPacketRays, out.dir_x);
  std::copy_n(rays.direction_y.data(), kPacketRays, out.dir_y);
  std::copy_n(rays.direction_z.data(), kPacketRays, out.dir_z);
  std::copy_n(rays.max_range_m.data(), kPacketRays, out.tfar);
  std::fill_n(out.tnear, kPacketRays, 0.0F);
  std::fill_n(out.time, kPacketRays, 0.0F);
  std::fill_n(out.mask, kPacketRays, mask);
  std::fill_n(out.flags, kPacketRays, 0U);
  for (int i = 0; i < kPacketRays; ++i) {
    out.id[i] = static_cast<unsigned>(i);
    valid[static_cast<std::size_t>(i)] = (rays.lanes >> i & 1U) != 0 ? -1 : 0;
  }
}

}  // namespace

void RayScene::Intersect(const RayPacket& rays, const Moment& moment, PacketHits& hits) const {
  RTCRayHit16 query;
  alignas(64) std::array<int, kPacketRays> valid;
  FillRays(rays, moment.mask, query.ray, valid);
  std::fill_n(query.hit.geomID, kPacketRays, RTC_INVALID_GEOMETRY_ID);
  std::fill_n(query.hit.instID[0], kPacketRays, RTC_INVALID_GEOMETRY_ID);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid.data(), impl_->stages[moment.stage].get(), &context, &query);
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    const bool hit = valid[i] != 0 && query.hit.geomID[i] != RTC_INVALID_GEOMETRY_ID;
    hits.triangle[i] =
        hit ? impl_->TriangleOf(query.hit.geomID[i], query.hit.primID[i]) : kNoTriangle;
    hits.range_m[i] = query.ray.tfar[i];
  }
}

std::uint32_t RayScene::Blocked(const RayPacket& rays, const Moment& moment) const {
  if (rays.lanes == 0) return 0;
  RTCRay16 query;
  alignas(64) std::array<int, kPacketRays> valid;
  FillRays(rays, moment.mask, query, valid);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcOccluded16(valid.data(), impl_->stages[moment.stage].get(), &context, &query);
  std::uint32_t blocked = 0;
  for (std::size_t i = 0; i < kPacketRays; ++i) {
    if (valid[i] != 0 && query.tfar[i] < 0.0F) blocked |= 1U << i;
  }
  return blocked;
}

RayHit RayScene::Resolve(std::uint32_t number, float range_m, const Eigen::Vector3d& origin_enu_m,
                         const Eigen::Vector3d& direction_enu) const {
  const Triangle& triangle = impl_->triangles[number];
  const Eigen::Vector3d corner = triangle.corner.cast<double>();
  const double along = triangle.normal.dot(direction_enu);
  RayHit hit;
  hit.range_m = static_cast<double>(range_m);
  if (std::abs(along) > kMinGrazingSine) {
    const double exact = triangle.normal.dot(corner - origin_enu_m) / along;
    if (std::abs(exact - hit.range_m) < 1e-3 + kMaxRelativeDifference * hit.range_m) {
      hit.range_m = std::max(exact, 0.0);
    }
  }
  hit.object = triangle.object;
  hit.material = triangle.material;
  hit.normal_enu = triangle.normal.cast<float>();
  hit.gradient_u = triangle.gradient_u;
  hit.gradient_v = triangle.gradient_v;
  const Eigen::Vector3f from_corner =
      (origin_enu_m + hit.range_m * direction_enu - corner).cast<float>();
  hit.uv_m = triangle.uv +
             Eigen::Vector2f(hit.gradient_u.dot(from_corner), hit.gradient_v.dot(from_corner));
  return hit;
}

namespace {

RTCRay SingleRay(const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
                 float max_range_m, std::uint32_t mask) {
  const Eigen::Vector3f from = origin_enu_m.cast<float>();
  const Eigen::Vector3f to = direction_enu.cast<float>();
  RTCRay ray{};
  ray.org_x = from.x();
  ray.org_y = from.y();
  ray.org_z = from.z();
  ray.dir_x = to.x();
  ray.dir_y = to.y();
  ray.dir_z = to.z();
  ray.tfar = max_range_m;
  ray.mask = mask;
  return ray;
}

}  // namespace

RayHit RayScene::Cast(const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
                      const Moment& moment) const {
  const Eigen::Vector3d unit = direction_enu.normalized();
  RTCRayHit query{};
  query.ray = SingleRay(origin_enu_m, unit, std::numeric_limits<float>::infinity(), moment.mask);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(impl_->stages[moment.stage].get(), &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  return Resolve(impl_->TriangleOf(query.hit.geomID, query.hit.primID), query.ray.tfar,
                 origin_enu_m, unit);
}

bool RayScene::Blocked(const Eigen::Vector3d& origin_enu_m, const Eigen::Vector3d& direction_enu,
                       double max_range_m, const Moment& moment) const {
  RTCRay ray = SingleRay(origin_enu_m, direction_enu.normalized(), static_cast<float>(max_range_m),
                         moment.mask);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->stages[moment.stage].get(), &context, &ray);
  return ray.tfar < 0.0F;
}

const std::vector<Material>& RayScene::materials() const { return impl_->materials; }
const Sun& RayScene::sun() const { return impl_->sun; }
std::size_t RayScene::triangle_count() const { return impl_->triangles.size(); }
std::array<Eigen::Vector3f, 3> RayScene::Corners(std::size_t number) const {
  const Eigen::Vector3f& corner = impl_->triangles[number].corner;
  return {corner, corner + impl_->edges[number][0], corner + impl_->edges[number][1]};
}
const Eigen::Vector3f& RayScene::low_enu_m() const { return impl_->low; }
const Eigen::Vector3f& RayScene::high_enu_m() const { return impl_->high; }

}  // namespace kawara::sim
