#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/config/tree.hpp"
#include "core/expected.hpp"

/// Other programs' YAML and JSON: keys that are not ours, so what is not known is passed over.
namespace kawara::survey {

using core::config::Node;

/// kFormat at the node's place.
tl::unexpected<core::Error> Wrong(const Node& node, const std::string& what);

/// The value of a key that must be there.
core::Expected<const Node*> Need(const Node& map, std::string_view key);

/// A finite number; a key that must be there.
core::Expected<double> NumberOf(const Node& node);
core::Expected<double> NeedNumber(const Node& map, std::string_view key);

/// All numbers of a list, of a list of lists, or of the `data` of a section, row by row; `count` of
/// them, or any number (0).
core::Expected<std::vector<double>> NumbersOf(const Node& node, std::size_t count);
core::Expected<std::vector<double>> NeedNumbers(const Node& map, std::string_view key,
                                                std::size_t count);

/// From 16 numbers, row by row. The rotation must be one to 1e-3 and is made one exactly.
core::Expected<Eigen::Isometry3d> TransformOf(const std::vector<double>& rows, const Node& where);

/// A unit quaternion to 1e-2, made one exactly.
core::Expected<Eigen::Quaterniond> QuaternionOf(double w, double x, double y, double z);

}  // namespace kawara::survey
