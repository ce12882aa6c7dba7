#include "onboard/changes/change_input.hpp"

#include <unistd.h>

#include <cmath>
#include <system_error>

#include "gis/cloud/cloud.hpp"
#include "onboard/mapper/model_store.hpp"

namespace kawara::changes {
namespace {

namespace fs = std::filesystem;

/// A copy that goes away with its owner: the mapper may still be writing the file.
class TemporaryCopy {
 public:
  static core::Expected<TemporaryCopy> Of(const fs::path& file) {
    TemporaryCopy copy;
    std::error_code error;
    copy.path_ = fs::temp_directory_path(error) /
                 ("kawara-changes-" + std::to_string(::getpid()) + ".spill");
    fs::copy_file(file, copy.path_, fs::copy_options::overwrite_existing, error);
    if (error)
      return core::Fail(core::ErrorCode::kIo, file.string() + ": cannot be copied to " +
                                                  copy.path_.string() + ": " + error.message());
    return copy;
  }
  TemporaryCopy(TemporaryCopy&& other) noexcept { std::swap(path_, other.path_); }
  TemporaryCopy& operator=(TemporaryCopy&& other) noexcept {
    std::swap(path_, other.path_);
    return *this;
  }
  ~TemporaryCopy() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  std::string path() const { return path_.string(); }

 private:
  TemporaryCopy() = default;
  fs::path path_;
};

core::Expected<ChangeInput> OfModel(const fs::path& folder) {
  const fs::path voxels = folder / "voxels.spill";
  std::error_code error;
  if (!fs::exists(voxels, error))
    return core::Fail(core::ErrorCode::kNotFound,
                      folder.string() + ": holds no model of kawara-mapper (no voxels.spill)");
  const auto voxel_m = vision::SpillFile::VoxelOf(voxels.string());
  if (!voxel_m) return tl::unexpected(voxel_m.error());
  const auto copy = TemporaryCopy::Of(voxels);
  if (!copy) return tl::unexpected(copy.error());
  auto map = vision::VoxelMap::Open({.voxel_m = *voxel_m}, copy->path());
  if (!map) return tl::unexpected(map.error());
  for (const vision::TileIndex& tile : map->Tiles())
    if (auto back = map->Return(tile); !back) return tl::unexpected(back.error());
  return ChangeInput{std::move(*map), mapper::ModelStore::OriginOf(folder), 0, true};
}

core::Expected<ChangeInput> OfClouds(const ChangeRunOptions& options,
                                     const std::optional<core::Geodetic>& origin) {
  auto map = vision::VoxelMap::Create({.voxel_m = options.voxel_m});
  if (!map) return tl::unexpected(map.error());
  ChangeInput input{std::move(*map), origin, 0, false};
  std::vector<vision::PointVote> votes;
  for (const fs::path& file : options.inputs) {
    const auto info = gis::ReadCloudInfo(file.string());
    if (!info) return tl::unexpected(info.error());
    const bool says = !info->crs.empty() || info->origin;
    if (!input.origin && !options.local)
      if (const auto own = gis::OriginOf(*info, options.geoid_separation_m)) input.origin = *own;
    gis::MapFrame frame;
    frame.origin = input.origin.value_or(core::Geodetic{});
    frame.geoid_separation_m = options.geoid_separation_m;
    frame.coordinates =
        says && !options.local ? gis::Coordinates::kFromFile : gis::Coordinates::kLocalMetres;
    core::Expected<void> voted;
    const auto read = gis::ReadCloudEnu(file.string(), frame, [&](auto points) {
      votes.clear();
      for (const gis::CloudPoint& point : points) {
        vision::PointVote vote;
        vote.position_m = point.position;
        vote.sd_m = static_cast<float>(options.cloud_sd_m);
        vote.colour = point.colour;
        const Eigen::Vector3d look = options.sensor_m.value_or(point.position) - point.position;
        if (look.norm() > 1e-3) vote.to_viewer = look.normalized().cast<float>();
        votes.push_back(vote);
      }
      if (voted) voted = input.map.Vote(votes);
    });
    if (!read) return tl::unexpected(read.error());
    if (!voted) return tl::unexpected(voted.error());
    if (const std::string warning =
            gis::WarnOfHeights(file.string(), read->heights, options.geoid_separation_m);
        options.say && !warning.empty())
      options.say(warning);
    input.points += read->delivered;
  }
  return input;
}

}  // namespace

core::Expected<ChangeInput> ReadInput(const ChangeRunOptions& options,
                                      const std::optional<core::Geodetic>& origin) {
  std::error_code error;
  for (const fs::path& input : options.inputs) {
    if (!fs::is_directory(input, error)) continue;
    if (options.inputs.size() > 1)
      return core::Fail(core::ErrorCode::kInvalidArgument,
                        "one folder of kawara-mapper at a time, without clouds beside it");
    return OfModel(input);
  }
  return OfClouds(options, origin);
}

}  // namespace kawara::changes
