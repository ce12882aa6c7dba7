#include <algorithm>
#include <string>

#include "vision/jpeg.hpp"
#include "vision/jpeg_error.hpp"

namespace kawara::vision {
namespace {

constexpr int kMaxSidePx = 65500;  // JPEG_MAX_DIMENSION
constexpr int kMcuPx = 16;         // of 4:2:0: 16 rows of luma and 8 of each chroma go at a time

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
  template <class WriteRows>
  bool Run(int width_px, int height_px, const JpegOptions& options, bool raw,
           const WriteRows& write_rows);
  core::Expected<void> Prepare(bool empty, int width_px, int height_px, const JpegOptions& options);
  core::Expected<std::span<const std::uint8_t>> Result(bool done) const;
};

// `write_rows` hands libjpeg the next kMcuPx rows: of RGB, or `raw` as planes. False: libjpeg gave
// up, error.message says why. See jpeg_error.hpp for the rule about destructors here.
template <class WriteRows>
bool JpegEncoder::Impl::Run(int width_px, int height_px, const JpegOptions& options, bool raw,
                            const WriteRows& write_rows) {
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

  info.image_width = static_cast<JDIMENSION>(width_px);
  info.image_height = static_cast<JDIMENSION>(height_px);
  info.input_components = 3;
  info.in_color_space = raw ? JCS_YCbCr : JCS_RGB;
  jpeg_set_defaults(&info);  // YCbCr 4:2:0
  info.raw_data_in = raw ? TRUE : FALSE;
  jpeg_set_quality(&info, options.quality, TRUE);
  info.restart_in_rows = 0;
  if (options.progressive) {
    jpeg_simple_progression(&info);
  } else {
    info.restart_in_rows = 1;
  }
  jpeg_start_compress(&info, TRUE);
  while (info.next_scanline < info.image_height) write_rows(static_cast<int>(info.next_scanline));
  jpeg_finish_compress(&info);
  return true;
}

JpegEncoder::JpegEncoder() : impl_(std::make_unique<Impl>()) {}
JpegEncoder::~JpegEncoder() = default;
JpegEncoder::JpegEncoder(JpegEncoder&&) noexcept = default;
JpegEncoder& JpegEncoder::operator=(JpegEncoder&&) noexcept = default;

core::Expected<void> JpegEncoder::Impl::Prepare(bool empty, int width_px, int height_px,
                                                const JpegOptions& options) {
  const bool fits = !empty && width_px <= kMaxSidePx && height_px <= kMaxSidePx &&
                    std::int64_t{width_px} * height_px <= kMaxJpegPixels;
  if (!fits || options.quality < 1 || options.quality > 100) {
    return core::Fail(core::ErrorCode::kInvalidArgument,
                      "JPEG encoder: picture of " + std::to_string(width_px) + " x " +
                          std::to_string(height_px) + " px at quality " +
                          std::to_string(options.quality) +
                          ": expected 1 px to 100 Mpx, sides up to 65500 px, quality 1..100");
  }
  const std::size_t needed = WorstCaseBytes(width_px, height_px);
  if (capacity < needed) {
    buffer.reset(new std::uint8_t[needed]);  // not cleared: pages nobody writes cost no memory
    capacity = needed;
  }
  return {};
}

core::Expected<std::span<const std::uint8_t>> JpegEncoder::Impl::Result(bool done) const {
  if (!done) {
    return core::Fail(core::ErrorCode::kFull, std::string("JPEG encoder: ") + error.message);
  }
  return std::span<const std::uint8_t>(buffer.get(), capacity - destination.free_in_buffer);
}

core::Expected<std::span<const std::uint8_t>> JpegEncoder::Encode(const ConstImageView& picture,
                                                                  const JpegOptions& options) {
  const int width_px = picture.width_px, height_px = picture.height_px;
  auto ready = impl_->Prepare(picture.empty(), width_px, height_px, options);
  if (!ready) return tl::unexpected(ready.error());
  return impl_->Result(impl_->Run(width_px, height_px, options, false, [&](int v) {
    // libjpeg's row pointers are not const, but it only reads.
    JSAMPROW rows[kMcuPx];
    const int count = std::min(kMcuPx, height_px - v);
    for (int i = 0; i < count; ++i) rows[i] = const_cast<JSAMPROW>(picture.row(v + i));
    jpeg_write_scanlines(&impl_->info, rows, static_cast<JDIMENSION>(count));
  }));
}

core::Expected<std::span<const std::uint8_t>> JpegEncoder::EncodeYuv420(
    const Yuv420View& picture, const JpegOptions& options) {
  const int width_px = picture.width_px(), height_px = picture.height_px();
  auto ready = impl_->Prepare(ConstYuv420View(picture).empty(), width_px, height_px, options);
  if (!ready) return tl::unexpected(ready.error());
  FillMargin(picture);
  return impl_->Result(impl_->Run(width_px, height_px, options, true, [&](int v) {
    JSAMPROW y[kMcuPx], cb[kMcuPx / 2], cr[kMcuPx / 2];
    JSAMPARRAY components[3] = {y, cb, cr};
    // Below the picture its last row goes on.
    const auto row = [](const PlaneView& plane, int number) {
      return plane.row(std::min(number, plane.height_px - 1));
    };
    for (int i = 0; i < kMcuPx; ++i) y[i] = row(picture.y, v + i);
    for (int i = 0; i < kMcuPx / 2; ++i) {
      cb[i] = row(picture.cb, v / 2 + i);
      cr[i] = row(picture.cr, v / 2 + i);
    }
    jpeg_write_raw_data(&impl_->info, components, kMcuPx);
  }));
}

std::size_t JpegEncoder::buffer_bytes() const { return impl_->capacity; }

}  // namespace kawara::vision
