#include "sim/render/light_field.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/geodesy.hpp"
#include "sim/render/light_cache.hpp"
#include "sim/render/noise2.hpp"

namespace kawara::sim {
namespace {

constexpr std::size_t kMaxGridPlaces = 40'000'000;
constexpr int kRays = 64;
/// Share of a plate in the light on a surface that is left out.
constexpr float kLeastSquare = 1e-3F;
constexpr float kLightStep = 1.0F / 16384.0F;  // so up to 4: four times a white card in the open
/// What open ground throws back.
constexpr float kOpenGround = 0.2F;
/// A point whose rays meet more back sides than this share is inside something.
constexpr double kInsideShare = 0.25;
/// Where all points round a place are inside something (under a car), of the open sky's light.
constexpr float kBetweenSolids = 0.22F;
constexpr float kShadowOffset_m = 0.002F;
/// Light on what a ray meets is taken as this share of the open sky's (it is not measured again).
constexpr float kSecondHandSky = 0.6F;

/// Evenly spread over the sphere (Fibonacci spiral).
std::array<Eigen::Vector3d, kRays> SphereDirections() {
  std::array<Eigen::Vector3d, kRays> directions;
  for (int i = 0; i < kRays; ++i) {
    const double z = 1.0 - (2.0 * i + 1.0) / kRays;
    const double turn = i * core::kPi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    directions[static_cast<std::size_t>(i)] = {r * std::cos(turn), r * std::sin(turn), z};
  }
  return directions;
}

}  // namespace

LightField::LightField(const RayScene& scene, const SkyMap& sky,
                       const Eigen::AlignedBox3f& region_enu_m, double time_s,
                       const LightSettings& settings, std::uint64_t cache_key)
    : cell_m_(static_cast<float>(settings.cell_m)),
      open_sky_(Eigen::Array3f::Zero()),
      open_ground_(Eigen::Array3f::Zero()) {
  for (const Eigen::Vector3d& d : SphereDirections()) {
    sky_light_.push_back(sky.Radiance(d.cast<float>()));
    if (d.z() > 0.0) open_sky_ += 4.0F / kRays * static_cast<float>(d.z()) * sky_light_.back();
  }
  open_ground_ = kOpenGround * (open_sky_ + sky.sun_rgb() * std::max(sky.to_sun_enu().z(), 0.0F));
  if (region_enu_m.isEmpty()) return;
  const LightCache cache(settings.cache);
  if (const auto measured = cache.Load(cache_key); measured && Restore(*measured)) return;
  while (!PlacePoints(scene, region_enu_m,
                      static_cast<std::size_t>(std::max(settings.max_points, 64)))) {
    cell_m_ *= 1.25F;
  }
  per_cell_m_ = 1.0F / cell_m_;
  points_.resize(places_.size());
  const RayScene::Moment moment = scene.MomentAt(time_s);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, points_.size(), 256),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t n = range.begin(); n != range.end(); ++n) {
                        Measure(scene, sky, moment, n);
                      }
                    });
  cache.Save(cache_key, Measured());
}

namespace {

/// Before the points' places and plates in a file of measured light, as this machine has numbers.
struct MeasuredHead {
  float cell_m;
  float low_m[3];
  std::int32_t size[3];
  std::uint32_t points;
};

}  // namespace

std::string LightField::Measured() const {
  const MeasuredHead head{cell_m_,
                          {low_.x(), low_.y(), low_.z()},
                          {size_.x(), size_.y(), size_.z()},
                          static_cast<std::uint32_t>(points_.size())};
  std::string bytes(reinterpret_cast<const char*>(&head), sizeof head);
  bytes.reserve(sizeof head + points_.size() * (3 * sizeof(int) + sizeof(Point)));
  for (const Eigen::Vector3i& place : places_) {
    bytes.append(reinterpret_cast<const char*>(place.data()), 3 * sizeof(int));
  }
  for (const Point& point : points_) {
    bytes.append(reinterpret_cast<const char*>(point.plates.data()), sizeof point.plates);
    bytes.push_back(point.inside_solid ? 1 : 0);
  }
  return bytes;
}

