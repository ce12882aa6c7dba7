#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "vision/change/reference_file.hpp"

/// Any bytes as a reference file, as they are and with a checksum that fits; what comes out must be
/// written again as something that reads back.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace kawara::vision;
  std::vector<std::uint8_t> bytes(data, data + size);
  (void)DecodeReference(bytes);
  constexpr std::size_t kMagic = 8, kBody = 12;
  if (size < kBody) return 0;
  const auto crc =
      static_cast<std::uint32_t>(::crc32_z(0, bytes.data() + kBody, bytes.size() - kBody));
  std::memcpy(bytes.data() + kMagic, &crc, sizeof(crc));
  const auto reference = DecodeReference(bytes);
  if (!reference) return 0;
  const auto again = EncodeReference(*reference);
  if (const auto back = DecodeReference(again); !back || EncodeReference(*back) != again)
    std::abort();
  return 0;
}
