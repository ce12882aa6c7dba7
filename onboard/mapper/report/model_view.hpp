#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "core/expected.hpp"
#include "core/textured_mesh.hpp"
#include "onboard/mapper/report/report_picture.hpp"

namespace kawara::mapper {

/// A box in the map, local east-north-up [m].
struct MapBox {
  Eigen::Vector3d min_m = Eigen::Vector3d::Zero(), max_m = Eigen::Vector3d::Zero();
};

/// The box that holds all but the outermost thousandth of the points on each side; zero if there
/// are none.
MapBox BoxOf(std::span<const core::ColouredPoint> points);

/// Where a view looks from, always without perspective, so that lengths can be compared.
enum class ViewFrom {
  kAbove,      ///< north is up
  kSouthEast,  ///< 35 deg above the horizon
  kNorthWest,
};

/// A picture of coloured points, each drawn as a square of the point's size where nothing nearer
/// covers it, darkened at steps in depth as eye-dome lighting does. Points may come in any number
/// of parts, tile by tile; the memory is that of the picture, and so is the order of no matter but
/// for points equally deep. Source of the shading: C. Boucheny, "Visualisation scientifique de
/// grands volumes de donnees", thesis, Grenoble 2009, chapter 4. One thread.
class ModelView {
 public:
  /// Of what lies in `box`; `point_m`: size of a point, as a rule the voxels' edge.
  ModelView(ViewFrom from, const MapBox& box, double point_m, int width_px = 960);

  void Add(std::span<const core::ColouredPoint> points);
  /// Without bytes as long as nothing can be seen.
  ReportPicture Picture() const;

 private:
  void Draw(const core::ColouredPoint& point);
  double ShadeAt(int u, int v) const;
  std::size_t index(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(width_px_) +
           static_cast<std::size_t>(u);
  }

  ViewFrom from_;
  double point_m_;
  int width_px_ = 0, height_px_ = 0, point_px_ = 1;
  double px_per_m_ = 1.0;
  Eigen::Matrix3d view_from_map_;  ///< rows: right, down, away
  Eigen::Vector3d corner_m_;       ///< upper left nearest, in the view's axes
  std::vector<float> depth_m_;     ///< from corner_m_; infinite where nothing is
  std::vector<std::uint8_t> rgb_;
};

/// Hands over a model's points part by part, the same ones at every call.
using TakePoints = std::function<void(std::span<const core::ColouredPoint>)>;
using PointParts = std::function<core::Expected<void>(const TakePoints&)>;

/// All three views of a model, however large: its parts are gone through twice, first for the box.
/// Those without a point are left out. Errors: of the parts.
core::Expected<std::vector<ReportPicture>> DrawModelViews(const PointParts& parts, double point_m);

}  // namespace kawara::mapper
