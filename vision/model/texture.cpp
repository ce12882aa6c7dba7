#include "vision/model/texture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "vision/model/view_choice.hpp"

namespace kawara::vision {
namespace {

constexpr int kMarginPx = 1;      // around a square, so that neighbours do not shine in
constexpr int kLeastPatchPx = 4;  // margin, two texels, margin
constexpr int kJpegBlockPx = 16;

/// Squares of one size in rows: all quads are about a voxel large.
struct Atlas {
  int patch_px = 0, columns = 0, width_px = 0, height_px = 0;

  static std::optional<Atlas> For(std::size_t quads, int patch_px, int max_px) {
    Atlas a;
    a.patch_px = patch_px;
    const auto round_up = [](int v) {
      return (v + kJpegBlockPx - 1) / kJpegBlockPx * kJpegBlockPx;
    };
    const int most = max_px / patch_px;
    a.columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(static_cast<double>(quads)))));
    if (a.columns > most) return std::nullopt;
    const auto rows = static_cast<int>((quads + static_cast<std::size_t>(a.columns) - 1) /
                                       static_cast<std::size_t>(a.columns));
    a.width_px = round_up(a.columns * patch_px);
    a.height_px = round_up(rows * patch_px);
    return a;
  }
  int left(std::size_t quad) const {
    return static_cast<int>(quad % static_cast<std::size_t>(columns)) * patch_px;
  }
  int top(std::size_t quad) const {
    return static_cast<int>(quad / static_cast<std::size_t>(columns)) * patch_px;
  }
};

std::uint8_t ToByte(double v) { return static_cast<std::uint8_t>(std::clamp(v + 0.5, 0.0, 255.0)); }

// Between four values at the corners of the unit square, in their order around it.
template <class T>
T Between(const std::array<T, 4>& at, double s, double t) {
  return T((1 - t) * ((1 - s) * at[0] + s * at[1]) + t * ((1 - s) * at[3] + s * at[2]));
}

class Painter {
 public:
  Painter(const Atlas& atlas, std::vector<std::uint8_t>& pixels) : atlas_(atlas), pixels_(pixels) {}

  /// colour(s, t): RGB at a place of the quad; a little outside of it for the margin.
  template <class Colour>
  void Paint(std::size_t quad, const Colour& colour) {
    const double inner = atlas_.patch_px - 2 * kMarginPx;
    for (int y = 0; y < atlas_.patch_px; ++y) {
      for (int x = 0; x < atlas_.patch_px; ++x) {
        const auto rgb = colour((x + 0.5 - kMarginPx) / inner, (y + 0.5 - kMarginPx) / inner);
        const auto at = (static_cast<std::size_t>(atlas_.top(quad) + y) *
                             static_cast<std::size_t>(atlas_.width_px) +
                         static_cast<std::size_t>(atlas_.left(quad) + x)) *
                        kRgbBytes;
        for (std::size_t c = 0; c < 3; ++c) pixels_[at + c] = ToByte(rgb[c]);
      }
    }
  }

 private:
  const Atlas& atlas_;
  std::vector<std::uint8_t>& pixels_;
};

core::TexturedMesh UnshareCorners(const Surface& surface, const Atlas& atlas) {
  const core::TexturedMesh& old = surface.mesh;
  core::TexturedMesh mesh;
  mesh.name = old.name;
  mesh.revision = old.revision;
  mesh.offset_m = old.offset_m;
  for (std::size_t q = 0; q < surface.quads.size(); ++q) {
    const auto base = static_cast<std::uint32_t>(4 * q);
    const double left = atlas.left(q) + kMarginPx, top = atlas.top(q) + kMarginPx;
    const double side = atlas.patch_px - 2 * kMarginPx;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t corner = surface.quads[q][i];
      mesh.positions_m.push_back(old.positions_m[corner]);
      mesh.normals.push_back(old.normals[corner]);
      mesh.colours.push_back(old.colours[corner]);
      const double s = i == 1 || i == 2 ? side : 0.0, t = i >= 2 ? side : 0.0;
      mesh.texture_coordinates.push_back({static_cast<float>((left + s) / atlas.width_px),
                                          static_cast<float>((top + t) / atlas.height_px)});
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
    mesh.triangles.push_back({base, base + 2, base + 3});
  }
  return mesh;
}

bool RangesFit(const TextureView& view) {
  if (view.ranges == nullptr) return true;
  const int width = view.camera.width_px(), height = view.camera.height_px();
  const RangeImage& ranges = *view.ranges;
  const auto pixels =
      static_cast<std::size_t>(ranges.width_px) * static_cast<std::size_t>(ranges.height_px);
  if (ranges.range_m.size() != pixels || (!ranges.sd_m.empty() && ranges.sd_m.size() != pixels))
    return false;
  return (ranges.width_px == width && ranges.height_px == height) ||
         (ranges.width_px == (width + 1) / 2 && ranges.height_px == (height + 1) / 2);
}

}  // namespace

