#include "vision/change/reference_builder.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/check.hpp"

namespace kawara::vision {

/// Of the points of a voxel, from its centre [m].
struct ReferenceBuilder::Sums {
  std::uint32_t points = 0;
  std::uint16_t source = 0;
  bool surface = false;
  std::array<float, 3> first{};   ///< x, y, z
  std::array<float, 6> second{};  ///< xx, xy, xz, yy, yz, zz
};

struct ReferenceBuilder::Block {
  BlockIndex index;
  std::array<Sums, kBlockVoxels> voxels{};
};

namespace {

constexpr double kSampleStep = 0.1;
// Sums are floats: beyond so many points a voxel knows its plane.
constexpr std::uint32_t kEnough = 200000;

ReferencePatch PatchOf(std::uint32_t points, const std::array<float, 3>& first,
                       const std::array<float, 6>& second) {
  const double n = points;
  const Eigen::Vector3d mean = Eigen::Vector3f(first.data()).cast<double>() / n;
  Eigen::Matrix3f moments;
  moments << second[0], second[1], second[2], second[1], second[3], second[4], second[2], second[4],
      second[5];
  const Eigen::Matrix3d cov = moments.cast<double>() / n - mean * mean.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(cov);
  ReferencePatch patch;
  patch.mean_m = mean.cast<float>();
  patch.normal = axes.eigenvectors().col(0).cast<float>();
  patch.thickness_m = static_cast<float>(std::sqrt(std::max(0.0, axes.eigenvalues()[0])));
  // Points on a line or in a heap have no plane: half the voxel is as thick as they are.
  if (axes.eigenvalues()[1] < 1e-4) {
    patch.normal = Eigen::Vector3f::UnitZ();
    patch.thickness_m = static_cast<float>(std::sqrt(std::max(0.0, cov(2, 2))));
  }
  patch.points = points;
  return patch;
}

}  // namespace

ReferenceBuilder::ReferenceBuilder(const ReferenceBuildOptions& options) : options_(options) {}
ReferenceBuilder::~ReferenceBuilder() = default;
ReferenceBuilder::ReferenceBuilder(ReferenceBuilder&&) noexcept = default;
ReferenceBuilder& ReferenceBuilder::operator=(ReferenceBuilder&&) noexcept = default;

void ReferenceBuilder::Begin(const ReferenceSource& source) {
  constexpr std::size_t kMost = 0xFFFF;
  const auto same = std::find_if(sources_.begin(), sources_.end(), [&](const ReferenceSource& s) {
    return s.name == source.name && s.kind == source.kind && s.date == source.date &&
           s.sd_m == source.sd_m;
  });
  if (same == sources_.end() && sources_.size() < kMost) {
    sources_.push_back(source);
    source_ = static_cast<std::uint16_t>(sources_.size() - 1);
  } else {
    source_ =
        static_cast<std::uint16_t>(std::min<std::ptrdiff_t>(same - sources_.begin(), kMost - 1));
  }
}

ReferenceBuilder::Sums& ReferenceBuilder::SumsAt(const VoxelIndex& voxel) {
  const BlockIndex block{voxel.x >> kBlockBits, voxel.y >> kBlockBits, voxel.z >> kBlockBits};
  constexpr std::int64_t kMask = (std::int64_t{1} << 21) - 1;
  const std::int64_t key =
      ((block.x & kMask) << 42) | ((block.y & kMask) << 21) | (block.z & kMask);
  if (last_ == nullptr || key != last_key_) {
    auto& owner = blocks_[key];
    if (!owner) {
      owner = std::make_unique<Block>();
      owner->index = block;
    }
    last_ = owner.get();
    last_key_ = key;
  }
  return last_->voxels[static_cast<std::size_t>(VoxelInBlock(voxel.x, voxel.y, voxel.z))];
}

void ReferenceBuilder::Add(const Eigen::Vector3d& p) {
  constexpr double kMost = 5e5;  // m: what the keys hold
  if (!(p.cwiseAbs().maxCoeff() < kMost)) return;
  const VoxelIndex voxel = ReferenceMap::VoxelOf(p);
  Sums& sums = SumsAt(voxel);
  ++points_;
  sums.source = source_;
  if (sums.points >= kEnough) return;
  ++sums.points;
  sums.surface |= surfaces_;
  constexpr double kSide = ReferenceMap::kVoxel;
  const auto x = static_cast<float>(p.x() - (voxel.x + 0.5) * kSide);
  const auto y = static_cast<float>(p.y() - (voxel.y + 0.5) * kSide);
  const auto z = static_cast<float>(p.z() - (voxel.z + 0.5) * kSide);
  sums.first[0] += x;
  sums.first[1] += y;
  sums.first[2] += z;
  sums.second[0] += x * x;
  sums.second[1] += x * y;
  sums.second[2] += x * z;
  sums.second[3] += y * y;
  sums.second[4] += y * z;
  sums.second[5] += z * z;
}

void ReferenceBuilder::AddPoints(std::span<const Eigen::Vector3d> points_m) {
  CORE_CHECK(!sources_.empty());
  surfaces_ = false;
  for (const Eigen::Vector3d& p : points_m) Add(p);
}

void ReferenceBuilder::AddFace(const std::vector<std::vector<Eigen::Vector3d>>& rings_m) {
  CORE_CHECK(!sources_.empty());
  if (rings_m.empty() || rings_m.front().size() < 3) return;
  // Newell's normal stands the small faults that rings of files have.
  const std::vector<Eigen::Vector3d>& outer = rings_m.front();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), low = outer.front(), high = outer.front();
  for (std::size_t i = 0; i < outer.size(); ++i) {
    const Eigen::Vector3d &a = outer[i], &b = outer[(i + 1) % outer.size()];
    normal += (a - outer.front()).cross(b - outer.front());
    low = low.cwiseMin(a);
    high = high.cwiseMax(a);
  }
  constexpr double kMostSide = 2000.0;  // m: a longer one is a fault of the file
  if (!(normal.norm() > 1e-6) || !((high - low).norm() < kMostSide)) return;
  surfaces_ = true;
  normal.normalize();
  const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const auto flat = [&](const Eigen::Vector3d& p) {
    return Eigen::Vector2d((p - outer.front()).dot(u), (p - outer.front()).dot(v));
  };
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> edges;
  double first = 1e300, last = -1e300;
  for (const auto& ring : rings_m)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      edges.emplace_back(flat(ring[i]), flat(ring[(i + 1) % ring.size()]));
      first = std::min(first, edges.back().first.y());
      last = std::max(last, edges.back().first.y());
    }
  // Row by row between the edges it crosses, by the even-odd rule.
  std::vector<double> crossings;
  const int rows = static_cast<int>(std::ceil((last - first) / kSampleStep));
  for (int row = 0; row < rows; ++row) {
    const double y = first + (row + 0.5) * kSampleStep;
    crossings.clear();
    for (const auto& [a, b] : edges)
      if ((a.y() > y) != (b.y() > y))
        crossings.push_back(a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t i = 0; i + 1 < crossings.size(); i += 2)
      for (int k = 0; crossings[i] + k * kSampleStep <= crossings[i + 1]; ++k)
        Add(outer.front() + (crossings[i] + k * kSampleStep) * u + y * v);
  }
}

