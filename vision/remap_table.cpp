#include "vision/remap_table.hpp"

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/info.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.hpp"
#include "vision/remap_kernel.hpp"

namespace kawara::vision {
namespace {

constexpr double kFractionSteps = 65536.0;
constexpr std::size_t kRgbReadBytes = 8;  // the kernel reads two RGB pixels and two bytes more

constexpr int PixelBytes(RemapFormat format) { return format == RemapFormat::kRgb ? kRgbBytes : 1; }

constexpr std::size_t StrideBytes(RemapFormat format, int width_px) {
  return format == RemapFormat::kRgb ? static_cast<std::size_t>(width_px) * kRgbBytes
                                     : PlaneStrideBytes(width_px);
}

std::optional<Eigen::Vector2d> SourcePixel(const CameraModel& source, const CameraModel& target,
                                           const Eigen::Matrix3d& R_source_target, double u,
                                           double v) {
  const auto ray_target = target.Unproject({u, v});
  if (!ray_target) return {};
  return source.Project(R_source_target * *ray_target);
}

// Splits a source coordinate into the first of two neighbours and the weight of the second.
// Coordinates in the outer half of an edge pixel take that pixel's colour. False: outside the
// picture.
bool Split(double coordinate_px, int size_px, std::int64_t* first, std::uint16_t* weight) {
  if (!(coordinate_px >= -0.5 && coordinate_px <= size_px - 0.5)) return false;
  const double clamped = std::clamp(coordinate_px, 0.0, size_px - 1.0);
  const std::int64_t steps = std::llround(clamped * kFractionSteps);
  *first = steps >> 16;
  *weight = static_cast<std::uint16_t>(steps & 0xFFFF);
  if (*first >= size_px - 1) {  // exactly the last pixel: all but 1/65536 of the weight
    *first = size_px - 2;
    *weight = 0xFFFF;
  }
  return true;
}

// How many source pixels one target pixel is long and high, the largest within the run.
struct Density {
  double along_u = 0.0;
  double along_v = 0.0;
};

}  // namespace

core::Expected<RemapTable> RemapTable::Build(const CameraModel& source, const CameraModel& target,
                                             const Eigen::Matrix3d& R_source_target,
                                             int max_samples, RemapFormat format) {
  RemapTable table;
  if (auto built = table.Rebuild(source, target, R_source_target, max_samples, format); !built) {
    return tl::unexpected(built.error());
  }
  return table;
}

core::Expected<void> RemapTable::Rebuild(const CameraModel& source, const CameraModel& target,
                                         const Eigen::Matrix3d& R_source_target, int max_samples,
                                         RemapFormat format) {
  const std::uint64_t source_bytes =
      std::uint64_t{StrideBytes(format, std::max(0, source.width_px()))} *
      static_cast<std::uint64_t>(std::max(0, source.height_px()));
  if (source.width_px() < 2 || source.height_px() < 2 || source_bytes >= RemapEntry::kOutside) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "remap table: source picture of " + std::to_string(source.width_px()) +
                          " x " + std::to_string(source.height_px()) +
                          " px: expected 2 x 2 px to 4 GB");
  }
  if (target.width_px() < 1 || target.height_px() < 1) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "remap table: the target picture is empty");
  }
  format_ = format;
  source_width_px_ = source.width_px();
  source_height_px_ = source.height_px();
  target_width_px_ = target.width_px();
  target_height_px_ = target.height_px();
  runs_per_row_ = (target_width_px_ + kRunPixels - 1) / kRunPixels;
  runs_.clear();
  entries_.clear();
  for (int first = 0; first < runs_per_row_; first += kBandRuns) {
    for (int row = 0; row < target_height_px_; ++row) {
      for (int run = first; run < std::min(first + kBandRuns, runs_per_row_); ++run) {
        AddRun(source, target, R_source_target, std::clamp(max_samples, 1, 16), run * kRunPixels,
               row);
      }
    }
  }
  if (entries_.size() > std::numeric_limits<std::uint32_t>::max()) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "remap table: the target picture is too large");
  }
  return {};
}

