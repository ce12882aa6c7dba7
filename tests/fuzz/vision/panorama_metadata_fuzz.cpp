#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "vision/panorama_metadata.hpp"

/// Any bytes into the reader and the merger; what was merged must read back with our values.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara;
  const std::span<const std::uint8_t> jpeg(data, size);
  (void)vision::ReadPanoramaMetadata(jpeg);
  vision::PanoramaMetadata metadata;
  metadata.time = core::UtcTime::FromNs(1'700'000'000'123'456'789);
  metadata.position = core::Geodetic{0.6, 2.4, 12.5};
  metadata.attitude = core::Attitude{0.1, 0.2, 0.3};
  metadata.geometry = {3000, 667, 3000, 1500, 0, 500};
  std::vector<std::uint8_t> out;
  if (!vision::InsertPanoramaMetadata(jpeg, metadata, &out)) return 0;
  const auto back = vision::ReadPanoramaMetadata(out);
  if (!back || !back->time || !back->position || !back->attitude) std::abort();
  if (back->time->ns() != metadata.time->ns() || back->geometry != metadata.geometry) std::abort();
  return 0;
}
