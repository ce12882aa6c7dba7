#include "vision/stereo/disparity_refiner.hpp"

#include <algorithm>
#include <cmath>

#include "core/check.hpp"

namespace kawara::vision {
namespace {

using refine::kNone;
using refine::kPad;
using refine::kRadius;

constexpr int kIterations = 2;
/// Half-size pixels apart: still the same surface.
constexpr float kSameSurface = 1.0F;
/// The least an 8-bit picture's residual can be; squared levels.
constexpr float kLeastNoise = 1.0F;
/// A residual of this many times the median has half the weight.
constexpr float kSoftness = 4.0F;

std::array<float, 3> Levels(std::uint32_t rgbx) {
  return {static_cast<float>(rgbx & 0xFF), static_cast<float>(rgbx >> 8 & 0xFF),
          static_cast<float>(rgbx >> 16 & 0xFF)};
}

}  // namespace

void DisparityRefiner::Row::Resize(std::size_t width) {
  disparity.assign(width + 2 * kPad, kNone);
  for (auto* row : {&slope_error, &slope_square, &error_square, &slope_cross, &support})
    row->assign(width + 2 * kPad, 0.0F);
}

refine::SmoothRow DisparityRefiner::Row::view() {
  return {disparity.data() + kPad,
          {slope_error.data() + kPad, slope_square.data() + kPad, error_square.data() + kPad,
           slope_cross.data() + kPad},
          support.data() + kPad};
}

void DisparityRefiner::Enlarge(const std::vector<float>& coarse_px) {
  const int half_width = width_ / 2, half_height = height_ / 2;
  disparity_.assign(stride_ * static_cast<std::size_t>(height_), kNone);
  for (int y = 0; y < height_; ++y) {
    // The nearest half-size row and the one on the other side.
    const int near_y = y / 2;
    const int far_y = std::clamp(y % 2 == 0 ? near_y - 1 : near_y + 1, 0, half_height - 1);
    const float* near_row =
        coarse_px.data() + static_cast<std::size_t>(near_y) * static_cast<std::size_t>(half_width);
    const float* far_row =
        coarse_px.data() + static_cast<std::size_t>(far_y) * static_cast<std::size_t>(half_width);
    float* out = disparity_row(y);
    for (int x = 0; x < width_; ++x) {
      const int near_x = x / 2;
      const int far_x = std::clamp(x % 2 == 0 ? near_x - 1 : near_x + 1, 0, half_width - 1);
      const float nearest = near_row[near_x];
      if (nearest < 0.0F) continue;
      float sum = 9.0F * nearest, weight = 9.0F;
      const auto add = [&](float other, float w) {
        const bool same = other >= 0.0F && std::abs(other - nearest) < kSameSurface;
        sum += same ? w * other : 0.0F;
        weight += same ? w : 0.0F;
      };
      add(near_row[far_x], 3.0F);
      add(far_row[near_x], 3.0F);
      add(far_row[far_x], 1.0F);
      out[x] = 2.0F * sum / weight;
    }
  }
}

void DisparityRefiner::FindGains(const RectifiedPicture& a, const RectifiedPicture& b) {
  blocks_x_ = (width_ + kGainBlock - 1) / kGainBlock;
  blocks_y_ = (height_ + kGainBlock - 1) / kGainBlock;
  struct Sums {
    std::array<float, 3> a{}, b{};
  };
  std::vector<Sums> blocks(static_cast<std::size_t>(blocks_x_ * blocks_y_));
  Sums everywhere;
  for (int y = 0; y < height_; y += 2) {
    const float* disparity = disparity_row(y);
    for (int x = 0; x < width_; x += 2) {
      if (disparity[x] < 0.0F) continue;
      const int to = x + static_cast<int>(disparity[x] + 0.5F);
      if (to >= width_ || !Seen(a.row(y)[x]) || !Seen(b.row(y)[to])) continue;
      Sums& sums = blocks[static_cast<std::size_t>(y / kGainBlock * blocks_x_ + x / kGainBlock)];
      const auto level_a = Levels(a.row(y)[x]), level_b = Levels(b.row(y)[to]);
      for (std::size_t c = 0; c < 3; ++c) {
        sums.a[c] += level_a[c];
        sums.b[c] += level_b[c];
      }
    }
  }
  for (const Sums& sums : blocks) {
    for (std::size_t c = 0; c < 3; ++c) {
      everywhere.a[c] += sums.a[c];
      everywhere.b[c] += sums.b[c];
    }
  }
  // The whole picture's gain counts in every block as this many pixels of medium grey.
  constexpr float kPrior = 64.0F * 100.0F;
  gains_.resize(blocks.size());
  for (int by = 0; by < blocks_y_; ++by) {
    for (int bx = 0; bx < blocks_x_; ++bx) {
      for (std::size_t c = 0; c < 3; ++c) {
        const float common =
            std::clamp((everywhere.a[c] + 1.0F) / (everywhere.b[c] + 1.0F), 0.25F, 4.0F);
        float sum_a = kPrior * common, sum_b = kPrior;
        for (int dy = -1; dy <= 1; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            const int yy = by + dy, xx = bx + dx;
            if (yy < 0 || xx < 0 || yy >= blocks_y_ || xx >= blocks_x_) continue;
            const Sums& sums = blocks[static_cast<std::size_t>(yy * blocks_x_ + xx)];
            const float weight = (dx == 0 ? 2.0F : 1.0F) * (dy == 0 ? 2.0F : 1.0F);
            sum_a += weight * sums.a[c];
            sum_b += weight * sums.b[c];
          }
        }
        gains_[static_cast<std::size_t>(by * blocks_x_ + bx)][c] = sum_a / sum_b;
      }
    }
  }
}

