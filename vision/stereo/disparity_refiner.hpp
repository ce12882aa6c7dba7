#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "vision/stereo/rectified_picture.hpp"
#include "vision/stereo/refine_kernel.hpp"

namespace kawara::vision {

/// Disparities of every pixel of A's rectified picture [px], each with its deviation; below zero:
/// not known.
struct DisparityField {
  std::vector<float> disparity_px;
  std::vector<float> sd_px;
};

/// From half-size guesses to sub-pixel disparities by least squares on the pictures themselves:
/// the field is warped over B, and a Gaussian window about each pixel, of those neighbours only
/// that are on the same surface, says how far the mean of the field there is off (Lucas and Kanade
/// 1981, with the window following whatever slant the field has). Exposure and shading are
/// equalised on the way by a smooth field of gains. Keeps its memory; one thread at a time.
class DisparityRefiner {
 public:
  /// `coarse_px`: [height / 2][width / 2] in half-size pixels, below zero unknown.
  void Refine(const RectifiedPicture& a, const RectifiedPicture& b,
              const std::vector<float>& coarse_px, DisparityField& field);

 private:
  static constexpr int kGainBlock = 64;
  struct Row {
    std::vector<float> disparity, slope_error, slope_square, error_square, slope_cross, support;
    void Resize(std::size_t width);
    refine::SmoothRow view();
  };

  void Enlarge(const std::vector<float>& coarse_px);
  void FindGains(const RectifiedPicture& a, const RectifiedPicture& b);
  void GainsOfRow(int y);
  refine::ResidualRow RowOf(const RectifiedPicture& a, const RectifiedPicture& b, int y,
                            float softness);
  float FindNoise(const RectifiedPicture& a, const RectifiedPicture& b);
  void Iterate(const RectifiedPicture& a, const RectifiedPicture& b, float noise_square,
               std::vector<float>* sd_px);
  float* disparity_row(int y) {
    return disparity_.data() + static_cast<std::size_t>(y) * stride_ + refine::kPad;
  }

  int width_ = 0, height_ = 0;
  std::size_t stride_ = 0;
  std::vector<float> disparity_;  ///< rows padded with refine::kNone
  int blocks_x_ = 0, blocks_y_ = 0;
  std::vector<std::array<float, 3>> gains_;
  std::array<std::vector<refine::GainLine>, 3> row_gains_;
  std::array<Row, 2 * refine::kRadius + 1> along_;
  Row here_, result_;
  std::vector<float> squares_;
};

}  // namespace kawara::vision
