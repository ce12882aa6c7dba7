#include <bit>
#include <string>

#include "vision/png.hpp"
#include "vision/png_error.hpp"

namespace kawara::vision {
namespace {

static_assert(std::endian::native == std::endian::little, "png_set_swap below");

struct Layout {
  const std::uint8_t* pixels;
  int width_px, height_px;
  std::size_t row_bytes;
  int colour_type, bits;
};

/// Everything that libpng's jumps must not skip.
class Writer {
 public:
  Writer() {
    png_ = png_create_write_struct(PNG_LIBPNG_VER_STRING, &error_, GiveUpPng, IgnorePngWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~Writer() { png_destroy_write_struct(&png_, &info_); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  bool Run(const Layout& picture, int effort) {
    if (info_ == nullptr) return false;
    if (setjmp(error_.back) != 0) return false;
    png_set_write_fn(png_, this, Write, nullptr);
    png_set_compression_level(png_, effort);
    png_set_IHDR(png_, info_, static_cast<png_uint_32>(picture.width_px),
                 static_cast<png_uint_32>(picture.height_px), picture.bits, picture.colour_type,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_write_info(png_, info_);
    if (picture.bits == 16) png_set_swap(png_);
    for (int v = 0; v < picture.height_px; ++v) {
      png_write_row(png_, picture.pixels + picture.row_bytes * static_cast<std::size_t>(v));
    }
    png_write_end(png_, nullptr);
    return true;
  }
  std::vector<std::uint8_t>& file() { return file_; }
  const char* words() const { return error_.message; }

 private:
  static void Write(png_structp png, png_bytep from, std::size_t bytes) {
    auto& file = static_cast<Writer*>(png_get_io_ptr(png))->file_;
    file.insert(file.end(), from, from + bytes);
  }

  PngError error_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::vector<std::uint8_t> file_;
};

core::Expected<std::vector<std::uint8_t>> Encode(const Layout& picture, int effort) {
  Writer writer;
  if (!writer.Run(picture, effort)) {
    return core::Fail(core::ErrorCode::kInvalidArgument, std::string("PNG: ") + writer.words());
  }
  return std::move(writer.file());
}

}  // namespace

core::Expected<std::vector<std::uint8_t>> EncodePng(const ConstImageView& picture, int effort) {
  if (picture.empty()) return core::Fail(core::ErrorCode::kInvalidArgument, "PNG: empty picture");
  return Encode({picture.data, picture.width_px, picture.height_px, picture.stride_bytes(),
                 PNG_COLOR_TYPE_RGB, 8},
                effort);
}

core::Expected<std::vector<std::uint8_t>> EncodePng(const Grey16Picture& picture, int effort) {
  const auto width = static_cast<std::size_t>(picture.width_px);
  const bool sound = picture.width_px > 0 && picture.height_px > 0 &&
                     picture.level.size() == width * static_cast<std::size_t>(picture.height_px);
  if (!sound) return core::Fail(core::ErrorCode::kInvalidArgument, "PNG: not a whole picture");
  return Encode({reinterpret_cast<const std::uint8_t*>(picture.level.data()), picture.width_px,
                 picture.height_px, sizeof(std::uint16_t) * width, PNG_COLOR_TYPE_GRAY, 16},
                effort);
}

}  // namespace kawara::vision
