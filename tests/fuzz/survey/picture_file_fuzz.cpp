#include <cstdint>
#include <cstdlib>

#include "onboard/survey/picture_file.hpp"

/// Any bytes as a picture of a survey.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto picture = kawara::survey::DecodePicture({data, size});
  if (!picture) return 0;
  if (picture->rgb.size() != picture->view().size_bytes() || picture->rgb.empty()) std::abort();
  return 0;
}
