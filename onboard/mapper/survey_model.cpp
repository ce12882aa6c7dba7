#include "onboard/mapper/survey_model.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gis/model/model_writers.hpp"
#include "gis/model/whole_file.hpp"
#include "onboard/survey/survey.hpp"
#include "vision/jpeg.hpp"
#include "vision/model/surface.hpp"
#include "vision/model/texture.hpp"
#include "vision/stereo/pair_matcher.hpp"
#include "vision/voxel/voxel_map.hpp"

namespace kawara::mapper {
namespace {

namespace fs = std::filesystem;

/// A voxel of the model: enough votes, as many as rays that looked through, and a mean good to 5
/// cm.
constexpr vision::OccupancyRule kSurfaceRule{.min_hits = 5, .min_weight = 1.0 / (0.05 * 0.05)};
/// Metres between pictures that textures are taken from.
constexpr double kLookStep = 1.0;
/// A tile is finished when it is this much farther away than ranges reach.
constexpr double kFinishMargin = 1.0;

struct Camera {
  std::unique_ptr<vision::StereoCamera> stereo;
  std::unique_ptr<vision::CameraRays> rays;
};

/// A picture that textures may be taken from.
struct Look {
  int camera = 0;
  survey::Picture picture;
  vision::RangeImage ranges;
  Eigen::Isometry3d map_from_camera;
};

struct FramePair {
  const survey::SurveyFrame* a;
  const survey::SurveyFrame* b;
};

class Builder {
 public:
  Builder(const ModelOptions& options, survey::Survey survey, vision::VoxelMap map)
      : options_(options),
        survey_(std::move(survey)),
        map_(std::move(map)),
        matcher_({.px_per_rad = options.px_per_rad, .nearest_m = options.nearest_m}) {
    for (const auto& camera : survey_.cameras) {
      cameras_.push_back({std::make_unique<vision::StereoCamera>(camera.model, camera.mask),
                          std::make_unique<vision::CameraRays>(*camera.model)});
    }
  }

  core::Expected<ModelResult> Run(const ModelProgress& progress) {
    const auto start = std::chrono::steady_clock::now();
    const std::vector<FramePair> pairs = Pairs();
    if (pairs.empty()) {
      return core::Fail(core::ErrorCode::kFormat,
                        "no two frames of a camera in " + options_.survey.string() +
                            " are a baseline of " + std::to_string(options_.baseline_m) +
                            " m apart: take a longer survey, or a smaller --baseline");
    }
    for (const FramePair& pair : pairs) {
      if (auto done = AddPair(pair); !done) return tl::unexpected(done.error());
      ++result_.pairs;
      progress(result_.pairs, pairs.size());
      if (auto done = FinishTiles(PoseOf(*pair.a).translation()); !done) {
        return tl::unexpected(done.error());
      }
    }
    if (auto done = FinishTiles({}); !done) return tl::unexpected(done.error());
    if (tiles_.empty()) {
      return core::Fail(
          core::ErrorCode::kFormat,
          "nothing was measured often enough for a surface: check poses, mounting and "
          "calibration with --depth-only");
    }
    if (auto done = WriteIndex(); !done) return tl::unexpected(done.error());
    result_.tiles = tiles_.size();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result_;
  }

 private:
  Eigen::Isometry3d PoseOf(const survey::SurveyFrame& frame) const {
    return frame.pose.map_from_body *
           survey_.cameras[static_cast<std::size_t>(frame.camera)].body_from_camera;
  }
  double Apart(const survey::SurveyFrame& a, const survey::SurveyFrame& b) const {
    return (PoseOf(a).translation() - PoseOf(b).translation()).norm();
  }

