#include <cstdint>
#include <cstdlib>
#include <memory>
#include <sstream>
#include <string>

#include "gis/cloud/cloud_reader.hpp"

/// Any bytes as a PLY file, through two sizes of buffer and chunk: the same points, all finite, and
/// the same last word.
namespace {

using namespace kawara::gis;

struct Outcome {
  std::uint64_t points = 0;
  double sum = 0.0;
  std::string error;
};

Outcome ReadWith(const std::string& bytes, std::size_t buffer, std::size_t chunk) {
  Outcome outcome;
  auto reader =
      OpenPly(ByteSource(std::make_unique<std::istringstream>(bytes), "fuzz.ply", buffer));
  if (!reader) {
    outcome.error = reader.error().message;
    return outcome;
  }
  while (true) {
    const auto points = (*reader)->Next(chunk);
    if (!points) {
      outcome.error = points.error().message;
      break;
    }
    if (points->empty()) break;
    if (points->size() > chunk) std::abort();
    for (const CloudPoint& p : *points) {
      if (!p.position.allFinite()) std::abort();
      outcome.sum += p.position.sum();
      ++outcome.points;
    }
  }
  return outcome;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const Outcome a = ReadWith(bytes, 3, 2), b = ReadWith(bytes, 4096, 1000);
  const bool same_sum = a.sum == b.sum || (a.sum != a.sum && b.sum != b.sum);
  if (a.points != b.points || !same_sum || a.error != b.error) std::abort();
  return 0;
}
