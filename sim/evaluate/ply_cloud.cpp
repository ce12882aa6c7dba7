#include "sim/evaluate/ply_cloud.hpp"

#include <fstream>

#include "gis/cloud/cloud.hpp"

namespace kawara::sim {

core::Expected<std::vector<Eigen::Vector3d>> ReadCloudPoints(const std::string& path) {
  std::vector<Eigen::Vector3d> points;
  const auto read = gis::ReadCloud(path, [&points](std::span<const gis::CloudPoint> chunk) {
    for (const gis::CloudPoint& p : chunk) points.push_back(p.position);
  });
  if (!read) return tl::unexpected(read.error());
  return points;
}

core::Expected<void> WritePlyPoints(const std::string& path,
                                    const std::vector<Eigen::Vector3d>& points) {
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3f p = point.cast<float>();
    out.write(reinterpret_cast<const char*>(p.data()), 3 * sizeof(float));
  }
  out.flush();
  if (!out) return core::Fail(core::ErrorCode::kIo, path + ": cannot be written (disk full?)");
  return {};
}

}  // namespace kawara::sim