  /// Of each camera, every step_m a frame with the next one a baseline away; in the order of time.
  std::vector<FramePair> Pairs() const {
    std::vector<FramePair> pairs;
    std::map<int, const survey::SurveyFrame*> last;
    for (std::size_t i = 0; i < survey_.frames.size(); ++i) {
      const auto& a = survey_.frames[i];
      const auto*& before = last[a.camera];
      if (before != nullptr && Apart(*before, a) < options_.step_m) continue;
      for (std::size_t k = i + 1; k < survey_.frames.size(); ++k) {
        const auto& b = survey_.frames[k];
        if (b.camera != a.camera || Apart(a, b) < 0.98 * options_.baseline_m) continue;
        if (Apart(a, b) < 2.0 * options_.baseline_m) {
          pairs.push_back({&a, &b});
          before = &a;
        }
        break;
      }
    }
    return pairs;
  }

  /// The picture of a frame; the last few stay, as a frame is of two pairs.
  core::Expected<std::shared_ptr<const survey::Picture>> PictureOf(
      const survey::SurveyFrame& frame) {
    for (const auto& [known, picture] : pictures_) {
      if (known == &frame) return picture;
    }
    auto loaded = survey::LoadFrame(survey_, frame);
    if (!loaded) return tl::unexpected(loaded.error());
    pictures_.emplace_back(&frame, std::make_shared<const survey::Picture>(std::move(*loaded)));
    constexpr std::size_t kKept = 4;
    if (pictures_.size() > kKept) pictures_.pop_front();
    return pictures_.back().second;
  }

  core::Expected<void> AddPair(const FramePair& pair) {
    const auto picture_a = PictureOf(*pair.a);
    if (!picture_a) return tl::unexpected(picture_a.error());
    const auto picture_b = PictureOf(*pair.b);
    if (!picture_b) return tl::unexpected(picture_b.error());
    const Camera& camera = cameras_[static_cast<std::size_t>(pair.a->camera)];
    const Eigen::Isometry3d pose = PoseOf(*pair.a);
    vision::RangeImage ranges;
    const auto matched =
        matcher_.Match({camera.stereo.get(), (*picture_a)->view(), pose},
                       {camera.stereo.get(), (*picture_b)->view(), PoseOf(*pair.b)}, ranges);
    if (!matched) return tl::unexpected(matched.error());
    const vision::RangeView view{.rays = *camera.rays,
                                 .ranges = ranges,
                                 .picture = (*picture_a)->view(),
                                 .map_from_camera = pose};
    if (auto done = map_.Vote(view); !done) return done;
    if (auto done = map_.Examine(view); !done) return done;
    const bool wanted =
        looks_.empty() ||
        (looks_.back()->map_from_camera.translation() - pose.translation()).norm() >= kLookStep;
    if (wanted) {
      looks_.push_back(
          std::make_unique<Look>(Look{pair.a->camera, **picture_a, std::move(ranges), pose}));
    }
    return {};
  }

  double Distance(const vision::TileIndex& tile, const Eigen::Vector3d& from) const {
    const double side = map_.tile_m();
    const auto outside = [side](double at, double low) {
      return std::max({low - at, at - (low + side), 0.0});
    };
    return std::hypot(outside(from.x(), tile.x * side), outside(from.y(), tile.y * side));
  }

  /// Those out of reach of `here`; all, without it.
  core::Expected<void> FinishTiles(const std::optional<Eigen::Vector3d>& here) {
    const double far = options_.reach_m + kFinishMargin;
    for (const vision::TileIndex& tile : map_.Tiles()) {
      if (here && Distance(tile, *here) <= far) continue;
      // Unless a second visit has changed it since.
      const std::uint64_t revision = map_.Revision(tile);
      auto& finished = finished_[{tile.x, tile.y}];
      if (finished == revision) continue;
      finished = revision;
      if (auto done = WriteTile(tile); !done) return done;
    }
    if (!here) return {};
    std::erase_if(looks_, [&](const std::unique_ptr<Look>& look) {
      const double gone = (look->map_from_camera.translation() - *here).norm();
      return gone > far + options_.reach_m + 2.0 * map_.tile_m();
    });
    return {};
  }

