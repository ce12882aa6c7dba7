#pragma once
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "onboard/mapper/model_store.hpp"
#include "onboard/mapper/pair_maker.hpp"
#include "onboard/mapper/stereo_method.hpp"
#include "vision/jpeg.hpp"
#include "vision/model/texture.hpp"
#include "vision/model/voxel_patch.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::mapper {

struct BuilderOptions {
  StereoOptions stereo;
  double voxel_m = 0.10;
  double reach_m = 8.0;  ///< ranges beyond are not voted
};

/// A distance image as it is made: `ranges` are of pair.picture_a, by `camera`, and gone after the
/// call.
using Measured = std::function<void(const PicturePair& pair, const vision::StereoCamera& camera,
                                    const vision::RangeImage& ranges)>;

/// A picture that textures can be taken from, good during the call it comes with.
struct NamedView {
  vision::TextureView view;
  std::string name;    ///< of the picture
  core::GpsTime time;  ///< mid-exposure
};

/// What the model knows after a pair was added to it.
struct Grown {
  const vision::VoxelMap& map;
  Eigen::Vector3d here;  ///< of the camera, map [m]
  double known_m = 0.0;  ///< all voxels so far around are in memory
  core::GpsTime time;
  /// Pictures of the last metres of the drive.
  std::function<std::vector<NamedView>()> views;
  bool last = false;  ///< nothing was added since, and nothing will be
};
using OnGrown = std::function<core::Expected<void>(const Grown& grown)>;

/// Pairs of pictures to a model on disk, tile by tile (the paper's section 4): distance image,
/// votes, and, once the drive is out of reach of a tile, its surface and texture. Tiles left behind
/// wait in the store's voxel file, so that memory does not grow with the drive; a second visit
/// brings them back. One thread.
class ModelBuilder {
 public:
  /// `cameras`: of the rig; outlives this. Errors: those of the voxel file.
  static core::Expected<ModelBuilder> Open(
      const BuilderOptions& options, const Rig& rig,
      const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras, ModelStore store);

  /// Stops that an earlier run has made durable: go on from this one.
  std::uint64_t first_stop() const { return first_stop_; }
  /// The first stop whose pairs are wanted again, for textures that were not yet finished.
  std::uint64_t first_look() const;
  /// Damaged places of the voxel file that were left out.
  std::uint64_t damaged_records() const { return map_.damaged_records(); }

  /// From now on told of every distance image; then those of pairs before first_stop() are made
  /// too.
  void OnMeasured(Measured measured) { measured_ = std::move(measured); }
  /// From now on told of every pair that was added, before anything is put away.
  void OnGrown(OnGrown grown) { grown_ = std::move(grown); }
  /// Pairs before first_stop() give pictures for textures only.
  core::Expected<void> Add(const PicturePair& pair);
  /// What there is, durable: to be gone on with.
  core::Expected<void> Pause();
  /// Everything is finished, of so many stops; 0: nobody knows.
  core::Expected<void> Finish(std::uint64_t stops_of_source);

  const ModelStore& store() const { return store_; }
  std::uint64_t pairs() const { return pairs_; }

 private:
  static vision::SurfaceRule RuleFor(
      const BuilderOptions& options,
      const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras);
  /// A picture that textures may be taken from.
  struct Look {
    std::uint64_t stop = 0;
    core::GpsTime time;
    std::size_t camera = 0;
    std::string name;
    SharedPicture picture;
    vision::RangeImage ranges;
    Eigen::Isometry3d map_from_camera = Eigen::Isometry3d::Identity();
    Eigen::Vector3d place() const { return map_from_camera.translation(); }
  };

  ModelBuilder(const BuilderOptions& options, const Rig& rig,
               const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras, ModelStore store,
               vision::VoxelMap map);

  core::Expected<void> Match(const PicturePair& pair);
  void AddLook(const PicturePair& pair);
  vision::TextureView ViewOf(const Look& look) const;
  core::Expected<void> TellGrown(bool last);
  core::Expected<void> ReturnAbout(const Eigen::Vector3d& here);
  core::Expected<void> FinishTiles(const Eigen::Vector3d& here);
  core::Expected<void> FinishTile(const vision::TileIndex& tile);
  core::Expected<void> Commit(std::uint64_t stops_of_source);
  void ForgetLooks(const Eigen::Vector3d& here);
  /// How far from a tile pictures for its texture are looked for.
  double LooksWithin(const vision::TileIndex& tile) const;
  double Distance(const vision::TileIndex& tile, const Eigen::Vector3d& from) const;
  double out_of_reach_m() const;
  double keep_m() const;

  BuilderOptions options_;
  const Rig* rig_;
  const std::vector<std::unique_ptr<vision::StereoCamera>>* cameras_;
  std::vector<vision::CameraRays> rays_;
  ModelStore store_;
  vision::VoxelMap map_;
  vision::SurfaceRule surface_rule_;
  StereoMatcher matcher_;
  Measured measured_;
  mapper::OnGrown grown_;
  Eigen::Vector3d last_place_ = Eigen::Vector3d::Zero();  ///< of the last pair that was added
  core::GpsTime last_time_;
  vision::JpegEncoder encoder_;
  std::vector<std::unique_ptr<Look>> looks_;
  vision::RangeImage ranges_;
  std::uint64_t first_stop_ = 0;  ///< everything before is in the voxels already
  std::uint64_t pairs_ = 0, since_commit_ = 0, last_stop_ = 0;
  bool added_ = false, started_ = false, tiles_written_ = false;
};

}  // namespace kawara::mapper
