#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kawara::vision {

/// The TIFF structure inside an Exif APP1 segment (without the "Exif\0\0" before it), as far as a
/// picture's place, time and direction need it: the primary, Exif and GPS directories. Source: CIPA
/// DC-008 (Exif 2.31) 4.5, 4.6; TIFF 6.0.
///
/// A parsed block keeps all its old bytes at their old offsets and gets its changed directories
/// appended: maker notes, which hold offsets nobody documents, thumbnails and interoperability
/// directories stay valid.
class ExifBlock {
 public:
  enum class Directory { kPrimary, kExif, kGps };
  using Rational = std::pair<std::uint32_t, std::uint32_t>;

  /// An empty block, little-endian.
  ExifBlock();
  /// Empty on anything that is not a TIFF header with a readable primary directory. Single entries
  /// that point outside are dropped. Copies what it needs.
  static std::optional<ExifBlock> Parse(std::span<const std::uint8_t> tiff);

  void SetAscii(Directory d, std::uint16_t tag, std::string_view text);
  void SetByte(Directory d, std::uint16_t tag, std::span<const std::uint8_t> values);
  void SetUndefined(Directory d, std::uint16_t tag, std::string_view bytes);
  void SetShort(Directory d, std::uint16_t tag, std::uint16_t value);
  void SetLong(Directory d, std::uint16_t tag, std::uint32_t value);
  void SetRationals(Directory d, std::uint16_t tag, std::span<const Rational> values);
  void Remove(Directory d, std::uint16_t tag);
  void Clear(Directory d);
  bool Has(Directory d, std::uint16_t tag) const;

  /// Readers: empty if the tag is missing or of another type. Ascii comes without its terminating
  /// zeros.
  std::optional<std::string> Ascii(Directory d, std::uint16_t tag) const;
  /// BYTE, SHORT or LONG, first value.
  std::optional<std::uint32_t> Unsigned(Directory d, std::uint16_t tag) const;
  std::vector<Rational> Rationals(Directory d, std::uint16_t tag) const;

  std::vector<std::uint8_t> Serialize() const;

 private:
  struct Entry {
    std::uint16_t tag = 0;
    std::uint16_t type = 0;
    std::uint32_t count = 0;
    std::vector<std::uint8_t> value;  ///< in the block's byte order
    std::uint32_t old_offset = 0;     ///< where `value` lies in old_; 0: nowhere
  };
  using Entries = std::vector<Entry>;

  Entries& entries(Directory d) { return directories_[static_cast<std::size_t>(d)]; }
  const Entries& entries(Directory d) const { return directories_[static_cast<std::size_t>(d)]; }
  const Entry* Find(Directory d, std::uint16_t tag) const;
  void Set(Directory d, Entry entry);
  std::optional<Entries> ReadDirectory(std::uint32_t offset, std::uint32_t* next) const;
  void AppendDirectory(const Entries& list, std::uint32_t next,
                       std::vector<std::uint8_t>* out) const;

  std::uint32_t Get(std::span<const std::uint8_t> bytes, std::size_t at, int size) const;
  void Put(std::uint32_t value, int size, std::vector<std::uint8_t>* out) const;

  bool big_endian_ = false;
  std::vector<std::uint8_t> old_;     ///< the parsed block, kept in place
  std::uint32_t next_directory_ = 0;  ///< the thumbnail's, in old_
  Entries directories_[3];
};

}  // namespace kawara::vision
