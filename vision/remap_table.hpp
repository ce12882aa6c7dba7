#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/expected.hpp"
#include "vision/camera/camera_model.hpp"
#include "vision/image.hpp"
#include "vision/yuv420.hpp"

namespace kawara::vision {

/// What a table's pictures are made of: packed RGB8 (image.hpp), or single planes (yuv420.hpp).
enum class RemapFormat : std::uint8_t { kRgb, kPlane };

/// Where one sample of a target pixel comes from: byte offset of the upper left of its four source
/// pixels, and the bilinear weights of the right and the lower ones in 1/65536.
struct RemapEntry {
  static constexpr std::uint32_t kOutside = 0xFFFFFFFFU;  ///< no source: contributes black
  std::uint32_t offset = kOutside;
  std::uint16_t weight_right = 0;
  std::uint16_t weight_down = 0;
};
static_assert(sizeof(RemapEntry) == 8);

/// Table that turns pictures of one camera into pictures of another, computed once for all frames.
///
/// Each target pixel is the mean of samples_u x samples_v bilinear samples spread evenly over its
/// area. Their number is chosen for each run of kRunPixels pixels so that neighbouring samples are
/// at most kSampleStepPx source pixels apart: a source denser than the target is averaged over the
/// pixel's area, not picked from, and separately along both axes (a doughnut's outer circle is
/// dense in azimuth only).
///
/// Integer arithmetic, the same bits on every SIMD target; within 1 level of the double
/// computation. Immutable after Build; Apply from any thread, one target a thread.
class RemapTable {
 public:
  static constexpr int kRunPixels = 64;
  static constexpr int kBandRuns = 16;
  static constexpr double kSampleStepPx = 1.25;

  /// `R_source_target` takes directions in the target camera's frame to the source camera's frame.
  /// `max_samples` bounds samples_u and samples_v: beyond it a source more than max_samples *
  /// kSampleStepPx times denser than the target aliases (let the JPEG decoder scale it down first).
  /// kInvalidArgument: source smaller than 2 x 2 px or larger than 4 GB, empty target.
  static core::Expected<RemapTable> Build(const CameraModel& source, const CameraModel& target,
                                          const Eigen::Matrix3d& R_source_target,
                                          int max_samples = 4,
                                          RemapFormat format = RemapFormat::kRgb);
  /// The same into this object; keeps its memory when it suffices.
  core::Expected<void> Rebuild(const CameraModel& source, const CameraModel& target,
                               const Eigen::Matrix3d& R_source_target, int max_samples = 4,
                               RemapFormat format = RemapFormat::kRgb);

  /// Fills `target` from `source`; format and sizes must be those the table was built for
  /// (CORE_CHECK). Parallel over bands of columns if threads > 1 (oneTBB, no more than the machine
  /// has); with 1 it stays in the calling thread and allocates nothing.
  void Apply(const ConstImageView& source, const ImageView& target, int threads = 1) const;
  /// The same for one plane; `black` is what it holds where the source does not look (kBlackLuma,
  /// kBlackChroma). The target's margin stays as it is.
  void Apply(const ConstPlaneView& source, const PlaneView& target, std::uint8_t black,
             int threads = 1) const;

  int source_width_px() const { return source_width_px_; }
  int source_height_px() const { return source_height_px_; }
  int target_width_px() const { return target_width_px_; }
  int target_height_px() const { return target_height_px_; }
  std::size_t memory_bytes() const;
  /// Bilinear samples a target pixel takes, mean over the picture: what Apply's time is
  /// proportional to.
  double mean_samples() const;

  /// One run of target pixels within a row, for tests and for Apply.
  struct Run {
    std::uint32_t first_entry = 0;  ///< samples * pixels entries, sample after sample
    std::uint8_t samples_u = 0;     ///< 0: the whole run is black and has no entries
    std::uint8_t samples_v = 0;
    std::uint8_t pixels = 0;
    /// Some samples are outside, or (RGB) an 8-byte read would pass the end of the source.
    bool at_edge = false;
  };
  /// Run `number` (from the left) of row `row`. Runs are stored and worked on in bands of kBandRuns
  /// beside each other, from the top: a band of an unwrapped ring is a sector, whose pixels stay in
  /// the nearest caches.
  const Run& run(int number, int row) const {
    const int first = number / kBandRuns * kBandRuns;
    const int in_band = std::min(kBandRuns, runs_per_row_ - first);
    return runs_[static_cast<std::size_t>(first) * static_cast<std::size_t>(target_height_px_) +
                 static_cast<std::size_t>(row) * static_cast<std::size_t>(in_band) +
                 static_cast<std::size_t>(number - first)];
  }
  const std::vector<RemapEntry>& entries() const { return entries_; }

 private:
  void AddRun(const CameraModel& source, const CameraModel& target,
              const Eigen::Matrix3d& R_source_target, int max_samples, int first_column, int row);
  template <class ApplyBand>  // (number of the first run, runs a row, bytes to its first column)
  void ForBands(int threads, const ApplyBand& apply_band) const;

  RemapFormat format_ = RemapFormat::kRgb;
  int source_width_px_ = 0, source_height_px_ = 0;
  int target_width_px_ = 0, target_height_px_ = 0;
  int runs_per_row_ = 0;
  std::vector<Run> runs_;
  std::vector<RemapEntry> entries_;
};

}  // namespace kawara::vision
