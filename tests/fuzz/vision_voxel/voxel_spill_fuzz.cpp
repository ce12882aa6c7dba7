#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "vision/voxel/spill_codec.hpp"
#include "vision/voxel/spill_file.hpp"

/// Any bytes as a spill file, and as the payload of one tile; what comes out must be possible and
/// lie within the bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::vision;
  const std::span<const std::uint8_t> bytes(data, size);
  static SpilledBlock block;
  const auto decode = [](std::span<const std::uint8_t> payload, const TileIndex& tile) {
    TileDecoder decoder(payload, tile);
    for (;;) {
      const auto more = decoder.Next(block);
      if (!more || !*more) return;
      if (TileOfBlock(block.index) != tile) std::abort();
      for (std::size_t i = 0; i < block.size; ++i)
        if (!(block.voxels[i].weight > 0.0F) || block.places[i] >= kBlockVoxels) std::abort();
    }
  };
  decode(bytes, {0, 0});
  const auto contents = ScanSpill(bytes);
  if (!contents) return 0;
  for (const auto& [tile, place] : contents->tiles) {
    if (place.payload_offset + place.payload_bytes > contents->committed_bytes ||
        contents->committed_bytes > size)
      std::abort();
    decode(bytes.subspan(place.payload_offset, place.payload_bytes), tile);
  }
  return 0;
}