void DisparityRefiner::GainsOfRow(int y) {
  // Between the centres of the blocks, linear; beyond the outermost, theirs.
  const float at = (static_cast<float>(y) + 0.5F) / kGainBlock - 0.5F;
  const int upper = std::clamp(static_cast<int>(std::floor(at)), 0, blocks_y_ - 1);
  const int lower = std::min(upper + 1, blocks_y_ - 1);
  const float down = std::clamp(at - static_cast<float>(upper), 0.0F, 1.0F);
  for (std::size_t c = 0; c < 3; ++c) {
    const auto of_block = [&](int bx) {
      const int column = std::clamp(bx, 0, blocks_x_ - 1);
      const float top = gains_[static_cast<std::size_t>(upper * blocks_x_ + column)][c];
      const float bottom = gains_[static_cast<std::size_t>(lower * blocks_x_ + column)][c];
      return top + down * (bottom - top);
    };
    // A line of columns lies between two centres.
    static_assert(kGainBlock == 2 * static_cast<int>(refine::kGainColumns));
    for (std::size_t k = 0; k < row_gains_[c].size(); ++k) {
      const int bx = (static_cast<int>(k) + 1) / 2 - 1;
      const float left = of_block(bx), rise = (of_block(bx + 1) - left) / kGainBlock;
      const float centre = (static_cast<float>(bx) + 0.5F) * kGainBlock - 0.5F;
      row_gains_[c][k] = {left - rise * centre, rise};
    }
  }
}

refine::ResidualRow DisparityRefiner::RowOf(const RectifiedPicture& a, const RectifiedPicture& b,
                                            int y, float softness) {
  GainsOfRow(y);
  return {.a = a.row(y),
          .above = a.row(std::max(y - 1, 0)),
          .below = a.row(std::min(y + 1, height_ - 1)),
          .b = b.row(y),
          .disparity = disparity_row(y),
          .gain = {row_gains_[0].data(), row_gains_[1].data(), row_gains_[2].data()},
          .width = static_cast<std::size_t>(width_),
          .softness = softness};
}

float DisparityRefiner::FindNoise(const RectifiedPicture& a, const RectifiedPicture& b) {
  squares_.clear();
  const refine::SmoothRow here = here_.view();
  for (int y = 4; y < height_; y += 16) {
    refine::Residuals(RowOf(a, b, y, 0.0F), here.evidence);
    for (int x = 0; x < width_; ++x) {
      if (here.evidence.slope_square[x] > 0.0F) squares_.push_back(here.evidence.error_square[x]);
    }
  }
  if (squares_.empty()) return kLeastNoise;
  const auto middle = squares_.begin() + static_cast<std::ptrdiff_t>(squares_.size() / 2);
  std::nth_element(squares_.begin(), middle, squares_.end());
  return std::max(kLeastNoise, *middle);
}

void DisparityRefiner::Iterate(const RectifiedPicture& a, const RectifiedPicture& b,
                               float noise_square, std::vector<float>* sd_px) {
  const auto width = static_cast<std::size_t>(width_);
  constexpr int kRows = 2 * kRadius + 1;
  std::array<refine::SmoothRow, kRows> views;
  for (int k = 0; k < kRows; ++k) {
    views[static_cast<std::size_t>(k)] = along_[static_cast<std::size_t>(k)].view();
  }
  const refine::SmoothRow here = here_.view(), result = result_.view();
  const auto prepare = [&](int y) {
    refine::Residuals(RowOf(a, b, y, 1.0F / (kSoftness * noise_square)), here.evidence);
    refine::SmoothAlong({disparity_row(y), here.evidence, here.support}, width,
                        views[static_cast<std::size_t>(y % kRows)]);
  };
  for (int y = 0; y < std::min(kRadius, height_); ++y) prepare(y);
  for (int y = 0; y < height_; ++y) {
    if (y + kRadius < height_) prepare(y + kRadius);
    std::array<const refine::SmoothRow*, kRows> rows{};
    for (int k = -kRadius; k <= kRadius; ++k) {
      const int row = y + k;
      if (row >= 0 && row < height_)
        rows[static_cast<std::size_t>(k + kRadius)] = &views[static_cast<std::size_t>(row % kRows)];
    }
    refine::SmoothAcross(rows.data(), width, result);
    refine::Advance(result, width, disparity_row(y));
    if (sd_px != nullptr) {
      refine::Deviations(result, width, sd_px->data() + static_cast<std::size_t>(y) * width);
    }
  }
}

void DisparityRefiner::Refine(const RectifiedPicture& a, const RectifiedPicture& b,
                              const std::vector<float>& coarse_px, DisparityField& field) {
  width_ = a.grid.width_px;
  height_ = a.grid.height_px;
  CORE_CHECK(b.grid.width_px == width_ && b.grid.height_px == height_);
  CORE_CHECK(coarse_px.size() == a.grid.pixels() / 4);
  const auto width = static_cast<std::size_t>(width_);
  stride_ = width + 2 * kPad;
  for (Row& row : along_) row.Resize(width);
  here_.Resize(width);
  result_.Resize(width);
  for (auto& gains : row_gains_) gains.resize(width / refine::kGainColumns + 1);
  Enlarge(coarse_px);
  FindGains(a, b);
  field.sd_px.resize(a.grid.pixels());
  for (int i = 0; i < kIterations; ++i) {
    Iterate(a, b, FindNoise(a, b), i + 1 == kIterations ? &field.sd_px : nullptr);
  }
  field.disparity_px.resize(a.grid.pixels());
  for (int y = 0; y < height_; ++y) {
    std::copy_n(disparity_row(y), width,
                field.disparity_px.begin() +
                    static_cast<std::ptrdiff_t>(static_cast<std::size_t>(y) * width));
  }
}

}  // namespace kawara::vision
