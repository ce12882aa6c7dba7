#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/camera_socket_client.hpp"

/// The byte stream of a camera socket, in pieces of the sizes that the input's first byte chooses:
/// never a crash, never a frame whose payload is not what its header said, and after an error a
/// fresh start.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 1) return 0;
  const std::size_t piece = 1 + data[0];
  kawara::drivers::CameraFrameAssembler assembler;
  for (std::size_t at = 1; at < size; at += piece) {
    std::span<const std::uint8_t> rest(data + at, std::min(piece, size - at));
    while (!rest.empty()) {
      const std::size_t before = rest.size();
      const auto frame = assembler.Feed({}, rest);
      if (!frame) {
        assembler.Reset();
        break;
      }
      if (rest.size() >= before) std::abort();  // no progress
      if (*frame && ((*frame)->bytes.empty() || (*frame)->bytes.size() > size)) std::abort();
    }
  }
  return 0;
}
