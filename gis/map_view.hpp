#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "core/geodesy.hpp"

namespace kawara::gis {

/// The map's window in metres east, north of the origin, and where it lies on the paper.
/// Inside gis/ only.
class MapView {
 public:
  /// Shows all of `places`.
  MapView(const std::vector<core::Geodetic>& places, const core::Geodetic& origin,
          const Eigen::Vector2d& from_px, const Eigen::Vector2d& to_px)
      : plane_(origin), from_(from_px), to_(to_px) {
    Eigen::Vector2d low = Eigen::Vector2d::Zero();
    Eigen::Vector2d high = Eigen::Vector2d::Zero();
    for (const core::Geodetic& g : places) {
      const Eigen::Vector2d en = plane_.FromGeodetic(g).head<2>();
      low = low.cwiseMin(en);
      high = high.cwiseMax(en);
    }
    constexpr double kLeastExtentM = 20.0;
    constexpr double kMargin = 1.16;
    const Eigen::Vector2d extent = (high - low).cwiseMax(kLeastExtentM) * kMargin;
    const Eigen::Vector2d size = to_ - from_;
    px_per_m_ = std::min(size.x() / extent.x(), size.y() / extent.y());
    centre_ = (low + high) / 2.0;
  }

  const core::LocalEnu& plane() const { return plane_; }
  double px_per_m() const { return px_per_m_; }
  Eigen::Vector2d from() const { return from_; }
  Eigen::Vector2d to() const { return to_; }
  Eigen::Vector2d Px(const Eigen::Vector2d& en) const {
    const Eigen::Vector2d d = (en - centre_) * px_per_m_;
    return (from_ + to_) / 2.0 + Eigen::Vector2d(d.x(), -d.y());
  }
  Eigen::Vector2d Px(const core::Geodetic& g) const {
    return Px(Eigen::Vector2d(plane_.FromGeodetic(g).head<2>()));
  }
  Eigen::Vector2d LowEn() const { return centre_ - (to_ - from_) / (2.0 * px_per_m_); }
  Eigen::Vector2d HighEn() const { return centre_ + (to_ - from_) / (2.0 * px_per_m_); }

 private:
  core::LocalEnu plane_;
  Eigen::Vector2d from_;
  Eigen::Vector2d to_;
  Eigen::Vector2d centre_ = Eigen::Vector2d::Zero();
  double px_per_m_ = 1.0;
};

}  // namespace kawara::gis
