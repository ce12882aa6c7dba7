// Any bytes as a camera's MJPEG frame: never a crash; what is taken begins and ends as a JPEG does,
// has a size, and is taken again as it is.
#include <cstdint>

#include "core/check.hpp"
#include "drivers/motion_jpeg.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto jpeg = kawara::drivers::ReadMotionJpeg({data, size});
  if (!jpeg) return 0;
  const auto& bytes = jpeg->bytes;
  CORE_CHECK(jpeg->width_px > 0 && jpeg->height_px > 0);
  CORE_CHECK(bytes.size() >= 4 && bytes.size() <= size + 512);
  CORE_CHECK(bytes[bytes.size() - 2] == 0xFF && bytes.back() == 0xD9);
  const auto again = kawara::drivers::ReadMotionJpeg(bytes);
  CORE_CHECK(again && again->bytes == bytes);
  return 0;
}
