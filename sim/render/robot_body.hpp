#pragma once
#include <vector>

#include "sim/site/scene.hpp"

namespace kawara::sim {

/// Object id of the robot's own body in id images.
constexpr std::uint32_t kRobotBodyObject = 0xFFFFFFFEU;

/// What moves with a camera and stands in its way: meshes in the CAMERA frame (X up, Y right,
/// Z forward), metres. Materials are its own.
struct RobotBody {
  std::vector<Material> materials;
  std::vector<Mesh> meshes;
  bool empty() const { return meshes.empty(); }
};

/// The survey robot as its mast-top camera sees it: deck, mast foot, instrument boxes, the laser in
/// front, and the GPS antenna on its pole behind.
/// `camera_above_deck_m`: height of the camera's centre over the deck; 0.3 to 2.
RobotBody SurveyRobotBody(double camera_above_deck_m = 0.55);

}  // namespace kawara::sim