bool LightField::Restore(const std::string& measured) {
  MeasuredHead head{};
  if (measured.size() < sizeof head) return false;
  std::memcpy(&head, measured.data(), sizeof head);
  constexpr std::size_t kPlateBytes = sizeof(Point::plates) + 1;
  const Eigen::Vector3i size(head.size[0], head.size[1], head.size[2]);
  if (!(head.cell_m > 0.0F) || (size.array() < 1).any() ||
      size.cast<double>().prod() > static_cast<double>(kMaxGridPlaces) ||
      measured.size() != sizeof head + head.points * (3 * sizeof(int) + kPlateBytes)) {
    return false;
  }
  std::vector<Eigen::Vector3i> places(head.points);
  const char* from = measured.data() + sizeof head;
  for (Eigen::Vector3i& place : places) {
    std::memcpy(place.data(), from, 3 * sizeof(int));
    from += 3 * sizeof(int);
    if ((place.array() < 0).any() || (place.array() >= size.array()).any()) return false;
  }
  cell_m_ = head.cell_m;
  per_cell_m_ = 1.0F / cell_m_;
  low_ = {head.low_m[0], head.low_m[1], head.low_m[2]};
  size_ = size;
  places_ = std::move(places);
  points_.resize(places_.size());
  point_at_.assign(static_cast<std::size_t>(size_.prod()), -1);
  for (std::size_t n = 0; n < points_.size(); ++n) {
    std::memcpy(points_[n].plates.data(), from, sizeof points_[n].plates);
    points_[n].inside_solid = from[sizeof points_[n].plates] != 0;
    from += kPlateBytes;
    point_at_[Index(places_[n].x(), places_[n].y(), places_[n].z())] = static_cast<std::int32_t>(n);
  }
  from_cache_ = true;
  return true;
}

// Points round every place At() will ask for: half a cell off the surface, on its outside.
bool LightField::PlacePoints(const RayScene& scene, const Eigen::AlignedBox3f& region,
                             std::size_t max_points) {
  low_ = region.min().array() - 2.0F * cell_m_;
  const Eigen::Vector3f extent = (region.max() - low_).array() + 2.0F * cell_m_;
  const Eigen::Vector3d cells = (extent / cell_m_).cast<double>().array().ceil() + 1.0;
  if (cells.prod() > static_cast<double>(kMaxGridPlaces)) return false;
  size_ = cells.cast<int>();
  point_at_.assign(static_cast<std::size_t>(size_.prod()), -1);
  places_.clear();
  const auto add_round = [&](const Eigen::Vector3f& place) {
    const Eigen::Vector3i cell = ((place - low_) / cell_m_).array().floor().cast<int>();
    if ((cell.array() < 0).any() || (cell.array() + 1 >= size_.array()).any()) return;
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3i at = cell + Eigen::Vector3i(corner & 1, corner >> 1 & 1, corner >> 2);
      std::int32_t& point = point_at_[Index(at.x(), at.y(), at.z())];
      if (point >= 0) continue;
      point = static_cast<std::int32_t>(places_.size());
      places_.push_back(at);
    }
  };
  const float step = 0.45F * cell_m_;
  for (std::size_t t = 0; t < scene.triangle_count(); ++t) {
    const auto corners = scene.Corners(t);
    Eigen::AlignedBox3f box;
    for (const Eigen::Vector3f& corner : corners) box.extend(corner);
    if (!box.intersects(region)) continue;
    const Eigen::Vector3f e1 = corners[1] - corners[0];
    const Eigen::Vector3f e2 = corners[2] - corners[0];
    const Eigen::Vector3f off = 0.5F * cell_m_ * e1.cross(e2).normalized();
    const int n1 = static_cast<int>(e1.norm() / step) + 1;
    const int n2 = static_cast<int>(e2.norm() / step) + 1;
    for (int a = 0; a <= n1; ++a) {
      const float s = static_cast<float>(a) / static_cast<float>(n1);
      for (int b = 0; b <= n2; ++b) {
        const float r = std::min(static_cast<float>(b) / static_cast<float>(n2), 1.0F - s);
        add_round(corners[0] + s * e1 + r * e2 + off);
        if (r >= 1.0F - s) break;
      }
      if (places_.size() > max_points) return false;
    }
  }
  return true;
}

