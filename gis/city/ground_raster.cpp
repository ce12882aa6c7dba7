#include "gis/city/ground_raster.hpp"

#include <gdal_priv.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "gis/frame/crs_to_enu.hpp"
#include "gis/gdal_errors.hpp"

namespace kawara::gis {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kPatch_m = 100.0;
constexpr std::int64_t kMostCells = 400'000'000;

/// Column and row of file coordinates, and back; corners of cells are whole numbers.
struct GeoTransform {
  Eigen::Matrix2d by_cell = Eigen::Matrix2d::Identity();
  Vector2d corner = Vector2d::Zero();
  Vector2d ToFile(const Vector2d& cell) const { return corner + by_cell * cell; }
  Vector2d ToCell(const Vector2d& xy) const { return by_cell.inverse() * (xy - corner); }
};

}  // namespace

/// Reads a raster step by step; every step may find that it cannot be.
class GroundRaster::Builder {
 public:
  Builder(std::string path, const MapFrame& frame, const GroundOptions& options)
      : path_(std::move(path)), frame_(frame), options_(options) {}

  core::Expected<GroundRaster> Build() {
    if (auto opened = Open(); !opened) return tl::unexpected(opened.error());
    if (auto cut = CutOut(); !cut) return tl::unexpected(cut.error());
    if (auto loaded = Load(); !loaded) return tl::unexpected(loaded.error());
    FitPatches();
    return std::move(raster_);
  }

 private:
  tl::unexpected<core::Error> Refuse(const std::string& what) const {
    return core::Fail(core::ErrorCode::kInvalidArgument, path_ + ": " + what);
  }

  core::Expected<void> Open() {
    std::error_code ignored;
    if (!std::filesystem::exists(path_, ignored))
      return core::Fail(core::ErrorCode::kNotFound, path_ + ": no such file");
    RegisterGdal();
    dataset_.reset(GDALDataset::Open(
        path_.c_str(),
        static_cast<unsigned>(GDAL_OF_RASTER) | static_cast<unsigned>(GDAL_OF_READONLY), nullptr,
        nullptr, nullptr));
    if (!dataset_)
      return core::Fail(core::ErrorCode::kFormat,
                        path_ + ": is no raster GDAL can read" +
                            (errors_.message().empty() ? "" : ": " + errors_.message()));
    if (options_.band < 1 || options_.band > dataset_->GetRasterCount())
      return Refuse("no band " + std::to_string(options_.band) + " (it has " +
                    std::to_string(dataset_->GetRasterCount()) + ")");
    band_ = dataset_->GetRasterBand(options_.band);
    std::array<double, 6> g{};
    if (dataset_->GetGeoTransform(g.data()) != CE_None)
      return Refuse("it does not say where its cells lie (no geotransform, no world file)");
    geo_.corner = {g[0], g[3]};
    geo_.by_cell << g[1], g[2], g[4], g[5];
    if (!geo_.by_cell.allFinite() || !geo_.corner.allFinite() || geo_.by_cell.determinant() == 0.0)
      return Refuse("its cells have no area (a damaged geotransform)");
    if (frame_.coordinates == Coordinates::kLocalMetres) return {};
    const OGRSpatialReference* crs = dataset_->GetSpatialRef();
    if (crs == nullptr || crs->IsEmpty())
      return Refuse(
          "it states no reference system: say that its coordinates are local metres, or set one "
          "(gdal_edit.py -a_srs)");
    auto made = CrsToEnu::Make(*crs, frame_);
    if (!made) return core::Fail(made.error().code, path_ + ": " + made.error().message);
    crs_.emplace(std::move(*made));
    raster_.heights_ = crs_->heights();
    return {};
  }

  /// Fractional column and row of the file's raster; NaN: outside the reference system.
  Vector2d FileCell(const Vector2d& enu_m) {
    return geo_.ToCell(crs_ ? crs_->Back({enu_m.x(), enu_m.y(), up_m_}) : enu_m);
  }

