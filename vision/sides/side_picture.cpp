#include "vision/sides/side_picture.hpp"

#include <algorithm>
#include <array>

#include "vision/sides/side_choice.hpp"
#include "vision/sides/side_patch.hpp"

namespace kawara::vision {
namespace {

constexpr int kStep = SideGrid::kStep;

/// Colours of a side times how much of each texel is known, and that.
class Canvas {
 public:
  explicit Canvas(const SideGrid& grid)
      : grid_(grid), colour_(grid.cells() * kStep * kStep), known_(colour_.size(), 0.0F) {}

  void Paint(const SideChoice& choice, std::span<const SidePatch> patches) {
    for (int j = 0; j < grid_.cell_rows; ++j)
      for (int i = 0; i < grid_.cell_columns; ++i) {
        const std::array<int, 4> who{
            choice.of_node[grid_.node(i, j)], choice.of_node[grid_.node(i + 1, j)],
            choice.of_node[grid_.node(i + 1, j + 1)], choice.of_node[grid_.node(i, j + 1)]};
        for (std::size_t corner = 0; corner < who.size(); ++corner) {
          if (who[corner] == SideChoice::kNone) continue;
          const auto k = static_cast<std::size_t>(who[corner]);
          AddCorner(i, j, corner, patches[k], choice.gains[k]);
        }
      }
  }

  double KnownShare() const {
    double sum = 0.0;
    for (const float known : known_) sum += static_cast<double>(known);
    return std::min(1.0, sum / static_cast<double>(known_.size()));
  }

  std::vector<std::uint8_t> Finish() const {
    std::array<double, 3> mean{};
    double known = 0.0;
    for (std::size_t t = 0; t < known_.size(); ++t) {
      known += static_cast<double>(known_[t]);
      for (std::size_t c = 0; c < 3; ++c) mean[c] += static_cast<double>(colour_[t][c]);
    }
    std::vector<std::uint8_t> rgb;
    rgb.reserve(3 * known_.size());
    for (std::size_t t = 0; t < known_.size(); ++t)
      for (std::size_t c = 0; c < 3; ++c) {
        const float plain = static_cast<float>(mean[c] / known) * (1.0F - known_[t]);
        rgb.push_back(
            static_cast<std::uint8_t>(std::clamp(colour_[t][c] + plain + 0.5F, 0.0F, 255.0F)));
      }
    return rgb;
  }

 private:
  /// What a cell has of one of its nodes: all there, nothing at the other three.
  void AddCorner(int i, int j, std::size_t corner, const SidePatch& patch,
                 const std::array<float, 3>& gain) {
    const bool right = corner == 1 || corner == 2, lower = corner >= 2;
    for (int y = 0; y < kStep; ++y)
      for (int x = 0; x < kStep; ++x) {
        const float s = (static_cast<float>(x) + 0.5F) / kStep;
        const float t = (static_cast<float>(y) + 0.5F) / kStep;
        const float weight = (right ? s : 1.0F - s) * (lower ? t : 1.0F - t);
        const std::size_t texel =
            static_cast<std::size_t>(j * kStep + y) * static_cast<std::size_t>(grid_.width_px()) +
            static_cast<std::size_t>(i * kStep + x);
        known_[texel] += weight;
        for (std::size_t c = 0; c < 3; ++c)
          colour_[texel][c] += weight * gain[c] * static_cast<float>(patch.rgb[3 * texel + c]);
      }
  }

  const SideGrid& grid_;
  std::vector<std::array<float, 3>> colour_;
  std::vector<float> known_;
};

}  // namespace

SidePicture PaintSide(const SideGrid& grid, std::span<const SideView> views,
                      const LookRules& rules) {
  std::vector<SideLook> looks;
  for (const SideView& view : views) looks.push_back(LookAtSide(grid, view, rules));
  const std::vector<std::size_t> worth = WorthRectifying(grid, looks);
  if (worth.empty()) return {};
  std::vector<SidePatch> patches;
  patches.reserve(worth.size());
  for (const std::size_t k : worth)
    patches.push_back(RectifySide(grid, looks[k], views[k].view.picture));
  const std::vector<float> sharpness = Sharpness(grid, patches);
  std::vector<SideCandidate> candidates;
  for (std::size_t k = 0; k < worth.size(); ++k)
    candidates.push_back({looks[worth[k]], patches[k], sharpness[k]});
  const SideChoice choice = ChooseForNodes(grid, candidates);
  Canvas canvas(grid);
  canvas.Paint(choice, patches);
  return {.rgb = canvas.Finish(),
          .seen_share = canvas.KnownShare(),
          .main_view = worth[static_cast<std::size_t>(choice.main)]};
}

}  // namespace kawara::vision
