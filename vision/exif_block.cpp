#include "vision/exif_block.hpp"

#include <algorithm>

namespace kawara::vision {
namespace {

constexpr std::uint16_t kTagExifDirectory = 0x8769;
constexpr std::uint16_t kTagGpsDirectory = 0x8825;
constexpr std::size_t kHeaderBytes = 8;
constexpr std::size_t kEntryBytes = 12;
constexpr std::size_t kMaxEntries = 1000;  // real directories have under a hundred

enum Type : std::uint16_t {
  kByte = 1,
  kAscii = 2,
  kShort = 3,
  kLong = 4,
  kRational = 5,
  kUndefined = 7
};

std::uint32_t TypeBytes(std::uint16_t type) {
  constexpr std::uint8_t kBytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8};
  return type < std::size(kBytes) ? kBytes[type] : 0;
}

}  // namespace

ExifBlock::ExifBlock() = default;

std::uint32_t ExifBlock::Get(std::span<const std::uint8_t> bytes, std::size_t at, int size) const {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i) {
    const int shift = 8 * (big_endian_ ? size - 1 - i : i);
    value |= std::uint32_t{bytes[at + static_cast<std::size_t>(i)]} << shift;
  }
  return value;
}

void ExifBlock::Put(std::uint32_t value, int size, std::vector<std::uint8_t>* out) const {
  for (int i = 0; i < size; ++i) {
    const int shift = 8 * (big_endian_ ? size - 1 - i : i);
    out->push_back(static_cast<std::uint8_t>(value >> shift));
  }
}

std::optional<ExifBlock> ExifBlock::Parse(std::span<const std::uint8_t> tiff) {
  if (tiff.size() < kHeaderBytes) return {};
  ExifBlock block;
  if (tiff[0] == 'M' && tiff[1] == 'M') {
    block.big_endian_ = true;
  } else if (tiff[0] != 'I' || tiff[1] != 'I') {
    return {};
  }
  if (block.Get(tiff, 2, 2) != 42) return {};
  block.old_.assign(tiff.begin(), tiff.end());
  auto primary = block.ReadDirectory(block.Get(tiff, 4, 4), &block.next_directory_);
  if (!primary) return {};
  block.entries(Directory::kPrimary) = std::move(*primary);
  for (const auto& [directory, tag] : {std::pair{Directory::kExif, kTagExifDirectory},
                                       std::pair{Directory::kGps, kTagGpsDirectory}}) {
    const auto offset = block.Unsigned(Directory::kPrimary, tag);
    std::uint32_t unused = 0;
    if (!offset) continue;
    if (auto read = block.ReadDirectory(*offset, &unused))
      block.entries(directory) = std::move(*read);
  }
  return block;
}

std::optional<ExifBlock::Entries> ExifBlock::ReadDirectory(std::uint32_t offset,
                                                           std::uint32_t* next) const {
  if (offset < kHeaderBytes || std::size_t{offset} + 2 > old_.size()) return {};
  const std::size_t count = Get(old_, offset, 2);
  const std::size_t end = std::size_t{offset} + 2 + count * kEntryBytes;
  if (count == 0 || count > kMaxEntries || end > old_.size()) return {};
  Entries list;
  for (std::size_t at = std::size_t{offset} + 2; at < end; at += kEntryBytes) {
    Entry entry;
    entry.tag = static_cast<std::uint16_t>(Get(old_, at, 2));
    entry.type = static_cast<std::uint16_t>(Get(old_, at + 2, 2));
    entry.count = Get(old_, at + 4, 4);
    const std::uint64_t bytes = std::uint64_t{entry.count} * TypeBytes(entry.type);
    if (bytes == 0) continue;
    std::size_t from = at + 8;
    if (bytes > 4) {
      from = entry.old_offset = Get(old_, at + 8, 4);
      if (from < kHeaderBytes || from + bytes > old_.size()) continue;
    }
    const auto first = old_.begin() + static_cast<std::ptrdiff_t>(from);
    entry.value.assign(first, first + static_cast<std::ptrdiff_t>(bytes));
    list.push_back(std::move(entry));
  }
  *next = end + 4 <= old_.size() ? Get(old_, end, 4) : 0;
  // A thumbnail directory is passed on by its offset: only if something can be there.
  if (*next < kHeaderBytes || std::size_t{*next} + 2 > old_.size()) *next = 0;
  return list;
}

const ExifBlock::Entry* ExifBlock::Find(Directory d, std::uint16_t tag) const {
  for (const Entry& entry : entries(d)) {
    if (entry.tag == tag) return &entry;
  }
  return nullptr;
}

void ExifBlock::Set(Directory d, Entry entry) {
  Remove(d, entry.tag);
  entries(d).push_back(std::move(entry));
}

void ExifBlock::SetAscii(Directory d, std::uint16_t tag, std::string_view text) {
  Entry entry{tag, kAscii, static_cast<std::uint32_t>(text.size() + 1), {text.begin(), text.end()}};
  entry.value.push_back(0);
  Set(d, std::move(entry));
}

void ExifBlock::SetByte(Directory d, std::uint16_t tag, std::span<const std::uint8_t> values) {
  Set(d, {tag, kByte, static_cast<std::uint32_t>(values.size()), {values.begin(), values.end()}});
}

void ExifBlock::SetUndefined(Directory d, std::uint16_t tag, std::string_view bytes) {
  Set(d, {tag, kUndefined, static_cast<std::uint32_t>(bytes.size()), {bytes.begin(), bytes.end()}});
}

void ExifBlock::SetShort(Directory d, std::uint16_t tag, std::uint16_t value) {
  Entry entry{tag, kShort, 1, {}};
  Put(value, 2, &entry.value);
  Set(d, std::move(entry));
}

