#include <algorithm>
#include <cstring>
#include <string>

#include "vision/png.hpp"
#include "vision/png_error.hpp"

namespace kawara::vision {
namespace {

/// Deflate makes at most this many bytes of one. Source: zlib's Technical Details, "Maximum
/// Compression Factor".
constexpr std::uint64_t kMostBytesOfOne = 1032;
/// Of one chunk beside the picture (text, profiles); a file's honest ones are far smaller.
constexpr png_alloc_size_t kMaxChunkBytes = 1 << 23;
constexpr int kSixteenBits = 16;

enum class Want { kRgb, kRgb16, kGrey16 };
enum class Refusal { kNone, kLibpng, kTooLarge, kImplausible, kNotGrey16 };

/// Everything that libpng's jumps must not skip.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> file) : rest_(file), bytes_(file.size()) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, &error_, GiveUpPng, IgnorePngWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
  }
  ~Reader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;

  Refusal Header(Want want, std::int64_t max_pixels);
  /// After Header. `row_bytes`: of the picture wanted.
  Refusal Pixels(Want want, std::uint8_t* pixels, std::size_t row_bytes);

  int width_px() const { return static_cast<int>(png_get_image_width(png_, info_)); }
  int height_px() const { return static_cast<int>(png_get_image_height(png_, info_)); }
  bool sixteen_bits() const { return png_get_bit_depth(png_, info_) == kSixteenBits; }
  /// Of the most precise channel, as the file says (chunk sBIT); 0: it does not.
  int StatedBits() const;
  const char* words() const { return error_.message; }

 private:
  static void Read(png_structp png, png_bytep to, std::size_t bytes) {
    auto* reader = static_cast<Reader*>(png_get_io_ptr(png));
    if (bytes > reader->rest_.size()) GiveUpPng(png, "the file ends early");
    std::memcpy(to, reader->rest_.data(), bytes);
    reader->rest_ = reader->rest_.subspan(bytes);
  }

  PngError error_;
  std::span<const std::uint8_t> rest_;
  std::size_t bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
  std::vector<png_bytep> rows_;
};

Refusal Reader::Header(Want want, std::int64_t max_pixels) {
  if (info_ == nullptr) return Refusal::kLibpng;
  if (setjmp(error_.back) != 0) return Refusal::kLibpng;
  png_set_read_fn(png_, this, Read);
  png_set_chunk_malloc_max(png_, kMaxChunkBytes);
  png_read_info(png_, info_);
  const std::int64_t pixels =
      std::int64_t{png_get_image_width(png_, info_)} * png_get_image_height(png_, info_);
  if (pixels > std::min(max_pixels, kMaxPngPixels)) return Refusal::kTooLarge;
  const std::uint64_t raw = std::uint64_t{png_get_image_height(png_, info_)} *
                            std::max<std::uint64_t>(1, png_get_rowbytes(png_, info_));
  if (raw > kMostBytesOfOne * bytes_) return Refusal::kImplausible;
  const bool grey16 = png_get_color_type(png_, info_) == PNG_COLOR_TYPE_GRAY &&
                      png_get_bit_depth(png_, info_) == kSixteenBits &&
                      png_get_valid(png_, info_, PNG_INFO_tRNS) == 0;
  return want == Want::kGrey16 && !grey16 ? Refusal::kNotGrey16 : Refusal::kNone;
}

int Reader::StatedBits() const {
  png_color_8p bits = nullptr;
  if (png_get_sBIT(png_, info_, &bits) == 0 || bits == nullptr) return 0;
  return std::max({bits->red, bits->green, bits->blue, bits->gray});
}

