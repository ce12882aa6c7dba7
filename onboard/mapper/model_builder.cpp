#include "onboard/mapper/model_builder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "vision/model/surface.hpp"
#include "vision/model/texture.hpp"

namespace kawara::mapper {
namespace {

/// A voxel of the model: enough votes, as many as rays that looked through, and a mean good to 5
/// cm.
constexpr vision::OccupancyRule kOccupied{.min_hits = 5, .min_weight = 1.0 / (0.05 * 0.05)};
/// It stands by itself with as many votes as one picture has for it from here [m]: what lies
/// farther away must have been seen again.
constexpr double kStrongFrom = 5.0;
/// Fewer voxels around are a scrap.
constexpr int kLeastAround = 8;
/// Metres between pictures that textures are taken from.
constexpr double kLookStep = 2.0;
/// A tile's texture comes from the picture nearest to it and those up to so much farther away: what
/// they show of it, no other shows better, unless it is hidden from them all.
constexpr double kLooksBeyond = 4.0;
/// A tile is finished when it is this much farther away than ranges reach.
constexpr double kFinishMargin = 1.0;
/// Pairs that a kill costs at most.
constexpr std::uint64_t kCommitEvery = 8;

}  // namespace

core::Expected<ModelBuilder> ModelBuilder::Open(
    const BuilderOptions& options, const Rig& rig,
    const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras, ModelStore store) {
  auto map = vision::VoxelMap::Open({.voxel_m = options.voxel_m, .max_range_m = options.reach_m},
                                    store.voxels().string());
  if (!map) return tl::unexpected(map.error());
  return ModelBuilder(options, rig, cameras, std::move(store), std::move(*map));
}

ModelBuilder::ModelBuilder(const BuilderOptions& options, const Rig& rig,
                           const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras,
                           ModelStore store, vision::VoxelMap map)
    : options_(options),
      rig_(&rig),
      cameras_(&cameras),
      store_(std::move(store)),
      map_(std::move(map)),
      surface_rule_(RuleFor(options, cameras)),
      matcher_(options.stereo),
      first_stop_(map_.progress()),
      pairs_(map_.pictures()),
      last_stop_(map_.progress() == 0 ? 0 : map_.progress() - 1) {
  for (const auto& camera : cameras) {
    const vision::MaskedRays& rays = camera->rays();
    rays_.emplace_back(camera->model(), vision::RayTables{rays.x(), rays.y(), rays.z()});
  }
}

vision::SurfaceRule ModelBuilder::RuleFor(
    const BuilderOptions& options,
    const std::vector<std::unique_ptr<vision::StereoCamera>>& cameras) {
  double px_per_rad = 0.0;  // of the camera that shows least: what it sees must not be lost
  for (const auto& camera : cameras) {
    const double its = camera->mean_px_per_rad();
    px_per_rad = px_per_rad > 0.0 ? std::min(px_per_rad, its) : its;
  }
  const double side_px = options.voxel_m / kStrongFrom * px_per_rad;
  return {.occupancy = kOccupied,
          .strong_hits = std::max(kOccupied.min_hits, static_cast<int>(side_px * side_px)),
          .least_around = kLeastAround};
}

double ModelBuilder::out_of_reach_m() const { return options_.reach_m + kFinishMargin; }

// A tile's surface needs its neighbours too.
double ModelBuilder::keep_m() const { return out_of_reach_m() + 2.0 * map_.tile_m(); }

core::Expected<void> ModelBuilder::Add(const PicturePair& pair) {
  if (pair.stop < first_stop_) {
    const auto& looks = store_.manifest().looks;
    const bool wanted = std::ranges::find(looks, pair.stop) != looks.end();
    if (wanted || measured_) {
      if (auto done = Match(pair); !done) return done;
    }
    if (wanted) AddLook(pair);
    return {};
  }
  const Eigen::Vector3d here = pair.map_from_a.translation();
  if (!started_) {
    started_ = true;
    // Tiles that an earlier run changed and had not finished again.
    if (auto done = ReturnAbout(here); !done) return done;
  }
  // Between stops only: a stop may have pairs of several cameras.
  const bool due = tiles_written_ || since_commit_ >= kCommitEvery;
  if (due && pair.stop != last_stop_) {
    if (auto done = Commit(0); !done) return done;
  }
  if (auto done = Match(pair); !done) return done;
  const vision::RangeView view{.rays = rays_[pair.camera],
                               .ranges = ranges_,
                               .picture = pair.picture_a->view(),
                               .map_from_camera = pair.map_from_a};
  if (auto done = map_.Vote(view); !done) return done;
  if (auto done = map_.Examine(view); !done) return done;
  const auto same_place = [&](const std::unique_ptr<Look>& look) {
    return look->camera == pair.camera && (look->place() - here).norm() < kLookStep;
  };
  if (std::ranges::none_of(looks_, same_place)) {
    AddLook(pair);
  }
  ++pairs_;
  ++since_commit_;
  last_stop_ = pair.stop;
  last_place_ = here;
  last_time_ = pair.time;
  added_ = true;
  if (auto done = TellGrown(false); !done) return done;
  return FinishTiles(here);
}

core::Expected<void> ModelBuilder::TellGrown(bool last) {
  if (!grown_ || !added_) return {};
  const auto views = [this] {
    std::vector<NamedView> all;
    for (const auto& look : looks_) all.push_back({ViewOf(*look), look->name, look->time});
    return all;
  };
  return grown_({map_, last_place_, keep_m(), last_time_, views, last});
}

vision::TextureView ModelBuilder::ViewOf(const Look& look) const {
  return {.camera = *rig_->cameras[look.camera].model,
          .picture = look.picture->view(),
          .ranges = &look.ranges,
          .map_from_camera = look.map_from_camera};
}

core::Expected<void> ModelBuilder::Match(const PicturePair& pair) {
  const vision::StereoCamera& camera = *(*cameras_)[pair.camera];
  std::vector<vision::StereoView> others{{&camera, pair.picture_b->view(), pair.map_from_b}};
  std::vector<vision::StepDoubt> doubts{pair.doubt};
  for (const OtherPicture& other : pair.more) {
    others.push_back({&camera, other.picture->view(), other.map_from_camera});
    doubts.push_back(other.doubt);
  }
  auto done =
      matcher_.Match({&camera, pair.picture_a->view(), pair.map_from_a}, others, ranges_, doubts);
  if (done && measured_) measured_(pair, camera, ranges_);
  return done;
}

void ModelBuilder::AddLook(const PicturePair& pair) {
  looks_.push_back(
      std::make_unique<Look>(Look{pair.stop, pair.time, pair.camera, pair.name, pair.picture_a,
                                  vision::RangesForTexture(ranges_), pair.map_from_a}));
}

std::uint64_t ModelBuilder::first_look() const {
  const auto& looks = store_.manifest().looks;
  return looks.empty() ? first_stop_ : std::min(first_stop_, *std::ranges::min_element(looks));
}

core::Expected<void> ModelBuilder::Pause() { return Commit(0); }

core::Expected<void> ModelBuilder::Finish(std::uint64_t stops_of_source) {
  if (auto told = TellGrown(true); !told) return told;
  for (const vision::TileIndex& tile : map_.Tiles()) {
    const TileRecord* record = store_.Find(tile.x, tile.y);
    if (!map_.IsResident(tile) && record != nullptr) continue;  // written before it was put away
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        if (auto back = map_.Return({tile.x + dx, tile.y + dy}); !back) return back;
      }
    }
    if (record != nullptr && record->revision == map_.Revision(tile)) continue;
    if (auto done = FinishTile(tile); !done) return done;
  }
  return Commit(stops_of_source);
}

