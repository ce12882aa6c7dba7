#include <cstdint>
#include <cstdlib>

#include "vision/png.hpp"

/// Any bytes into both readers; whatever comes out must be a whole picture, and numbers must
/// survive being written again.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::vision;
  constexpr std::int64_t kMaxPixels = 1 << 18;
  if (const auto picture = DecodePng({data, size}, kMaxPixels)) {
    if (picture->view().empty() || picture->rgb.size() != picture->view().size_bytes())
      std::abort();
  }
  if (const auto picture = DecodeGrey16Png({data, size}, kMaxPixels)) {
    const auto file = EncodePng(*picture, kPngFast);
    if (!file || DecodeGrey16Png(*file)->level != picture->level) std::abort();
  }
  return 0;
}