void ExifBlock::SetLong(Directory d, std::uint16_t tag, std::uint32_t value) {
  Entry entry{tag, kLong, 1, {}};
  Put(value, 4, &entry.value);
  Set(d, std::move(entry));
}

void ExifBlock::SetRationals(Directory d, std::uint16_t tag, std::span<const Rational> values) {
  Entry entry{tag, kRational, static_cast<std::uint32_t>(values.size()), {}};
  for (const auto& [numerator, denominator] : values) {
    Put(numerator, 4, &entry.value);
    Put(denominator, 4, &entry.value);
  }
  Set(d, std::move(entry));
}

void ExifBlock::Remove(Directory d, std::uint16_t tag) {
  std::erase_if(entries(d), [&](const Entry& entry) { return entry.tag == tag; });
}

void ExifBlock::Clear(Directory d) { entries(d).clear(); }

bool ExifBlock::Has(Directory d, std::uint16_t tag) const { return Find(d, tag) != nullptr; }

std::optional<std::string> ExifBlock::Ascii(Directory d, std::uint16_t tag) const {
  const Entry* entry = Find(d, tag);
  if (entry == nullptr || entry->type != kAscii) return {};
  std::string text(entry->value.begin(), entry->value.end());
  text.erase(std::find(text.begin(), text.end(), '\0'), text.end());
  return text;
}

std::optional<std::uint32_t> ExifBlock::Unsigned(Directory d, std::uint16_t tag) const {
  const Entry* entry = Find(d, tag);
  if (entry == nullptr) return {};
  if (entry->type == kByte) return entry->value[0];
  if (entry->type == kShort) return Get(entry->value, 0, 2);
  if (entry->type == kLong) return Get(entry->value, 0, 4);
  return {};
}

std::vector<ExifBlock::Rational> ExifBlock::Rationals(Directory d, std::uint16_t tag) const {
  const Entry* entry = Find(d, tag);
  std::vector<Rational> values;
  if (entry == nullptr || entry->type != kRational) return values;
  for (std::size_t at = 0; at + 8 <= entry->value.size(); at += 8) {
    values.emplace_back(Get(entry->value, at, 4), Get(entry->value, at + 4, 4));
  }
  return values;
}

void ExifBlock::AppendDirectory(const Entries& list, std::uint32_t next,
                                std::vector<std::uint8_t>* out) const {
  Entries sorted = list;
  std::sort(sorted.begin(), sorted.end(),
            [](const Entry& a, const Entry& b) { return a.tag < b.tag; });
  std::uint32_t values_at =
      static_cast<std::uint32_t>(out->size() + 2 + sorted.size() * kEntryBytes + 4);
  std::vector<std::uint8_t> values;
  Put(static_cast<std::uint32_t>(sorted.size()), 2, out);
  for (const Entry& entry : sorted) {
    Put(entry.tag, 2, out);
    Put(entry.type, 2, out);
    Put(entry.count, 4, out);
    if (entry.value.size() <= 4) {
      out->insert(out->end(), entry.value.begin(), entry.value.end());
      out->insert(out->end(), 4 - entry.value.size(), 0);
    } else if (entry.old_offset != 0) {
      Put(entry.old_offset, 4, out);
    } else {
      Put(values_at + static_cast<std::uint32_t>(values.size()), 4, out);
      values.insert(values.end(), entry.value.begin(), entry.value.end());
      if (values.size() % 2 != 0) values.push_back(0);  // TIFF: values begin on words
    }
  }
  Put(next, 4, out);
  out->insert(out->end(), values.begin(), values.end());
}

std::vector<std::uint8_t> ExifBlock::Serialize() const {
  std::vector<std::uint8_t> out = old_;
  if (out.empty()) {
    out.assign(2, static_cast<std::uint8_t>(big_endian_ ? 'M' : 'I'));
    Put(42, 2, &out);
    Put(kHeaderBytes, 4, &out);
  }
  if (out.size() % 2 != 0) out.push_back(0);
  const auto size_of = [](const Entries& list) {
    std::size_t bytes = 2 + list.size() * kEntryBytes + 4;
    for (const Entry& entry : list) {
      if (entry.value.size() > 4 && entry.old_offset == 0)
        bytes += (entry.value.size() + 1) & ~std::size_t{1};
    }
    return static_cast<std::uint32_t>(bytes);
  };
  // The primary directory names the offsets of the two others, so their place is computed first.
  ExifBlock primary = *this;
  const std::uint32_t primary_at = static_cast<std::uint32_t>(out.size());
  for (const auto& [directory, tag] : {std::pair{Directory::kExif, kTagExifDirectory},
                                       std::pair{Directory::kGps, kTagGpsDirectory}}) {
    primary.Remove(Directory::kPrimary, tag);
    if (!entries(directory).empty()) primary.SetLong(Directory::kPrimary, tag, 0);
  }
  std::uint32_t at = primary_at + size_of(primary.entries(Directory::kPrimary));
  for (const auto& [directory, tag] : {std::pair{Directory::kExif, kTagExifDirectory},
                                       std::pair{Directory::kGps, kTagGpsDirectory}}) {
    if (entries(directory).empty()) continue;
    primary.SetLong(Directory::kPrimary, tag, at);
    at += size_of(entries(directory));
  }
  std::vector<std::uint8_t> header;
  Put(primary_at, 4, &header);
  std::copy(header.begin(), header.end(), out.begin() + 4);
  AppendDirectory(primary.entries(Directory::kPrimary), next_directory_, &out);
  for (Directory directory : {Directory::kExif, Directory::kGps}) {
    if (!entries(directory).empty()) AppendDirectory(entries(directory), 0, &out);
  }
  return out;
}

}  // namespace kawara::vision
