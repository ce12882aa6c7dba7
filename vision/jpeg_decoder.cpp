#include <algorithm>
#include <string>
#include <vector>

#include "vision/jpeg.hpp"
#include "vision/jpeg_error.hpp"

namespace kawara::vision {
namespace {

// A file of a few bytes can ask for gigabytes and minutes: every block costs at least a bit of the
// stream, so a picture of more pixels than this for each byte cannot be whole; and nobody writes
// more scans than this.
constexpr std::int64_t kMaxPixelsPerByte = 1024;
constexpr int kMaxScans = 64;

enum class Refusal { kNone, kLibjpeg, kTooLarge, kImplausible, kColours, kDamaged };

constexpr int kMcuPx = 16;  // of 4:2:0: 16 rows of luma and 8 of each chroma come at a time

bool IsYuv420(const jpeg_decompress_struct& info) {
  const auto sampled = [&](int component, int h, int v) {
    return info.comp_info[component].h_samp_factor == h &&
           info.comp_info[component].v_samp_factor == v;
  };
  return info.jpeg_color_space == JCS_YCbCr && sampled(0, 2, 2) && sampled(1, 1, 1) &&
         sampled(2, 1, 1);
}

}  // namespace

struct JpegDecoder::Impl {
  jpeg_decompress_struct info;
  jpeg_progress_mgr progress;
  JpegError error;
  std::vector<std::uint8_t> pixels;
  Yuv420Buffer planes;
  bool created = false;
  long warnings = 0;

  ~Impl() {
    if (created) jpeg_destroy_decompress(&info);
  }
  Refusal Header(std::span<const std::uint8_t> jpeg, const JpegDecodeOptions& options,
                 JpegInfo* header);
  Refusal Pixels(const JpegDecodeOptions& options, ConstImageView* picture);
  Refusal Planes(const JpegDecodeOptions& options, Yuv420View* picture);
  Refusal RawPlanes(const JpegDecodeOptions& options, const Yuv420View& picture);
  template <class View, class Read>
  core::Expected<View> Run(std::span<const std::uint8_t> jpeg, const JpegDecodeOptions& options,
                           const Read& read);
  core::Error Explain(Refusal refusal, const JpegInfo& header) const;
};

// Ends with the decompressor ready to start. See jpeg_error.hpp for the rule about destructors
// here.
Refusal JpegDecoder::Impl::Header(std::span<const std::uint8_t> jpeg,
                                  const JpegDecodeOptions& options, JpegInfo* header) {
  info.err = InstallJpegError(&error);
  if (setjmp(error.back) != 0) return Refusal::kLibjpeg;
  if (!created) {
    jpeg_create_decompress(&info);
    created = true;
    progress.progress_monitor = [](j_common_ptr c) {
      if (reinterpret_cast<j_decompress_ptr>(c)->input_scan_number > kMaxScans) {
        GiveUpJpeg(c, "more scans than any honest file has");
      }
    };
    info.progress = &progress;
  }
  jpeg_mem_src(&info, jpeg.data(), static_cast<unsigned long>(jpeg.size()));
  jpeg_read_header(&info, TRUE);
  header->width_px = static_cast<int>(info.image_width);  // libjpeg admits 65500 at most
  header->height_px = static_cast<int>(info.image_height);
  header->progressive = info.progressive_mode != FALSE;
  const std::int64_t pixel_count = std::int64_t{header->width_px} * header->height_px;
  if (pixel_count > std::min(options.max_pixels, kMaxJpegPixels)) return Refusal::kTooLarge;
  if (pixel_count > kMaxPixelsPerByte * static_cast<std::int64_t>(jpeg.size()))
    return Refusal::kImplausible;
  if (info.num_components != 1 && info.num_components != 3) return Refusal::kColours;
  return Refusal::kNone;
}

Refusal JpegDecoder::Impl::Pixels(const JpegDecodeOptions& options, ConstImageView* picture) {
  info.out_color_space = JCS_RGB;
  info.scale_num = static_cast<unsigned>(std::clamp(options.scale_eighths, 1, 8));
  info.scale_denom = 8;
  if (setjmp(error.back) != 0) return Refusal::kLibjpeg;
  jpeg_calc_output_dimensions(&info);
  picture->width_px = static_cast<int>(info.output_width);
  picture->height_px = static_cast<int>(info.output_height);
  if (pixels.size() < picture->size_bytes()) pixels.resize(picture->size_bytes());
  picture->data = pixels.data();
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    JSAMPROW rows[16];
    const int count = std::min(16, static_cast<int>(info.output_height - info.output_scanline));
    for (int i = 0; i < count; ++i) {
      rows[i] = pixels.data() +
                picture->stride_bytes() * (info.output_scanline + static_cast<unsigned>(i));
    }
    jpeg_read_scanlines(&info, rows, static_cast<JDIMENSION>(count));
    if (error.base.num_warnings != 0 && !options.accept_damage) return Refusal::kDamaged;
  }
  jpeg_finish_decompress(&info);
  if (error.base.num_warnings != 0 && !options.accept_damage) return Refusal::kDamaged;
  return Refusal::kNone;
}