  /// The window of cells within the radius.
  core::Expected<void> CutOut() {
    const Vector2d size(dataset_->GetRasterXSize(), dataset_->GetRasterYSize());
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    constexpr int kSteps = 8;
    for (int i = -kSteps; i <= kSteps; ++i)
      for (int k = -kSteps; k <= kSteps; ++k) {
        const Vector2d cell = FileCell(Vector2d(i, k) * (options_.radius_m / kSteps));
        if (!cell.allFinite()) continue;
        low = low.cwiseMin(cell);
        high = high.cwiseMax(cell);
      }
    if ((high.array() < 0.0).any() || (low.array() > size.array()).any())
      return Refuse("nothing of it lies within " + std::to_string(std::lround(options_.radius_m)) +
                    " m of the map's origin (a wrong origin, or axes exchanged?)");
    low = (low.array().floor() - 1.0).max(0.0);
    high = (high.array().ceil() + 1.0).min(size.array());
    first_column_ = static_cast<int>(low.x());
    first_row_ = static_cast<int>(low.y());
    raster_.columns_ = static_cast<int>(high.x()) - first_column_;
    raster_.rows_ = static_cast<int>(high.y()) - first_row_;
    if (std::int64_t{raster_.columns_} * raster_.rows_ > kMostCells)
      return Refuse("more than " + std::to_string(kMostCells) +
                    " cells around the map's origin: read a smaller radius");
    return {};
  }

  core::Expected<void> Load() {
    const auto count =
        static_cast<std::size_t>(raster_.columns_) * static_cast<std::size_t>(raster_.rows_);
    int has_nodata = 0;
    const double nodata = band_->GetNoDataValue(&has_nodata);
    const double scale = band_->GetScale() * MetresPerUnit();
    const double offset = band_->GetOffset() * MetresPerUnit();
    const bool integers =
        band_->GetRasterDataType() == GDT_Int32 || band_->GetRasterDataType() == GDT_UInt32;
    raster_.heights_m_.reserve(count);
    std::vector<double> row(static_cast<std::size_t>(raster_.columns_));
    bool has_base = false;
    for (int r = 0; r < raster_.rows_; ++r) {
      if (band_->RasterIO(GF_Read, first_column_, first_row_ + r, raster_.columns_, 1, row.data(),
                          raster_.columns_, 1, GDT_Float64, 0, 0, nullptr) != CE_None)
        return core::Fail(core::ErrorCode::kFormat,
                          path_ + ": row " + std::to_string(first_row_ + r) +
                              " cannot be read (cut off?): " + errors_.message());
      for (const double raw : row) {
        const bool none =
            !std::isfinite(raw) || (has_nodata != 0 && IsNodata(raw, nodata, !integers));
        const double h_m = raw * scale + offset;
        if (!none && !has_base) raster_.base_m_ = h_m;
        has_base = has_base || !none;
        raster_.known_cells_ += none ? 0U : 1U;
        raster_.heights_m_.push_back(none ? std::numeric_limits<float>::quiet_NaN()
                                          : static_cast<float>(h_m - raster_.base_m_));
      }
    }
    return {};
  }
  /// A float raster may state its nodata with more digits than it holds.
  static bool IsNodata(double raw, double nodata, bool is_float) {
    return raw == nodata || (is_float && static_cast<float>(raw) == static_cast<float>(nodata));
  }
  /// The band's unit if it states one, else the reference system's.
  double MetresPerUnit() const {
    const std::string unit = band_->GetUnitType();
    if (unit == "m" || unit == "metre" || unit == "meter") return 1.0;
    if (unit == "ft" || unit == "foot" || unit == "feet") return 0.3048;
    if (unit == "sft" || unit == "US survey foot" || unit == "ftUS") return 1200.0 / 3937.0;
    return crs_ ? crs_->metres_per_height() : 1.0;
  }

  Patch FitPatch(const Vector2d& middle_m, double half_m) {
    Patch p;
    p.middle_m = middle_m;
    const auto cell = [&](double e, double n) -> Vector2d {
      return FileCell(middle_m + Vector2d(e, n) * half_m) - Vector2d(first_column_, first_row_);
    };
    p.cell = cell(0, 0);
    p.cell_from_m.col(0) = (cell(1, 0) - cell(-1, 0)) / (2.0 * half_m);
    p.cell_from_m.col(1) = (cell(0, 1) - cell(0, -1)) / (2.0 * half_m);
    if (!crs_) return p;
    const double height_m = raster_.base_m_;
    const auto lift = [&](double e, double n) {
      return crs_->UpOf(middle_m + Vector2d(e, n) * half_m, height_m) - height_m;
    };
    p.lift_m = lift(0, 0);
    p.lift_slope = {(lift(1, 0) - lift(-1, 0)) / (2.0 * half_m),
                    (lift(0, 1) - lift(0, -1)) / (2.0 * half_m)};
    return p;
  }

