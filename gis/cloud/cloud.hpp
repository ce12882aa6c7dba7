#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/expected.hpp"
#include "core/geodesy.hpp"
#include "gis/frame/map_frame.hpp"

namespace kawara::gis {

struct CloudPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< always finite
  double time_s = 0.0;                                 ///< as the file counts it
  float intensity = 0.0F;                              ///< in the file's own unit
  std::array<std::uint8_t, 3> colour{};                ///< red, green, blue
  std::uint8_t classification = 0;                     ///< LAS: 2 ground, 7 and 18 noise
};

enum class CloudFormat { kPly, kLas };

/// What a file says about its points, and how many came out of it so far.
struct CloudInfo {
  CloudFormat format = CloudFormat::kPly;
  std::uint64_t promised = 0;  ///< points, by the header
  bool has_colour = false;
  bool has_intensity = false;
  bool has_time = false;
  std::vector<std::string> comments;     ///< PLY: comments and obj_info, without that word
  std::optional<core::Geodetic> origin;  ///< PLY: of the local frame, if a comment states it as
                                         ///< gis/model's writer does
  std::string crs;                       ///< LAS: WKT; empty: none stated
  /// LAS: bounds by the header, file's coordinates.
  std::optional<std::array<Eigen::Vector3d, 2>> bounds;

  std::uint64_t delivered = 0;
  std::uint64_t not_finite = 0;  ///< passed over: a coordinate that is NaN or infinite
  std::uint64_t withheld = 0;    ///< passed over: LAS points marked as deleted
  HeightDatum heights = HeightDatum::kUnknown;  ///< ReadCloudEnu: of the file, before lifting
};

/// Gets the points a chunk at a time, in the file's order. The chunk is gone after the call.
using CloudVisitor = std::function<void(std::span<const CloudPoint>)>;

struct CloudReadOptions {
  std::size_t chunk_points = 65'536;     ///< most points a call of the visitor
  std::size_t buffer_bytes = 1U << 20U;  ///< read from the disk at once
};

/// What a file says, without its points. Errors as ReadCloud.
core::Expected<CloudInfo> ReadCloudInfo(const std::string& path);

/// Reads PLY (ascii, binary of either byte order) or LAS 1.0 to 1.4 (point formats 0 to 10),
/// whichever the first bytes say. Points in the file's own coordinates. Memory: a chunk and a
/// buffer, whatever the file's size.
///
/// Errors, one line each with the way to mend it: kNotFound, kPermission, kIo; kFormat: no cloud,
/// a damaged header, LAZ (compressed), or the file ends too early: all whole points were delivered
/// before, and the line says how many of how many and at which byte.
core::Expected<CloudInfo> ReadCloud(const std::string& path, const CloudVisitor& visitor,
                                    const CloudReadOptions& options = {});

/// The same with positions in the map's east, north, up [m]. kLocalMetres: as they are. kFromFile:
/// by the LAS file's reference system, or from the frame whose origin the PLY file states; without
/// either kInvalidArgument. Points the reference system is not defined at count as not_finite.
core::Expected<CloudInfo> ReadCloudEnu(const std::string& path, const MapFrame& frame,
                                       const CloudVisitor& visitor,
                                       const CloudReadOptions& options = {});

/// Where a map's origin could stand if nobody says: the origin the PLY file states, or the middle
/// of the LAS file's bounds at its lowest height. kInvalidArgument: the file does not say where it
/// lies.
core::Expected<core::Geodetic> OriginOf(const CloudInfo& info, double geoid_separation_m = 0.0);

}  // namespace kawara::gis