// The samples as the file has them: neither colour conversion nor chroma brought to full size.
Refusal JpegDecoder::Impl::RawPlanes(const JpegDecodeOptions& options, const Yuv420View& picture) {
  if (setjmp(error.back) != 0) return Refusal::kLibjpeg;
  info.raw_data_out = TRUE;
  jpeg_start_decompress(&info);
  while (info.output_scanline < info.output_height) {
    const int v = static_cast<int>(info.output_scanline);
    JSAMPROW y[kMcuPx], cb[kMcuPx / 2], cr[kMcuPx / 2];
    JSAMPARRAY components[3] = {y, cb, cr};
    for (int i = 0; i < kMcuPx; ++i) y[i] = picture.y.row(v + i);
    for (int i = 0; i < kMcuPx / 2; ++i) {
      cb[i] = picture.cb.row(v / 2 + i);
      cr[i] = picture.cr.row(v / 2 + i);
    }
    jpeg_read_raw_data(&info, components, kMcuPx);
    if (error.base.num_warnings != 0 && !options.accept_damage) return Refusal::kDamaged;
  }
  jpeg_finish_decompress(&info);
  if (error.base.num_warnings != 0 && !options.accept_damage) return Refusal::kDamaged;
  return Refusal::kNone;
}

Refusal JpegDecoder::Impl::Planes(const JpegDecodeOptions& options, Yuv420View* picture) {
  *picture = planes.View(static_cast<int>(info.image_width), static_cast<int>(info.image_height));
  if (IsYuv420(info)) return RawPlanes(options, *picture);
  JpegDecodeOptions whole = options;
  whole.scale_eighths = 8;
  ConstImageView rgb;
  const Refusal refusal = Pixels(whole, &rgb);
  if (refusal == Refusal::kNone) Yuv420FromRgb(rgb, *picture);
  return refusal;
}

core::Error JpegDecoder::Impl::Explain(Refusal refusal, const JpegInfo& header) const {
  const std::string size =
      std::to_string(header.width_px) + " x " + std::to_string(header.height_px) + " px";
  switch (refusal) {
    case Refusal::kTooLarge:
      return {core::ErrorCode::kFormat, "JPEG: " + size + " is more than this program takes"};
    case Refusal::kImplausible:
      return {core::ErrorCode::kFormat, "JPEG: the file is too short for its " + size};
    case Refusal::kColours:
      return {core::ErrorCode::kFormat,
              "JPEG: " + std::to_string(info.num_components) +
                  " colour components; only grey and YCbCr or RGB are read"};
    case Refusal::kDamaged:
      return {core::ErrorCode::kFormat, "JPEG: damaged or cut short"};
    default:
      return {core::ErrorCode::kFormat, std::string("JPEG: ") + error.message};
  }
}

JpegDecoder::JpegDecoder() : impl_(std::make_unique<Impl>()) {}
JpegDecoder::~JpegDecoder() = default;
JpegDecoder::JpegDecoder(JpegDecoder&&) noexcept = default;
JpegDecoder& JpegDecoder::operator=(JpegDecoder&&) noexcept = default;

core::Expected<JpegInfo> JpegDecoder::ReadInfo(std::span<const std::uint8_t> jpeg,
                                               std::int64_t max_pixels) {
  JpegInfo header;
  const Refusal refusal = impl_->Header(jpeg, {.max_pixels = max_pixels}, &header);
  if (impl_->created) jpeg_abort_decompress(&impl_->info);
  if (refusal != Refusal::kNone) return tl::unexpected(impl_->Explain(refusal, header));
  return header;
}

template <class View, class Read>
core::Expected<View> JpegDecoder::Impl::Run(std::span<const std::uint8_t> jpeg,
                                            const JpegDecodeOptions& options, const Read& read) {
  JpegInfo header;
  View picture;
  Refusal refusal = Header(jpeg, options, &header);
  if (refusal == Refusal::kNone) refusal = read(&picture);
  warnings = error.base.num_warnings;
  core::Error why;
  if (refusal != Refusal::kNone) why = Explain(refusal, header);  // before abort forgets the header
  if (created) jpeg_abort_decompress(&info);
  if (refusal != Refusal::kNone) return tl::unexpected(std::move(why));
  return picture;
}

core::Expected<ConstImageView> JpegDecoder::Decode(std::span<const std::uint8_t> jpeg,
                                                   const JpegDecodeOptions& options) {
  return impl_->Run<ConstImageView>(
      jpeg, options, [&](ConstImageView* picture) { return impl_->Pixels(options, picture); });
}

core::Expected<ConstYuv420View> JpegDecoder::DecodeYuv420(std::span<const std::uint8_t> jpeg,
                                                          const JpegDecodeOptions& options) {
  return impl_->Run<Yuv420View>(
      jpeg, options, [&](Yuv420View* picture) { return impl_->Planes(options, picture); });
}

long JpegDecoder::warnings() const { return impl_->warnings; }
std::size_t JpegDecoder::buffer_bytes() const {
  return impl_->pixels.capacity() + impl_->planes.capacity_bytes();
}

int ScaleEighthsFor(int width_px, int wanted_px) {
  for (int eighths = 1; eighths < 8; ++eighths) {
    if ((std::int64_t{width_px} * eighths + 7) / 8 >= wanted_px) return eighths;
  }
  return 8;
}

}  // namespace kawara::vision