core::Expected<void> ModelBuilder::ReturnAbout(const Eigen::Vector3d& here) {
  for (const vision::TileIndex& tile : map_.Tiles()) {
    if (Distance(tile, here) > keep_m()) continue;
    if (auto back = map_.Return(tile); !back) return back;
  }
  return {};
}

double ModelBuilder::Distance(const vision::TileIndex& tile, const Eigen::Vector3d& from) const {
  const double side = map_.tile_m();
  const auto outside = [side](double at, double low) {
    return std::max({low - at, at - (low + side), 0.0});
  };
  return std::hypot(outside(from.x(), tile.x * side), outside(from.y(), tile.y * side));
}

core::Expected<void> ModelBuilder::FinishTiles(const Eigen::Vector3d& here) {
  for (const vision::TileIndex& tile : map_.Tiles()) {
    if (!map_.IsResident(tile) || Distance(tile, here) <= out_of_reach_m()) continue;
    const TileRecord* record = store_.Find(tile.x, tile.y);
    if (record != nullptr && record->revision == map_.Revision(tile)) continue;
    if (auto done = FinishTile(tile); !done) return done;
  }
  if (auto done = map_.SpillBeyond(here, keep_m()); !done) return done;
  ForgetLooks(here);
  return {};
}

double ModelBuilder::LooksWithin(const vision::TileIndex& tile) const {
  double nearest = options_.reach_m;
  for (const auto& look : looks_) nearest = std::min(nearest, Distance(tile, look->place()));
  return std::min(options_.reach_m, nearest + kLooksBeyond);
}

// Those that no tile wants that is or may yet be voted for.
void ModelBuilder::ForgetLooks(const Eigen::Vector3d& here) {
  std::vector<bool> wanted;
  for (const auto& look : looks_) {
    wanted.push_back((look->place() - here).norm() <= options_.reach_m);
  }
  for (const vision::TileIndex& tile : map_.Tiles()) {
    if (!map_.IsResident(tile) || Distance(tile, here) > out_of_reach_m()) continue;
    const double within = LooksWithin(tile);
    for (std::size_t i = 0; i < looks_.size(); ++i) {
      if (Distance(tile, looks_[i]->place()) <= within) wanted[i] = true;
    }
  }
  std::size_t i = 0;
  std::erase_if(looks_, [&](const std::unique_ptr<Look>&) { return !wanted[i++]; });
}

core::Expected<void> ModelBuilder::FinishTile(const vision::TileIndex& tile) {
  vision::Surface surface = vision::BuildSurface(map_, tile, surface_rule_);
  if (!surface.quads.empty()) {
    std::vector<vision::TextureView> views;
    const double within = LooksWithin(tile);
    for (const auto& look : looks_) {
      if (Distance(tile, look->place()) > within) continue;
      views.push_back(ViewOf(*look));
    }
    const auto done = vision::ApplyTexture(surface, options_.voxel_m, views, {}, encoder_);
    if (!done) return tl::unexpected(done.error());
  }
  tiles_written_ = true;
  return store_.WriteTile(tile.x, tile.y, map_.Revision(tile), std::move(surface.mesh),
                          surface.points);
}

core::Expected<void> ModelBuilder::Commit(std::uint64_t stops_of_source) {
  // Tiles first: what the voxel file calls done must be in the folder.
  std::vector<std::uint64_t> looks;
  for (const auto& look : looks_) looks.push_back(look->stop);
  auto written = store_.WriteIndex(last_stop_ + 1, pairs_, stops_of_source, std::move(looks));
  if (!written) return written;
  since_commit_ = 0;
  tiles_written_ = false;
  return map_.Commit(last_stop_ + 1);
}

}  // namespace kawara::mapper
