#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "vision/jpeg.hpp"

/// Any bytes into the decoder, strict and forgiving, in every reduction; whatever comes out must be
/// a whole picture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::vision;
  static JpegDecoder decoder;  // reused: an error must leave it usable
  static JpegEncoder encoder;
  if (size == 0) return 0;
  const JpegDecodeOptions options{.scale_eighths = 1 + data[0] % 8,
                                  .accept_damage = (data[0] & 0x80) != 0,
                                  .max_pixels = 1 << 18};
  const std::span<const std::uint8_t> jpeg(data + 1, size - 1);
  const auto picture = decoder.Decode(jpeg, options);
  if (!picture) return 0;
  const std::vector<std::uint8_t> copy(picture->data, picture->data + picture->size_bytes());
  if (!encoder.Encode(*picture, {.quality = 1 + data[0] % 100, .progressive = (data[0] & 1) != 0}))
    std::abort();
  return 0;
}
