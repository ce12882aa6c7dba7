#include "vision/sides/side_texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/sides/atlas_layout.hpp"
#include "vision/sides/side_picture.hpp"

namespace kawara::vision {
namespace {

constexpr double kSigmas = 3.0;
constexpr double kCoarser = 1.1;  // at a time, until it fits
constexpr int kLeastAtlasPx = 64;

struct PaintedSide {
  core::BoxSide side;
  SideGrid grid;
  SidePicture picture;
};

core::Expected<void> Check(const core::ChangedObject& object, std::span<const SideView> views,
                           const SideTextureConfig& config) {
  const auto wrong = [](const std::string& what) {
    return core::Fail(core::ErrorCode::kInvalidArgument, "side textures: " + what);
  };
  const core::UprightBox& box = object.box;
  if (!box.centre_m.allFinite() || !box.size_m.allFinite() || !(box.size_m.minCoeff() > 0.0) ||
      !std::isfinite(box.heading_rad) || !object.covariance.allFinite())
    return wrong("the box of " + object.uid + " is not finite or without volume");
  if (!(config.texel_m > 0.0) || config.max_atlas_px < kLeastAtlasPx ||
      !(config.min_incidence_cos > 0.0 && config.min_incidence_cos < 1.0) ||
      !(config.depth_margin_m >= 0.0))
    return wrong("texels, atlas, incidence or margin out of range");
  for (const SideView& view : views) {
    if (auto good = CheckView(view.view); !good) return good;
    const ConstImageView& picture = view.view.picture;
    if (!view.mask.empty() && view.mask.size() * kRgbBytes != picture.size_bytes())
      return wrong("the mask of " + view.source + " is not of its picture's size");
  }
  return {};
}

/// Sides that may get a picture.
std::vector<core::BoxSide> SidesOf(const core::ChangedObject& object,
                                   std::span<const SideView> views) {
  std::vector<core::BoxSide> sides;
  for (std::size_t i = 0; i < core::kBoxSides; ++i) {
    const auto side = static_cast<core::BoxSide>(i);
    const double top_m = object.box.centre_m.z() + object.box.size_m.z() / 2;
    const bool wanted = side == core::BoxSide::kTop
                            ? std::any_of(views.begin(), views.end(),
                                          [top_m](const SideView& v) {
                                            return v.view.map_from_camera.translation().z() > top_m;
                                          })
                            : object.side_seen[i];
    if (wanted) sides.push_back(side);
  }
  return sides;
}

std::vector<std::array<int, 2>> SizesOf(const std::vector<PaintedSide>& painted) {
  std::vector<std::array<int, 2>> sizes;
  sizes.reserve(painted.size());
  for (const PaintedSide& p : painted) sizes.push_back({p.grid.width_px(), p.grid.height_px()});
  return sizes;
}

/// Their grids, of the finest texels that fit the atlas.
std::vector<PaintedSide> GridsOf(const core::UprightBox& box,
                                 const std::vector<core::BoxSide>& sides,
                                 const SideTextureConfig& config) {
  // An atlas never holds a side that is longer than it.
  double texel_m = std::max(config.texel_m, box.size_m.maxCoeff() / config.max_atlas_px);
  for (;; texel_m *= kCoarser) {
    std::vector<PaintedSide> painted;
    painted.reserve(sides.size());
    for (const core::BoxSide side : sides)
      painted.push_back({side, GridOf(box, side, texel_m), {}});
    if (LayOut(SizesOf(painted), config.max_atlas_px)) return painted;
  }
}

/// The picture with its edge going on around it.
void Put(const PaintedSide& painted, const std::array<int, 2>& place, const ImageView& atlas) {
  const int width = painted.grid.width_px(), height = painted.grid.height_px();
  for (int y = -AtlasLayout::kMarginPx; y < height + AtlasLayout::kMarginPx; ++y)
    for (int x = -AtlasLayout::kMarginPx; x < width + AtlasLayout::kMarginPx; ++x) {
      const std::size_t from = 3 * (static_cast<std::size_t>(std::clamp(y, 0, height - 1)) *
                                        static_cast<std::size_t>(width) +
                                    static_cast<std::size_t>(std::clamp(x, 0, width - 1)));
      std::copy_n(&painted.picture.rgb[from], 3,
                  atlas.row(place[1] + y) + std::ptrdiff_t{kRgbBytes} * (place[0] + x));
    }
}

}  // namespace

core::Expected<core::ObjectTextures> MakeSideTextures(const core::ChangedObject& object,
                                                      std::span<const SideView> views,
                                                      const SideTextureConfig& config,
                                                      JpegEncoder& encoder) {
  if (auto good = Check(object, views, config); !good) return tl::unexpected(good.error());
  std::vector<PaintedSide> painted = GridsOf(object.box, SidesOf(object, views), config);
  for (PaintedSide& p : painted) {
    const LookRules rules{
        .min_incidence_cos = config.min_incidence_cos,
        .depth_margin_m = config.depth_margin_m + kSigmas * SideDeviation(object, p.side)};
    p.picture = PaintSide(p.grid, views, rules);
  }
  std::erase_if(painted, [&](const PaintedSide& p) {
    return p.picture.rgb.empty() || p.picture.seen_share < config.min_seen_share;
  });
  core::ObjectTextures textures;
  if (painted.empty()) return textures;
  const auto layout = LayOut(SizesOf(painted), config.max_atlas_px);
  if (!layout)  // fewer sides than fitted before
    return core::Fail(core::ErrorCode::kFull, "side textures: the atlas is too small");
  constexpr std::uint8_t kGrey = 128;
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(layout->width_px) *
                                       static_cast<std::size_t>(layout->height_px) * kRgbBytes,
                                   kGrey);
  const ImageView atlas{pixels.data(), layout->width_px, layout->height_px};
  for (std::size_t i = 0; i < painted.size(); ++i) {
    Put(painted[i], layout->place[i], atlas);
    const double left = layout->place[i][0], top = layout->place[i][1];
    const double right = left + painted[i].grid.width_px();
    const double bottom = top + painted[i].grid.height_px();
    const SideView& main = views[painted[i].picture.main_view];
    textures.faces.push_back({painted[i].side,
                              {{{left, top}, {right, top}, {right, bottom}, {left, bottom}}},
                              main.source,
                              main.taken,
                              painted[i].picture.seen_share});
  }
  const auto jpeg = encoder.Encode(atlas, {.quality = config.jpeg_quality});
  if (!jpeg) return tl::unexpected(jpeg.error());
  textures.atlas_jpeg.assign(jpeg->begin(), jpeg->end());
  textures.width_px = static_cast<std::uint32_t>(layout->width_px);
  textures.height_px = static_cast<std::uint32_t>(layout->height_px);
  return textures;
}

}  // namespace kawara::vision