  void FitPatches() {
    if (crs_) up_m_ = crs_->UpOf({0, 0}, raster_.base_m_);
    const Patch middle = FitPatch(Vector2d::Zero(), kPatch_m / 2.0);
    const Eigen::Matrix2d m_from_cell = middle.cell_from_m.inverse();
    raster_.cell_m_ = std::max(m_from_cell.col(0).norm(), m_from_cell.col(1).norm());
    if (!crs_) {
      raster_.patches_ = {middle};
      return;
    }
    // All patches that the window touches, by its outline; a margin for what is curved.
    Vector2d low = Vector2d::Constant(options_.radius_m), high = -low;
    for (const double c : {0.0, 0.5, 1.0})
      for (const double r : {0.0, 0.5, 1.0}) {
        const Vector2d xy =
            geo_.ToFile({first_column_ + c * raster_.columns_, first_row_ + r * raster_.rows_});
        const Vector3d p =
            crs_->Exact({xy.x(), xy.y(), raster_.base_m_ / crs_->metres_per_height()});
        if (!p.allFinite()) continue;
        low = low.cwiseMin(p.head<2>());
        high = high.cwiseMax(p.head<2>());
      }
    low = low.cwiseMax(-options_.radius_m).array() - kPatch_m;
    high = high.cwiseMin(options_.radius_m).array() + kPatch_m;
    raster_.patches_low_m_ = low;
    raster_.patch_m_ = kPatch_m;
    raster_.patch_columns_ =
        std::max(0, static_cast<int>(std::ceil((high.x() - low.x()) / kPatch_m)));
    raster_.patch_rows_ = std::max(0, static_cast<int>(std::ceil((high.y() - low.y()) / kPatch_m)));
    for (int r = 0; r < raster_.patch_rows_; ++r)
      for (int c = 0; c < raster_.patch_columns_; ++c)
        raster_.patches_.push_back(
            FitPatch(low + Vector2d(c + 0.5, r + 0.5) * kPatch_m, kPatch_m / 2.0));
  }

  const std::string path_;
  const MapFrame& frame_;
  const GroundOptions& options_;
  const GdalErrorCatcher errors_;
  std::unique_ptr<GDALDataset> dataset_;
  GDALRasterBand* band_ = nullptr;
  GeoTransform geo_;
  std::optional<CrsToEnu> crs_;
  int first_column_ = 0, first_row_ = 0;
  double up_m_ = 0.0;  ///< where the ground is about, in the map
  GroundRaster raster_;
};

core::Expected<GroundRaster> GroundRaster::Read(const std::string& path, const MapFrame& frame,
                                                const GroundOptions& options) {
  return Builder(path, frame, options).Build();
}

const GroundRaster::Patch* GroundRaster::PatchAt(double east_m, double north_m) const {
  if (patch_m_ == 0.0) return &patches_.front();
  const double c = (east_m - patches_low_m_.x()) / patch_m_;
  const double r = (north_m - patches_low_m_.y()) / patch_m_;
  if (!(c >= 0.0 && r >= 0.0 && c < patch_columns_ && r < patch_rows_)) return nullptr;
  return &patches_[static_cast<std::size_t>(r) * static_cast<std::size_t>(patch_columns_) +
                   static_cast<std::size_t>(c)];
}

std::optional<double> GroundRaster::HeightAt(double east_m, double north_m) const {
  if (!std::isfinite(east_m) || !std::isfinite(north_m)) return std::nullopt;
  const Patch* patch = PatchAt(east_m, north_m);
  if (patch == nullptr) return std::nullopt;
  const Vector2d off = Vector2d(east_m, north_m) - patch->middle_m;
  const Vector2d cell = patch->cell + patch->cell_from_m * off;
  // Outside by rounding only is inside.
  constexpr double kEdge = 1e-6;
  if (!(cell.x() >= -kEdge && cell.y() >= -kEdge && cell.x() <= columns_ + kEdge &&
        cell.y() <= rows_ + kEdge))
    return std::nullopt;
  const double x = std::clamp(cell.x() - 0.5, 0.0, columns_ - 1.0);
  const double y = std::clamp(cell.y() - 0.5, 0.0, rows_ - 1.0);
  const int c0 = static_cast<int>(x), r0 = static_cast<int>(y);
  const int c1 = std::min(c0 + 1, columns_ - 1), r1 = std::min(r0 + 1, rows_ - 1);
  const double fx = x - c0, fy = y - r0;
  double sum = 0.0, weights = 0.0;
  const auto add = [&](int c, int r, double weight) {
    const double h_m = Cell(c, r);
    if (std::isnan(h_m)) return;
    sum += weight * h_m;
    weights += weight;
  };
  add(c0, r0, (1 - fx) * (1 - fy));
  add(c1, r0, fx * (1 - fy));
  add(c0, r1, (1 - fx) * fy);
  add(c1, r1, fx * fy);
  if (weights < 0.5) return std::nullopt;
  return sum / weights + base_m_ + patch->lift_m + patch->lift_slope.dot(off);
}

}  // namespace kawara::gis
