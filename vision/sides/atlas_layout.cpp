#include "vision/sides/atlas_layout.hpp"

#include <algorithm>
#include <numeric>

namespace kawara::vision {
namespace {

constexpr int kBlockPx = 16;  // of a JPEG with colours of half the size

}  // namespace

std::optional<AtlasLayout> LayOut(std::span<const std::array<int, 2>> sizes, int max_px) {
  const int limit = max_px / kBlockPx * kBlockPx;
  const auto blocks = [](int px) { return (px + kBlockPx - 1) / kBlockPx * kBlockPx; };
  std::vector<std::size_t> order(sizes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return sizes[a][1] > sizes[b][1]; });
  AtlasLayout layout;
  layout.place.resize(sizes.size());
  int left = 0, top = 0, bottom = 0;
  for (const std::size_t k : order) {
    const int width = sizes[k][0] + 2 * AtlasLayout::kMarginPx;
    const int height = sizes[k][1] + 2 * AtlasLayout::kMarginPx;
    if (left + width > limit) {
      left = 0;
      top = bottom;
    }
    if (width > limit || top + height > limit) return std::nullopt;
    layout.place[k] = {left + AtlasLayout::kMarginPx, top + AtlasLayout::kMarginPx};
    left += width;
    bottom = std::max(bottom, top + height);
    layout.width_px = std::max(layout.width_px, blocks(left));
    layout.height_px = std::max(layout.height_px, blocks(bottom));
  }
  return layout;
}

}  // namespace kawara::vision
