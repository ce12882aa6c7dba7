#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/time.hpp"

/// What the 3rd update finds and a GIS keeps: boxes of changed things on the road, and the width of
/// road they leave. Plain numbers in the map's frame: local east-north-up [m]. `vision` makes them,
/// `gis` and `comms` carry them.
namespace kawara::core {

enum class BoxSide : std::uint8_t { kFront = 0, kLeft = 1, kRear = 2, kRight = 3, kTop = 4 };
constexpr std::size_t kBoxSides = 5;
const char* ToString(BoxSide side);  ///< "front", "left", "rear", "right", "top"

/// A box standing upright with a heading; the eight apexes follow from it.
struct UprightBox {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  ///< of the volume
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();  ///< length (along the heading), width, height
  double heading_rad = 0.0;                          ///< true, clockwise from north

  /// Unit vectors in the plane: along the heading, and to the left of it.
  Eigen::Vector2d Forward() const;
  Eigen::Vector2d Left() const;
  /// 0 to 3 the floor (front left, rear left, rear right, front right: counter-clockwise from
  /// above), 4 to 7 the top above them: the paper's section 5 C.
  std::array<Eigen::Vector3d, 8> Apexes() const;
  /// Looking at a side from outside: upper left, upper right, lower right, lower left. Of the top:
  /// looking down with the front upwards.
  std::array<Eigen::Vector3d, 4> CornersOf(BoxSide side) const;
};

/// Area that two boxes' floors share, seen from above [m^2].
double SharedFloor(const UprightBox& a, const UprightBox& b);

/// What became of an object since its last revision.
enum class ChangeState : std::uint8_t {
  kNew = 0,
  kConfirmed = 1,
  kMoved = 2,
  kGrown = 3,
  kGone = 4
};
const char* ToString(ChangeState state);  ///< "new", "confirmed", "moved", "grown", "gone"

/// A guess by size only.
enum class SizeClass : std::uint8_t {
  kUnknown = 0,
  kTruck = 1,
  kCar = 2,
  kRubble = 3,
  kPerson = 4
};
const char* ToString(SizeClass cls);  ///< "unknown", "truck", "car", "rubble", "person"

/// One revision of one changed object.
struct ChangedObject {
  /// Rows and columns of `covariance`: centre east, north, up [m], length, width, height [m],
  /// heading [rad].
  static constexpr int kParameters = 7;

  std::string uid;             ///< the same through all revisions: letters, digits, '-', '_', '.'
  std::uint64_t revision = 0;  ///< counted from 1
  ChangeState state = ChangeState::kNew;
  UprightBox box;
  Eigen::Matrix<double, kParameters, kParameters> covariance =
      Eigen::Matrix<double, kParameters, kParameters>::Zero();
  /// Sides that were seen; the others follow from what such things measure.
  std::array<bool, kBoxSides> side_seen{};
  /// A second heading the data allow as well.
  std::optional<double> second_heading_rad;
  double existence_probability = 0.0;  ///< 0..1
  SizeClass size_class = SizeClass::kUnknown;
  double class_probability = 0.0;
  std::uint32_t voxels = 0;
  std::uint64_t votes = 0;

  /// Existence: after `last_absent` (when the reference knew nothing there; not set: unknown) and
  /// not after `first_seen` it came; it was there until `last_seen`; `gone` is when space it had
  /// filled was first seen empty (not set: it stands, as far as anybody knows).
  UtcTime last_absent;
  UtcTime first_seen;
  UtcTime last_seen;
  UtcTime gone;
  std::vector<std::string> robots;  ///< that saw it
};

/// The road at one place along it: what a dispatcher asks for.
struct RoadStation {
  std::string road;                                   ///< name of the road
  double along_m = 0.0;                               ///< from the road's beginning, along its axis
  Eigen::Vector3d left_m = Eigen::Vector3d::Zero();   ///< edge of the road, looking along it
  Eigen::Vector3d right_m = Eigen::Vector3d::Zero();  ///< the other
  double road_width_m = 0.0;
  /// Largest gap free for its whole height: its width with deviation, and where it begins and
  /// ends, from the left edge.
  double passable_m = 0.0;
  double passable_sd_m = 0.0;
  double gap_begin_m = 0.0;
  double gap_end_m = 0.0;
  double unknown_share = 0.0;  ///< of the road's width that nobody looked at, 0..1
  /// How many of the asked-for vehicle widths pass (passable_m - 2 passable_sd_m): 0 none.
  std::uint32_t passable_class = 0;
  UtcTime observed;  ///< last picture that looked at it; not set: none
};

}  // namespace kawara::core
