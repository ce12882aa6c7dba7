#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::sim {

/// The finite points of a PLY or LAS file, in its own coordinates, all of them in memory. Errors as
/// gis::ReadCloud.
core::Expected<std::vector<Eigen::Vector3d>> ReadCloudPoints(const std::string& path);

/// Writes points as binary little-endian PLY with float coordinates. Errors: kIo.
core::Expected<void> WritePlyPoints(const std::string& path,
                                    const std::vector<Eigen::Vector3d>& points);

}  // namespace kawara::sim