core::Expected<void> CheckView(const TextureView& view) {
  const bool same = view.picture.width_px == view.camera.width_px() &&
                    view.picture.height_px == view.camera.height_px() && !view.picture.empty();
  if (!same || !RangesFit(view) || !view.map_from_camera.matrix().allFinite())
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "texture: picture, distance image and camera differ in size, or a pose is "
                      "not finite");
  return {};
}

RangeImage RangesForTexture(const RangeImage& ranges) {
  RangeImage half;
  half.width_px = (ranges.width_px + 1) / 2;
  half.height_px = (ranges.height_px + 1) / 2;
  half.range_m.reserve(static_cast<std::size_t>(half.width_px) *
                       static_cast<std::size_t>(half.height_px));
  for (int v = 0; v < ranges.height_px; v += 2) {
    for (int u = 0; u < ranges.width_px; u += 2) {
      half.range_m.push_back(ranges.range_m[ranges.index(u, v)]);
    }
  }
  return half;
}

core::Expected<TextureCounts> ApplyTexture(Surface& surface, double voxel_m,
                                           std::span<const TextureView> views,
                                           const TextureConfig& config, JpegEncoder& encoder) {
  for (const TextureView& view : views)
    if (auto good = CheckView(view); !good) return tl::unexpected(good.error());
  TextureCounts counts{.quads = surface.quads.size()};
  if (surface.quads.empty()) return counts;
  int patch_px = std::max(kLeastPatchPx,
                          static_cast<int>(std::ceil(voxel_m / config.texel_m)) + 2 * kMarginPx);
  auto atlas = Atlas::For(surface.quads.size(), patch_px, config.max_atlas_px);
  while (!atlas && patch_px > kLeastPatchPx)
    atlas = Atlas::For(surface.quads.size(), --patch_px, config.max_atlas_px);
  if (!atlas)
    return core::Fail(core::ErrorCode::kFull, "texture: " + std::to_string(counts.quads) +
                                                  " quads do not fit an atlas of " +
                                                  std::to_string(config.max_atlas_px) +
                                                  " px (smaller tiles or larger voxels)");

  const ViewChoice choice = ChooseViews(surface, voxel_m, views, config);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(atlas->width_px) *
                                   static_cast<std::size_t>(atlas->height_px) * kRgbBytes);
  Painter painter(*atlas, pixels);
  for (std::size_t q = 0; q < surface.quads.size(); ++q) {
    const Quad& quad = surface.quads[q];
    const int v = choice.view_of_quad[q];
    if (v == ViewChoice::kNone) {
      std::array<Eigen::Array3d, 4> corners;
      for (std::size_t i = 0; i < 4; ++i) {
        const auto& c = surface.mesh.colours[quad[i]];
        corners[i] = Eigen::Array3i(c[0], c[1], c[2]).cast<double>();
      }
      painter.Paint(q, [&](double s, double t) {
        const Eigen::Array3d c = Between(corners, s, t);
        return std::array{c.x(), c.y(), c.z()};
      });
      continue;
    }
    // A voxel is small: within it the picture's pixels lie as good as evenly.
    const TextureView& view = views[static_cast<std::size_t>(v)];
    const QuadPlace place = PlaceOf(surface.mesh, quad);
    std::array<Eigen::Vector2d, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = *PixelOf(view, place.corners[i]);
    const auto& gain = choice.gains[static_cast<std::size_t>(v)];
    painter.Paint(q, [&](double s, double t) {
      auto rgb = SampleAt(view.picture, Between(corners, s, t));
      for (std::size_t c = 0; c < 3; ++c) rgb[c] *= gain[c];
      return rgb;
    });
    ++counts.from_pictures;
  }
  const auto jpeg = encoder.Encode({pixels.data(), atlas->width_px, atlas->height_px},
                                   {.quality = config.jpeg_quality});
  if (!jpeg) return tl::unexpected(jpeg.error());
  core::TexturedMesh mesh = UnshareCorners(surface, *atlas);
  mesh.texture_jpeg.assign(jpeg->begin(), jpeg->end());
  surface.mesh = std::move(mesh);
  for (std::size_t q = 0; q < surface.quads.size(); ++q)
    for (std::size_t i = 0; i < 4; ++i) surface.quads[q][i] = static_cast<std::uint32_t>(4 * q + i);
  return counts;
}

}  // namespace kawara::vision
