#include "vision/sides/side_patch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace kawara::vision {
namespace {

constexpr int kStep = SideGrid::kStep;
constexpr int kMostSamples = 4;      // a texel and direction
constexpr int kFractionBits = 8;     // of a pixel
constexpr double kDarkLevel = 16.0;  // below it noise is most of a logarithm

/// Bilinear, added to `sum` in units of 2^-16 levels; at the border the nearest pixels.
void AddSample(const ConstImageView& picture, const Eigen::Vector2f& pixel,
               std::array<std::uint64_t, 3>& sum) {
  constexpr int kOne = 1 << kFractionBits;
  const auto fixed = [](float at, int size) {
    return std::clamp(static_cast<int>(at * kOne), 0, (size - 1) * kOne);
  };
  const int u = fixed(pixel.x(), picture.width_px), v = fixed(pixel.y(), picture.height_px);
  const int column = u >> kFractionBits, row = v >> kFractionBits;
  const auto right = static_cast<std::uint32_t>(u & (kOne - 1));
  const auto down = static_cast<std::uint32_t>(v & (kOne - 1));
  const std::uint8_t* const upper = picture.row(row) + std::ptrdiff_t{kRgbBytes} * column;
  const std::size_t next = column + 1 < picture.width_px ? std::size_t{kRgbBytes} : 0;
  const std::uint8_t* const lower =
      row + 1 < picture.height_px ? upper + picture.stride_bytes() : upper;
  for (std::size_t c = 0; c < 3; ++c)
    sum[c] += (kOne - down) * ((kOne - right) * upper[c] + right * upper[next + c]) +
              down * ((kOne - right) * lower[c] + right * lower[next + c]);
}

const std::array<float, 256>& Logarithms() {
  static const auto kTable = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i)
      table[i] = static_cast<float>(std::log(static_cast<double>(i) + kDarkLevel));
    return table;
  }();
  return kTable;
}

class Rectifier {
 public:
  Rectifier(const SideGrid& grid, const SideLook& look, const ConstImageView& picture)
      : grid_(grid), look_(look), picture_(picture) {}

  SidePatch Draw() {
    SidePatch patch;
    patch.rgb.assign(grid_.cells() * kStep * kStep * kRgbBytes, 0);
    patch.whole.assign(grid_.cells(), 0);
    patch.detail.assign(grid_.cells(), 0.0F);
    for (int j = 0; j < grid_.cell_rows; ++j)
      for (int i = 0; i < grid_.cell_columns; ++i) {
        const std::array nodes{grid_.node(i, j), grid_.node(i + 1, j), grid_.node(i + 1, j + 1),
                               grid_.node(i, j + 1)};
        const auto used = std::count_if(nodes.begin(), nodes.end(),
                                        [this](std::size_t n) { return look_.quality[n] > 0.0F; });
        if (used == 0) continue;
        DrawCell(nodes, i, j, patch);
        if (used < 4) continue;
        patch.whole[grid_.cell(i, j)] = 1;
        patch.detail[grid_.cell(i, j)] = Detail(patch, i, j);
      }
    return patch;
  }

 private:
  std::size_t Texel(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(grid_.width_px()) +
            static_cast<std::size_t>(x)) *
           kRgbBytes;
  }

  void DrawCell(const std::array<std::size_t, 4>& nodes, int i, int j, SidePatch& patch) const {
    const Eigen::Vector2f first = look_.pixel[nodes[0]];
    const Eigen::Vector2f across = look_.pixel[nodes[1]] - first;
    const Eigen::Vector2f along = look_.pixel[nodes[3]] - first;
    const Eigen::Vector2f twist = look_.pixel[nodes[2]] - first - across - along;
    const auto samples = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
      const float stretch = std::max(a.norm(), b.norm()) / kStep;
      return std::clamp(static_cast<int>(std::lround(stretch)), 1, kMostSamples);
    };
    const int per_column = samples(across, across + twist);
    const int per_row = samples(along, along + twist);
    const int columns = kStep * per_column, rows = kStep * per_row;
    std::array<std::array<std::uint64_t, 3>, std::size_t{kStep} * kStep> sums{};
    for (int y = 0; y < rows; ++y) {
      const float t = (static_cast<float>(y) + 0.5F) / static_cast<float>(rows);
      const Eigen::Vector2f start = first + t * along, step = across + t * twist;
      for (int x = 0; x < columns; ++x) {
        const float s = (static_cast<float>(x) + 0.5F) / static_cast<float>(columns);
        const int texel = y * kStep / rows * kStep + x * kStep / columns;
        AddSample(picture_, start + s * step, sums[static_cast<std::size_t>(texel)]);
      }
    }
    const auto parts = static_cast<std::uint64_t>(per_column * per_row) << (2 * kFractionBits);
    for (int y = 0; y < kStep; ++y)
      for (int x = 0; x < kStep; ++x) {
        const int texel = y * kStep + x;
        const auto& sum = sums[static_cast<std::size_t>(texel)];
        for (std::size_t c = 0; c < 3; ++c)
          patch.rgb[Texel(i * kStep + x, j * kStep + y) + c] =
              static_cast<std::uint8_t>((sum[c] + parts / 2) / parts);
      }
  }

  float Detail(const SidePatch& patch, int i, int j) const {
    std::array<std::array<float, kStep>, kStep> light{};
    for (std::size_t y = 0; y < kStep; ++y)
      for (std::size_t x = 0; x < kStep; ++x) {
        const std::uint8_t* const rgb =
            &patch.rgb[Texel(i * kStep + static_cast<int>(x), j * kStep + static_cast<int>(y))];
        light[y][x] = Logarithms()[static_cast<std::size_t>((rgb[0] + 2 * rgb[1] + rgb[2]) / 4)];
      }
    float sum = 0.0F;
    for (std::size_t a = 0; a < kStep; ++a)
      for (std::size_t b = 1; b < kStep; ++b) {
        const float across = light[a][b] - light[a][b - 1], along = light[b][a] - light[b - 1][a];
        sum += across * across + along * along;
      }
    return sum;
  }

  const SideGrid& grid_;
  const SideLook& look_;
  const ConstImageView& picture_;
};

}  // namespace

SidePatch RectifySide(const SideGrid& grid, const SideLook& look, const ConstImageView& picture) {
  return Rectifier(grid, look, picture).Draw();
}

std::array<float, 3> MeanOfCell(const SideGrid& grid, const SidePatch& patch, int i, int j) {
  std::array<int, 3> sum{};
  for (int y = 0; y < kStep; ++y) {
    const std::uint8_t* rgb = &patch.rgb[(static_cast<std::size_t>(j * kStep + y) *
                                              static_cast<std::size_t>(grid.width_px()) +
                                          static_cast<std::size_t>(i) * kStep) *
                                         kRgbBytes];
    for (int x = 0; x < kStep; ++x)
      for (std::size_t c = 0; c < 3; ++c) sum[c] += *rgb++;
  }
  constexpr float kShare = 1.0F / (kStep * kStep);
  return {kShare * static_cast<float>(sum[0]), kShare * static_cast<float>(sum[1]),
          kShare * static_cast<float>(sum[2])};
}

}  // namespace kawara::vision
