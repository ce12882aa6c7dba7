#include <algorithm>
#include <string>

#include "vision/jpeg.hpp"
#include "vision/jpeg_error.hpp"

namespace kawara::vision {
namespace {

constexpr int kMaxSidePx = 65500;  // JPEG_MAX_DIMENSION

// What 4:2:0 can grow to: the bound TurboJPEG states (3 bytes a pixel of whole 16 x 16 blocks),
// tables and markers beside it, and a third more for the several scans of a progressive file.
std::size_t WorstCaseBytes(int width_px, int height_px) {
  const auto blocks = [](int px) { return static_cast<std::size_t>(px + 15) / 16; };
  return blocks(width_px) * blocks(height_px) * 16 * 16 * 4 + 16384;
}

}  // namespace

struct JpegEncoder::Impl {
  jpeg_compress_struct info;
  jpeg_destination_mgr destination;
  JpegError error;
  std::unique_ptr<std::uint8_t[]> buffer;
  std::size_t capacity = 0;
  bool created = false;
  bool made_progressive = false;

  ~Impl() {
    if (created) jpeg_destroy_compress(&info);
  }
  bool Run(const ConstImageView& picture, const JpegOptions& options);
};

// False: libjpeg gave up, error.message says why. See jpeg_error.hpp for the rule about destructors
// here.
bool JpegEncoder::Impl::Run(const ConstImageView& picture, const JpegOptions& options) {
  info.err = InstallJpegError(&error);
  if (setjmp(error.back) != 0) {
    if (created) jpeg_abort_compress(&info);
    return false;
  }
  // A progressive picture leaves its own Huffman tables behind, and jpeg_set_defaults does not
  // replace tables that are there: a baseline picture coded with them is broken.
  if (created && made_progressive != options.progressive) {
    jpeg_destroy_compress(&info);
    created = false;
  }
  made_progressive = options.progressive;
  if (!created) {
    jpeg_create_compress(&info);
    created = true;
    destination.init_destination = [](j_compress_ptr) {};
    destination.empty_output_buffer = [](j_compress_ptr c) -> boolean {
      GiveUpJpeg(reinterpret_cast<j_common_ptr>(c), "larger than the worst case");
    };
    destination.term_destination = [](j_compress_ptr) {};
    info.dest = &destination;
  }
  destination.next_output_byte = buffer.get();
  destination.free_in_buffer = capacity;

  info.image_width = static_cast<JDIMENSION>(picture.width_px);
  info.image_height = static_cast<JDIMENSION>(picture.height_px);
  info.input_components = 3;
  info.in_color_space = JCS_RGB;
  jpeg_set_defaults(&info);  // YCbCr 4:2:0
  jpeg_set_quality(&info, options.quality, TRUE);
  info.restart_in_rows = 0;
  if (options.progressive) {
    jpeg_simple_progression(&info);
  } else {
    info.restart_in_rows = 1;
  }
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) {
    // libjpeg's row pointers are not const, but it only reads.
    JSAMPROW rows[16];
    const int count = std::min(16, static_cast<int>(info.image_height - info.next_scanline));
    for (int i = 0; i < count; ++i) {
      rows[i] = const_cast<JSAMPROW>(picture.row(static_cast<int>(info.next_scanline) + i));
    }
    jpeg_write_scanlines(&info, rows, static_cast<JDIMENSION>(count));
  }
  jpeg_finish_compress(&info);
  return true;
}

JpegEncoder::JpegEncoder() : impl_(std::make_unique<Impl>()) {}
JpegEncoder::~JpegEncoder() = default;
JpegEncoder::JpegEncoder(JpegEncoder&&) noexcept = default;
JpegEncoder& JpegEncoder::operator=(JpegEncoder&&) noexcept = default;

core::Expected<std::span<const std::uint8_t>> JpegEncoder::Encode(const ConstImageView& picture,
                                                                  const JpegOptions& options) {
  const bool fits = !picture.empty() && picture.width_px <= kMaxSidePx &&
                    picture.height_px <= kMaxSidePx &&
                    std::int64_t{picture.width_px} * picture.height_px <= kMaxJpegPixels;
  if (!fits || options.quality < 1 || options.quality > 100) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "JPEG encoder: picture of " + std::to_string(picture.width_px) + " x " +
                          std::to_string(picture.height_px) + " px at quality " +
                          std::to_string(options.quality) +
                          ": expected 1 px to 100 Mpx, sides up to 65500 px, quality 1..100");
  }
  const std::size_t needed = WorstCaseBytes(picture.width_px, picture.height_px);
  if (impl_->capacity < needed) {
    impl_->buffer.reset(
        new std::uint8_t[needed]);  // not cleared: pages nobody writes cost no memory
    impl_->capacity = needed;
  }
  if (!impl_->Run(picture, options)) {
    return core::Fail(core::ErrorCode::kFull, std::string("JPEG encoder: ") + impl_->error.message);
  }
  return std::span<const std::uint8_t>(impl_->buffer.get(),
                                       impl_->capacity - impl_->destination.free_in_buffer);
}

std::size_t JpegEncoder::buffer_bytes() const { return impl_->capacity; }

}  // namespace kawara::vision