  core::Expected<void> WriteTile(const vision::TileIndex& tile) {
    vision::Surface surface = vision::BuildSurface(map_, tile, kSurfaceRule);
    if (surface.quads.empty()) return {};
    std::vector<vision::TextureView> views;
    for (const auto& look : looks_) {
      if (Distance(tile, look->map_from_camera.translation()) > options_.reach_m) continue;
      views.push_back({.camera = *survey_.cameras[static_cast<std::size_t>(look->camera)].model,
                       .picture = look->picture.view(),
                       .ranges = &look->ranges,
                       .map_from_camera = look->map_from_camera});
    }
    if (auto done = vision::ApplyTexture(surface, options_.voxel_m, views, {}, encoder_); !done) {
      return tl::unexpected(done.error());
    }
    core::TexturedMesh& mesh = surface.mesh;
    mesh.name = "tile_" + std::to_string(tile.x) + "_" + std::to_string(tile.y);
    const std::span<const core::TexturedMesh> meshes(&mesh, 1);
    const fs::path base = options_.out / mesh.name;
    if (auto done = gis::WriteVrml(base.string() + ".wrl", meshes, origin()); !done) return done;
    if (auto done = gis::WriteGlb(base.string() + ".glb", meshes, origin()); !done) return done;
    result_.quads += surface.quads.size();
    tiles_.insert_or_assign({tile.x, tile.y}, gis::EntryOf(mesh, mesh.name + ".glb"));
    return {};
  }

  core::Expected<void> WriteIndex() {
    std::string text = "#VRML V2.0 utf8\n";
    for (const auto& [tile, entry] : tiles_) {
      const std::string name = entry.uri.substr(0, entry.uri.size() - 4);
      text += "Inline { url \"" + name + ".wrl\" }\n";
    }
    result_.vrml = options_.out / "model.wrl";
    if (auto done = gis::WriteWholeFile(result_.vrml, text); !done) return done;
    if (!survey_.origin) return {};
    std::vector<gis::TileEntry> entries;
    for (const auto& [tile, entry] : tiles_) entries.push_back(entry);
    if (auto done = gis::WriteTileset(options_.out / "tileset.json", entries, origin()); !done) {
      return done;
    }
    std::vector<core::ColouredPoint> points;
    map_.ForEachOccupied(kSurfaceRule, [&](const vision::OccupiedVoxel& occupied) {
      points.push_back({vision::CentroidVoxels(occupied.index, occupied.voxel) * options_.voxel_m,
                        vision::ColourOf(occupied.voxel), occupied.voxel.hits});
    });
    return gis::WriteLas(options_.out / "points.las", points, origin());
  }

  core::Geodetic origin() const { return survey_.origin.value_or(core::Geodetic{}); }

  ModelOptions options_;
  survey::Survey survey_;
  vision::VoxelMap map_;
  std::vector<Camera> cameras_;
  vision::PairMatcher matcher_;
  vision::JpegEncoder encoder_;
  std::deque<std::pair<const survey::SurveyFrame*, std::shared_ptr<const survey::Picture>>>
      pictures_;
  std::vector<std::unique_ptr<Look>> looks_;
  std::map<std::pair<int, int>, std::uint64_t> finished_;  ///< revision a tile was written at
  std::map<std::pair<int, int>, gis::TileEntry> tiles_;
  ModelResult result_;
};

}  // namespace

core::Expected<ModelResult> BuildSurveyModel(const ModelOptions& options,
                                             const ModelProgress& progress) {
  auto survey = survey::OpenSurvey(options.survey);
  if (!survey) return tl::unexpected(survey.error());
  auto map = vision::VoxelMap::Create({.voxel_m = options.voxel_m, .max_range_m = options.reach_m});
  if (!map) return tl::unexpected(map.error());
  std::error_code error;
  fs::create_directories(options.out, error);
  if (error) {
    return core::Fail(core::ErrorCode::kIo,
                      "make folder " + options.out.string() + ": " + error.message());
  }
  return Builder(options, std::move(*survey), std::move(*map)).Run(progress);
}

}  // namespace kawara::mapper