void LightField::Measure(const RayScene& scene, const SkyMap& sky, const RayScene::Moment& moment,
                         std::size_t number) {
  static const std::array<Eigen::Vector3d, kRays> kDirections = SphereDirections();
  const Eigen::Vector3d from = (low_ + cell_m_ * places_[number].cast<float>()).cast<double>();
  std::array<Eigen::Array3f, 6> plates;
  plates.fill(Eigen::Array3f::Zero());
  int back_sides = 0;
  for (int first = 0; first < kRays; first += kPacketRays) {
    RayPacket rays;
    for (int lane = 0; lane < kPacketRays; ++lane) {
      rays.Set(lane, from,
               kDirections[static_cast<std::size_t>(first) + static_cast<std::size_t>(lane)]);
    }
    PacketHits hits;
    scene.Intersect(rays, moment, hits);
    std::array<RayHit, kPacketRays> met;
    RayPacket to_sun;
    for (int lane = 0; lane < kPacketRays; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      if (hits.triangle[l] == kNoTriangle) continue;
      const Eigen::Vector3d& d =
          kDirections[static_cast<std::size_t>(first) + static_cast<std::size_t>(lane)];
      met[l] = scene.Resolve(hits.triangle[l], hits.range_m[l], from, d);
      if (met[l].normal_enu.dot(d.cast<float>()) > 0.0F)
        ++back_sides;
      else if (met[l].normal_enu.dot(sky.to_sun_enu()) > 0.0F) {
        to_sun.Set(lane,
                   from + met[l].range_m * d + (kShadowOffset_m * met[l].normal_enu).cast<double>(),
                   sky.to_sun_enu().cast<double>());
      }
    }
    const std::uint32_t shaded = scene.Blocked(to_sun, moment);
    for (int lane = 0; lane < kPacketRays; ++lane) {
      const auto l = static_cast<std::size_t>(lane);
      const Eigen::Vector3f d =
          kDirections[static_cast<std::size_t>(first) + static_cast<std::size_t>(lane)]
              .cast<float>();
      Eigen::Array3f light;
      if (!met[l].hit()) {
        light = sky_light_[static_cast<std::size_t>(first) + l];
      } else {
        const auto& base = scene.materials()[met[l].material].base_rgb;
        light = kSecondHandSky * open_sky_ * (0.6F + 0.4F * met[l].normal_enu.z());
        if ((to_sun.lanes >> lane & 1U) != 0 && (shaded >> lane & 1U) == 0) {
          light += sky.sun_rgb() * met[l].normal_enu.dot(sky.to_sun_enu());
        }
        light *= Eigen::Array3f(base[0], base[1], base[2]);
      }
      for (int axis = 0; axis < 3; ++axis) {
        const auto plate = 2U * static_cast<std::size_t>(axis) + (d[axis] > 0.0F ? 0U : 1U);
        plates[plate] += 4.0F / kRays * std::abs(d[axis]) * light;
      }
    }
  }
  Point& point = points_[number];
  point.inside_solid = back_sides > kInsideShare * kRays;
  for (std::size_t plate = 0; plate < 6; ++plate) {
    for (std::size_t c = 0; c < 3; ++c) {
      const float steps = plates[plate][static_cast<Eigen::Index>(c)] / kLightStep + 0.5F;
      point.plates[4 * plate + c] = static_cast<std::uint16_t>(std::min(steps, 65535.0F));
    }
  }
}

void LightField::Unpack(const Eigen::Vector3i& at, Cell& cell) const {
  cell.at = at;
  cell.near_surface = false;
  cell.usable.fill(0.0F);
  if ((at.array() < 0).any() || (at.array() + 1 >= size_.array()).any()) return;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const auto bit = [corner](unsigned axis) { return static_cast<int>(corner >> axis & 1U); };
    const std::int32_t number = point_at_[Index(at.x() + bit(0), at.y() + bit(1), at.z() + bit(2))];
    if (number < 0) continue;
    cell.near_surface = true;
    const Point& point = points_[static_cast<std::size_t>(number)];
    if (point.inside_solid) continue;
    cell.usable[corner] = 1.0F;
    for (std::size_t plate = 0; plate < 6; ++plate) {
      const std::uint16_t* steps = &point.plates[4 * plate];
      cell.plates[corner][plate] =
          Eigen::Array4f(static_cast<float>(steps[0]), static_cast<float>(steps[1]),
                         static_cast<float>(steps[2]), 0.0F);
    }
  }
}

Eigen::Array3f LightField::At(const Eigen::Vector3d& place_enu_m, const Eigen::Vector3f& normal_enu,
                              Cell& cell) const {
  const Eigen::Vector3f place =
      (place_enu_m.cast<float>() + 0.5F * cell_m_ * normal_enu - low_) * per_cell_m_;
  const Eigen::Vector3i at(FloorInt(place.x()), FloorInt(place.y()), FloorInt(place.z()));
  if (at != cell.at) Unpack(at, cell);
  const Eigen::Vector3f f = place - at.cast<float>();
  const Eigen::Vector3f g = Eigen::Vector3f::Ones() - f;
  std::array<float, 8> weight;
  float weights = 0.0F;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    weight[corner] = cell.usable[corner] * ((corner & 1U) != 0 ? f.x() : g.x()) *
                     ((corner & 2U) != 0 ? f.y() : g.y()) * ((corner & 4U) != 0 ? f.z() : g.z());
    weights += weight[corner];
  }
  if (weights > 0.02F) {
    Eigen::Array4f sum = Eigen::Array4f::Zero();
    for (int axis = 0; axis < 3; ++axis) {
      const float square = normal_enu[axis] * normal_enu[axis];
      if (square < kLeastSquare) continue;  // most surfaces face along an axis
      const auto plate = 2U * static_cast<std::size_t>(axis) + (normal_enu[axis] > 0.0F ? 0U : 1U);
      Eigen::Array4f light = Eigen::Array4f::Zero();
      for (std::size_t corner = 0; corner < 8; ++corner) {
        if (weight[corner] > 0.0F) light += weight[corner] * cell.plates[corner][plate];
      }
      sum += square * light;
    }
    return sum.head<3>() * (kLightStep / weights);
  }
  if (cell.near_surface) return kBetweenSolids * open_sky_;
  const float up = 0.5F + 0.5F * normal_enu.z();  // in the open air, as the robot's own body
  return open_sky_ * up + open_ground_ * (1.0F - up);
}

}  // namespace kawara::sim
