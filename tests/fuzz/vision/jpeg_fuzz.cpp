#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "vision/jpeg.hpp"

namespace {

using namespace kawara::vision;

JpegDecoder decoder;  // reused: an error must leave it usable
JpegEncoder encoder;

void Rgb(std::span<const std::uint8_t> jpeg, const JpegDecodeOptions& decode,
         const JpegOptions& encode) {
  const auto picture = decoder.Decode(jpeg, decode);
  if (!picture) return;
  const std::vector<std::uint8_t> copy(picture->data, picture->data + picture->size_bytes());
  if (!encoder.Encode(*picture, encode)) std::abort();
}

void Planes(std::span<const std::uint8_t> jpeg, const JpegDecodeOptions& decode,
            const JpegOptions& encode) {
  static Yuv420Buffer buffer;
  JpegDecodeOptions whole = decode;
  whole.scale_eighths = 8;
  const bool is_picture = decoder.Decode(jpeg, whole).has_value();
  const auto picture = decoder.DecodeYuv420(jpeg, decode);
  if (picture.has_value() != is_picture) std::abort();  // damage is damage in both ways
  if (!picture) return;
  const int factor = 1 << (decode.scale_eighths % 4);
  const Yuv420View reduced = buffer.View((picture->width_px() + factor - 1) / factor,
                                         (picture->height_px() + factor - 1) / factor);
  ReduceYuv420(*picture, factor, reduced);
  if (!encoder.EncodeYuv420(reduced, encode)) std::abort();
}

}  // namespace

/// Any bytes into the decoder, strict and forgiving, as RGB in every reduction and as planes;
/// whatever comes out must be a whole picture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const JpegDecodeOptions decode{.scale_eighths = 1 + data[0] % 8,
                                 .accept_damage = (data[0] & 0x80) != 0,
                                 .max_pixels = 1 << 18};
  const JpegOptions encode{.quality = 1 + data[0] % 100, .progressive = (data[0] & 1) != 0};
  const std::span<const std::uint8_t> jpeg(data + 1, size - 1);
  (data[0] & 0x40) != 0 ? Planes(jpeg, decode, encode) : Rgb(jpeg, decode, encode);
  return 0;
}