ReferenceMap ReferenceBuilder::Finish(bool ground_from_surfaces) const {
  ReferenceMap map;
  map.sources = sources_;
  for (const auto& [key, block] : blocks_) {
    for (std::size_t i = 0; i < block->voxels.size(); ++i) {
      const Sums& sums = block->voxels[i];
      if (sums.points == 0 || (!sums.surface && sums.points < options_.min_points)) continue;
      ReferencePatch patch = PatchOf(sums.points, sums.first, sums.second);
      patch.source = sums.source;
      patch.sd_m = static_cast<float>(sources_[sums.source].sd_m);
      const auto place = static_cast<std::int32_t>(i);
      constexpr std::int32_t kMask = kBlockSide - 1;
      map.SetPatch({block->index.x * kBlockSide + (place & kMask),
                    block->index.y * kBlockSide + ((place >> kBlockBits) & kMask),
                    block->index.z * kBlockSide + (place >> (2 * kBlockBits))},
                   patch);
    }
  }
  if (ground_from_surfaces) FindGround(map);
  return map;
}

// The lowest level patch of each column, unless its neighbours say that it lies high: a roof or a
// table of which the ground below was not seen.
void ReferenceBuilder::FindGround(ReferenceMap& map) const {
  std::map<GroundField::Cell, GroundHeight> lowest;
  const double least_up = 1.0 / std::sqrt(1.0 + options_.ground_slope * options_.ground_slope);
  for (const auto& [voxel, patch] : map.Patches()) {
    if (std::abs(static_cast<double>(patch.normal.z())) < least_up) continue;
    const double up_m =
        (voxel.z + 0.5) * ReferenceMap::kVoxel + static_cast<double>(patch.mean_m.z());
    const GroundHeight here{up_m,
                            std::hypot(options_.ground_sd_m, static_cast<double>(patch.sd_m))};
    const auto [at, is_new] = lowest.try_emplace({voxel.x, voxel.y}, here);
    if (!is_new && up_m < at->second.up_m) at->second = here;
  }
  map.ground = GroundField(ReferenceMap::kVoxel);
  constexpr std::int32_t kAround = 4;  // cells
  constexpr double kStep = 0.25;       // m that ground may rise at once
  constexpr double kLeastKnown = 3.0;  // cells around that must agree
  for (const auto& [cell, height] : lowest) {
    double lower = 0.0, level = 0.0;
    for (std::int32_t dy = -kAround; dy <= kAround; ++dy)
      for (std::int32_t dx = -kAround; dx <= kAround; ++dx) {
        const auto other = lowest.find({cell.first + dx, cell.second + dy});
        if (other == lowest.end()) continue;
        const double rise = options_.ground_slope * ReferenceMap::kVoxel * std::hypot(dx, dy);
        if (other->second.up_m < height.up_m - kStep - rise)
          lower += 1.0;
        else if (std::abs(other->second.up_m - height.up_m) < kStep + rise)
          level += 1.0;
      }
    if (lower == 0.0 && level > kLeastKnown) map.ground.Set(cell, height);
  }
}

}  // namespace kawara::vision
