#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::sim {

/// The vertices of a PLY file (ascii, or binary of either byte order; x, y, z of any number type;
/// whatever else stands there is passed over). Errors: kNotFound; kFormat with what is wrong and
/// where.
core::Expected<std::vector<Eigen::Vector3d>> ReadPlyPoints(const std::string& path);

/// Writes points as binary little-endian PLY with float coordinates. Errors: kIo.
core::Expected<void> WritePlyPoints(const std::string& path,
                                    const std::vector<Eigen::Vector3d>& points);

}  // namespace kawara::sim
