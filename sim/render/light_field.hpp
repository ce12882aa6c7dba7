#pragma once
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "sim/render/ray_scene.hpp"
#include "sim/render/sky_map.hpp"

namespace kawara::sim {

struct LightSettings {
  std::uint32_t sky_seed = 1;  ///< which clouds
  int sky_columns = 2048;      ///< texels round the horizon
  double cell_m = 0.5;         ///< between the points where light is measured; at least this
  int max_points = 200'000;    ///< for a large site the cells grow until these suffice
  /// Folder in which measured light is kept from run to run (LightCache); empty: nowhere.
  std::filesystem::path cache = {};
};

/// Light that does not come straight from the sun, at any place of a scene: of the part of the sky
/// that is seen from there, and what sunlit ground and walls throw back once. So it is darker under
/// eaves, between houses and beside a wall, and a red wall tints what stands before it.
///
/// Measured beforehand by rays from a grid of points along all surfaces, each keeping the light on
/// six little plates facing along the axes; interpolated afterwards. Immutable; any thread.
class LightField {
 public:
  /// Measures with the objects there at `time_s` (only those that always are, if it is before any
  /// comes). All cores; the result does not depend on their number.
  /// Points lie inside `region_enu_m` only; outside, everything has the open sky's light.
  /// `cache_key`: of all this depends on, for settings.cache.
  LightField(const RayScene& scene, const SkyMap& sky, const Eigen::AlignedBox3f& region_enu_m,
             double time_s, const LightSettings& settings, std::uint64_t cache_key);

  /// The cell a look-up fell into, unpacked: neighbouring looks mostly fall into the same one. Each
  /// thread has its own, for one LightField.
  struct Cell {
    Eigen::Vector3i at = Eigen::Vector3i::Constant(std::numeric_limits<int>::min());
    bool near_surface = false;
    std::array<float, 8> usable{};  ///< 0: no point at this corner, or inside something; 1
    /// Of corner n: plates facing +e, -e, +n, -n, +u, -u.
    std::array<std::array<Eigen::Array4f, 6>, 8> plates;
  };

  /// Light on a surface at a place, over pi, in SkyMap's units. `normal_enu` points to the viewer.
  /// What is in `cell` changes nothing but the time it takes.
  Eigen::Array3f At(const Eigen::Vector3d& place_enu_m, const Eigen::Vector3f& normal_enu,
                    Cell& cell) const;
  Eigen::Array3f At(const Eigen::Vector3d& place_enu_m, const Eigen::Vector3f& normal_enu) const {
    Cell cell;
    return At(place_enu_m, normal_enu, cell);
  }

  float cell_m() const { return cell_m_; }
  std::size_t point_count() const { return points_.size(); }
  bool from_cache() const { return from_cache_; }

 private:
  /// A cache line: light on plates facing +e, -e, +n, -n, +u, -u as red, green, blue and nothing,
  /// in steps of kLightStep.
  struct alignas(64) Point {
    std::array<std::uint16_t, 24> plates{};
    bool inside_solid = false;
  };
  std::string Measured() const;
  bool Restore(const std::string& measured);
  bool PlacePoints(const RayScene& scene, const Eigen::AlignedBox3f& region,
                   std::size_t max_points);
  void Measure(const RayScene& scene, const SkyMap& sky, const RayScene::Moment& moment,
               std::size_t number);
  void Unpack(const Eigen::Vector3i& at, Cell& cell) const;
  std::size_t Index(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size_.y()) +
            static_cast<std::size_t>(j)) *
               static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(i);
  }

  float cell_m_;
  float per_cell_m_ = 1.0F;
  bool from_cache_ = false;
  Eigen::Vector3f low_ = Eigen::Vector3f::Zero();
  Eigen::Vector3i size_ = Eigen::Vector3i::Zero();
  std::vector<std::int32_t> point_at_;  ///< of a grid place; -1: none
  std::vector<Eigen::Vector3i> places_;
  std::vector<Point> points_;
  std::vector<Eigen::Array3f> sky_light_;  ///< of the directions in which points look
  Eigen::Array3f open_sky_, open_ground_;  ///< where there are no points
};

}  // namespace kawara::sim
