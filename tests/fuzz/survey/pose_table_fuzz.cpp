#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "onboard/survey/pose_table.hpp"

/// Any bytes as a table of poses: every pose that comes out is finite and a rotation.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::survey;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const BodyAxes body = size % 2 == 0 ? BodyAxes::kForwardRightDown : BodyAxes::kForwardLeftUp;
  const auto table = ParsePoses(text, "poses.csv", body);
  if (!table) {
    if (table.error().message.empty()) std::abort();
    return 0;
  }
  if (table->rows.empty()) std::abort();
  for (const PoseRow& row : table->rows) {
    if (!row.map_from_body.matrix().allFinite() || !row.covariance.allFinite()) std::abort();
    if (std::abs(row.map_from_body.linear().determinant() - 1.0) > 1e-6) std::abort();
  }
  return 0;
}