void RemapTable::AddRun(const CameraModel& source, const CameraModel& target,
                        const Eigen::Matrix3d& R_source_target, int max_samples, int first_column,
                        int row) {
  const int pixels = std::min(kRunPixels, target_width_px_ - first_column);
  const auto at = [&](double u, double v) {
    return SourcePixel(source, target, R_source_target, u, v);
  };

  Density density;
  const double seam_px =
      source_width_px_ * 0.5;  // a longer step is the jump over a panorama's seam
  for (int column : {first_column, first_column + pixels / 2, first_column + pixels - 1}) {
    for (double quarter :
         {-0.25, 0.25}) {  // small steps: half of each pixel, so that a rim is still seen
      const auto here = at(column + quarter, row + quarter);
      const auto right = at(column - quarter, row + quarter);
      const auto down = at(column + quarter, row - quarter);
      if (here && right) {
        const double step = 2.0 * (*here - *right).norm();
        if (step < seam_px) density.along_u = std::max(density.along_u, step);
      }
      if (here && down) {
        const double step = 2.0 * (*here - *down).norm();
        if (step < seam_px) density.along_v = std::max(density.along_v, step);
      }
    }
  }
  const auto samples = [&](double source_px) {
    return std::clamp(static_cast<int>(std::ceil(source_px / kSampleStepPx)), 1, max_samples);
  };
  const int samples_u = samples(density.along_u);
  const int samples_v = samples(density.along_v);

  Run run;
  run.first_entry = static_cast<std::uint32_t>(entries_.size());
  run.samples_u = static_cast<std::uint8_t>(samples_u);
  run.samples_v = static_cast<std::uint8_t>(samples_v);
  run.pixels = static_cast<std::uint8_t>(pixels);
  const std::size_t stride = StrideBytes(format_, source_width_px_);
  const auto pixel_bytes = static_cast<std::size_t>(PixelBytes(format_));
  const std::size_t source_bytes = stride * static_cast<std::size_t>(source_height_px_);
  bool black = true;
  for (int sv = 0; sv < samples_v; ++sv) {
    for (int su = 0; su < samples_u; ++su) {
      const double du = (su + 0.5) / samples_u - 0.5;
      const double dv = (sv + 0.5) / samples_v - 0.5;
      for (int i = 0; i < pixels; ++i) {
        RemapEntry entry;
        std::int64_t u0 = 0, v0 = 0;
        const auto pixel = at(first_column + i + du, row + dv);
        if (pixel && Split(pixel->x(), source_width_px_, &u0, &entry.weight_right) &&
            Split(pixel->y(), source_height_px_, &v0, &entry.weight_down)) {
          const std::size_t offset =
              static_cast<std::size_t>(v0) * stride + static_cast<std::size_t>(u0) * pixel_bytes;
          entry.offset = static_cast<std::uint32_t>(offset);
          run.at_edge |=
              format_ == RemapFormat::kRgb && offset + stride + kRgbReadBytes > source_bytes;
          black = false;
        } else {
          entry = RemapEntry{};
          run.at_edge = true;
        }
        entries_.push_back(entry);
      }
    }
  }
  if (black) {
    entries_.resize(run.first_entry);
    run.samples_u = run.samples_v = 0;
  }
  runs_.push_back(run);
}

template <class ApplyBand>
void RemapTable::ForBands(int threads, const ApplyBand& apply_band) const {
  const int bands = (runs_per_row_ + kBandRuns - 1) / kBandRuns;
  const auto apply = [&](int band, int end_band) {
    for (; band < end_band; ++band) {
      const int first_run = band * kBandRuns;
      apply_band(first_run, std::min(kBandRuns, runs_per_row_ - first_run),
                 std::ptrdiff_t{first_run} * kRunPixels * PixelBytes(format_));
    }
  };
  threads = std::min(threads, tbb::info::default_concurrency());
  if (threads <= 1) return apply(0, bands);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<int>(0, bands), [&](const tbb::blocked_range<int>& part) {
      apply(part.begin(), part.end());
    });
  });
}

void RemapTable::Apply(const ConstImageView& source, const ImageView& target, int threads) const {
  CORE_CHECK(format_ == RemapFormat::kRgb);
  CORE_CHECK(source.width_px == source_width_px_ && source.height_px == source_height_px_);
  CORE_CHECK(target.width_px == target_width_px_ && target.height_px == target_height_px_);
  const RemapSource pixels{source.data, source.stride_bytes(), source.size_bytes()};
  ForBands(threads, [&](int first_run, int runs, std::ptrdiff_t left_bytes) {
    RemapBand(pixels, &run(first_run, 0), runs, target_height_px_, entries_.data(),
              target.data + left_bytes, target.stride_bytes());
  });
}

void RemapTable::Apply(const ConstPlaneView& source, const PlaneView& target, std::uint8_t black,
                       int threads) const {
  CORE_CHECK(format_ == RemapFormat::kPlane);
  CORE_CHECK(source.width_px == source_width_px_ && source.height_px == source_height_px_);
  CORE_CHECK(target.width_px == target_width_px_ && target.height_px == target_height_px_);
  const RemapSource samples{source.data, source.stride_bytes(), source.size_bytes()};
  ForBands(threads, [&](int first_run, int runs, std::ptrdiff_t left_bytes) {
    RemapPlaneBand(samples, black, &run(first_run, 0), runs, target_height_px_, entries_.data(),
                   target.data + left_bytes, target.stride_bytes());
  });
}

std::size_t RemapTable::memory_bytes() const {
  return entries_.capacity() * sizeof(RemapEntry) + runs_.capacity() * sizeof(Run);
}

double RemapTable::mean_samples() const {
  const double pixels = static_cast<double>(target_width_px_) * target_height_px_;
  return pixels > 0.0 ? static_cast<double>(entries_.size()) / pixels : 0.0;
}

}  // namespace kawara::vision