Refusal Reader::Pixels(Want want, std::uint8_t* pixels, std::size_t row_bytes) {
  rows_.resize(png_get_image_height(png_, info_));
  for (std::size_t v = 0; v < rows_.size(); ++v) rows_[v] = pixels + v * row_bytes;
  if (setjmp(error_.back) != 0) return Refusal::kLibpng;
  if (want == Want::kGrey16) {
    png_set_swap(png_);  // the file has the upper byte first
  } else {
    png_set_palette_to_rgb(png_);
    png_set_expand_gray_1_2_4_to_8(png_);
    if (want == Want::kRgb16) png_set_swap(png_);
    png_set_strip_alpha(png_);
    png_set_gray_to_rgb(png_);
  }
  png_set_interlace_handling(png_);
  png_read_update_info(png_, info_);
  if (png_get_rowbytes(png_, info_) != row_bytes) GiveUpPng(png_, "rows of another length");
  png_read_image(png_, rows_.data());
  png_read_end(png_, nullptr);
  return Refusal::kNone;
}

core::Error Explain(Refusal refusal, const Reader& reader) {
  const auto said = [](std::string words) {
    return core::Error{core::ErrorCode::kFormat, "PNG: " + std::move(words)};
  };
  if (refusal == Refusal::kLibpng) return said(reader.words());
  const std::string size =
      std::to_string(reader.width_px()) + " x " + std::to_string(reader.height_px()) + " px";
  switch (refusal) {
    case Refusal::kTooLarge:
      return said(size + " is more than this program takes");
    case Refusal::kImplausible:
      return said("the file is too short for its " + size);
    default:
      return said("expected grey of 16 bits without transparency");
  }
}

/// Cameras of 10, 12 and 14 bits are written into 16, by most programs at their lower end.
int BitsFor(std::uint16_t largest) {
  for (const int bits : {8, 10, 12, 14}) {
    if (largest < 1 << bits) return bits;
  }
  return kSixteenBits;
}

Refusal ReadSixteenBits(Reader& reader, RgbPicture& picture) {
  std::vector<std::uint16_t> levels(picture.rgb.size());
  const Refusal refusal =
      reader.Pixels(Want::kRgb16, reinterpret_cast<std::uint8_t*>(levels.data()),
                    sizeof(std::uint16_t) * picture.view().stride_bytes());
  if (refusal != Refusal::kNone) return refusal;
  const auto largest = levels.empty() ? std::uint16_t{0} : *std::ranges::max_element(levels);
  // A file that states fewer bits has them at the upper end (ISO/IEC 15948, 11.3.3.4).
  const int used = reader.StatedBits() > 0 ? kSixteenBits : BitsFor(largest);
  std::ranges::transform(levels, picture.rgb.begin(), [used](std::uint16_t level) {
    return static_cast<std::uint8_t>(level >> (used - 8));
  });
  return Refusal::kNone;
}

}  // namespace

core::Expected<RgbPicture> DecodePng(std::span<const std::uint8_t> png, std::int64_t max_pixels) {
  Reader reader(png);
  Refusal refusal = reader.Header(Want::kRgb, max_pixels);
  if (refusal != Refusal::kNone) return tl::unexpected(Explain(refusal, reader));
  RgbPicture picture{{}, reader.width_px(), reader.height_px()};
  picture.rgb.resize(picture.view().size_bytes());
  refusal = reader.sixteen_bits()
                ? ReadSixteenBits(reader, picture)
                : reader.Pixels(Want::kRgb, picture.rgb.data(), picture.view().stride_bytes());
  if (refusal != Refusal::kNone) return tl::unexpected(Explain(refusal, reader));
  return picture;
}

core::Expected<Grey16Picture> DecodeGrey16Png(std::span<const std::uint8_t> png,
                                              std::int64_t max_pixels) {
  Reader reader(png);
  Refusal refusal = reader.Header(Want::kGrey16, max_pixels);
  if (refusal != Refusal::kNone) return tl::unexpected(Explain(refusal, reader));
  Grey16Picture picture{{}, reader.width_px(), reader.height_px()};
  const auto width = static_cast<std::size_t>(picture.width_px);
  picture.level.resize(width * static_cast<std::size_t>(picture.height_px));
  refusal = reader.Pixels(Want::kGrey16, reinterpret_cast<std::uint8_t*>(picture.level.data()),
                          sizeof(std::uint16_t) * width);
  if (refusal != Refusal::kNone) return tl::unexpected(Explain(refusal, reader));
  return picture;
}

}  // namespace kawara::vision
