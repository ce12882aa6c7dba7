#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace kawara::core {

/// Triangles with colours and a picture on them, as plain numbers: what `vision` makes and `gis`
/// writes. Corners are floats from `offset_m`, so that they are exact to the micrometre however far
/// from the map's origin the mesh lies. Frame: map, local east-north-up [m].
struct TexturedMesh {
  std::string name;  ///< of its file or node: letters, digits, '_' and '-'
  std::uint64_t revision = 0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();

  std::vector<std::array<float, 3>> positions_m;          ///< from offset_m
  std::vector<std::array<float, 3>> normals;              ///< unit, outwards; empty or one each
  std::vector<std::array<std::uint8_t, 3>> colours;       ///< sRGB; empty or one each
  std::vector<std::array<float, 2>> texture_coordinates;  ///< (0, 0) upper left; empty or one each
  std::vector<std::array<std::uint32_t, 3>> triangles;    ///< counter-clockwise from outside
  std::vector<std::uint8_t> texture_jpeg;                 ///< a whole JPEG file; empty: none
};

/// Points with colours, same frame.
struct ColouredPoint {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> colour{};
  std::uint16_t votes = 0;
};

}  // namespace kawara::core
