#include "gis/cloud/ply_header.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <utility>

namespace kawara::gis {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kLongestLine = 65'536;
constexpr std::uint64_t kMostLines = 100'000;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypes{{
    {"char", PlyType::kInt8},
    {"int8", PlyType::kInt8},
    {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},
    {"short", PlyType::kInt16},
    {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},
    {"uint16", PlyType::kUint16},
    {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},
    {"uint", PlyType::kUint32},
    {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat32},
    {"float32", PlyType::kFloat32},
    {"double", PlyType::kFloat64},
    {"float64", PlyType::kFloat64},
}};

std::optional<PlyType> TypeOf(std::string_view name) {
  for (const auto& [known, type] : kTypes)
    if (known == name) return type;
  return std::nullopt;
}

std::string_view Word(std::string_view& line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  if (begin == std::string_view::npos) return line = {};
  line.remove_prefix(begin);
  const std::string_view word = line.substr(0, line.find_first_of(" \t"));
  line.remove_prefix(word.size());
  return word;
}

std::string Rest(std::string_view line) {
  const std::size_t begin = line.find_first_not_of(" \t");
  return begin == std::string_view::npos ? "" : std::string(line.substr(begin));
}

template <class T>
double As(const std::uint8_t* bytes, bool swap) {
  std::array<std::uint8_t, sizeof(T)> ordered;
  for (std::size_t i = 0; i < sizeof(T); ++i) ordered[i] = bytes[swap ? sizeof(T) - 1 - i : i];
  return static_cast<double>(std::bit_cast<T>(ordered));
}

/// What is wrong with a line; empty: nothing.
std::string TakeLine(PlyHeader& header, std::string_view line) {
  const std::string_view keyword = Word(line);
  if (keyword.empty()) return "";
  if (keyword == "format") {
    const std::string_view format = Word(line);
    if (format == "ascii") {
      header.format = PlyHeader::Format::kAscii;
    } else if (format == "binary_little_endian") {
      header.format = PlyHeader::Format::kLittleEndian;
    } else if (format == "binary_big_endian") {
      header.format = PlyHeader::Format::kBigEndian;
    } else {
      return "an unknown format, " + std::string(format);
    }
  } else if (keyword == "comment" || keyword == "obj_info") {
    header.comments.push_back(Rest(line));
  } else if (keyword == "element") {
    PlyElement element;
    element.name = std::string(Word(line));
    const std::string_view count = Word(line);
    const auto [end, error] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (element.name.empty() || error != std::errc() || end != count.data() + count.size())
      return "how many of element " + element.name + "?";
    header.elements.push_back(std::move(element));
  } else if (keyword == "property") {
    if (header.elements.empty()) return "a property before any element";
    PlyProperty property;
    std::string_view type = Word(line);
    if (type == "list") {
      const std::string_view count_type = Word(line);
      property.count_type = TypeOf(count_type);
      if (!property.count_type || *property.count_type >= PlyType::kFloat32)
        return "a list counted in " + std::string(count_type);
      type = Word(line);
    }
    const auto known = TypeOf(type);
    if (!known) return "a property of type " + std::string(type);
    property.type = *known;
    property.name = std::string(Word(line));
    if (property.name.empty()) return "a property without a name";
    header.elements.back().properties.push_back(std::move(property));
  } else {
    return "an unknown keyword, " + std::string(keyword.substr(0, 40));
  }
  return "";
}

}  // namespace

std::size_t SizeOf(PlyType type) {
  constexpr std::array<std::size_t, 8> kSizes{1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

double PlyValue(PlyType type, const std::uint8_t* bytes, bool swap) {
  switch (type) {
    case PlyType::kInt8:
      return As<std::int8_t>(bytes, swap);
    case PlyType::kUint8:
      return As<std::uint8_t>(bytes, swap);
    case PlyType::kInt16:
      return As<std::int16_t>(bytes, swap);
    case PlyType::kUint16:
      return As<std::uint16_t>(bytes, swap);
    case PlyType::kInt32:
      return As<std::int32_t>(bytes, swap);
    case PlyType::kUint32:
      return As<std::uint32_t>(bytes, swap);
    case PlyType::kFloat32:
      return As<float>(bytes, swap);
    case PlyType::kFloat64:
      break;
  }
  return As<double>(bytes, swap);
}

std::optional<std::size_t> PlyElement::stride() const {
  std::size_t bytes = 0;
  for (const PlyProperty& p : properties) {
    if (p.count_type) return std::nullopt;
    bytes += SizeOf(p.type);
  }
  return bytes;
}

core::Expected<PlyHeader> ReadPlyHeader(ByteSource& source) {
  const auto wrong = [&source](std::uint64_t line, const std::string& what) {
    return core::Fail(core::ErrorCode::kFormat,
                      source.name() + ": line " + std::to_string(line) + ": " + what);
  };
  PlyHeader header;
  std::string_view line;
  bool has_format = false;
  while (source.Line(line, kLongestLine)) {
    ++header.lines;
    std::string_view rest = line;
    if (header.lines == 1) {
      if (Word(rest) != "ply")
        return core::Fail(core::ErrorCode::kFormat, source.name() + ": no PLY file");
      continue;
    }
    const std::string_view keyword = Word(rest);
    if (keyword == "end_header") {
      if (!has_format) return wrong(header.lines, "its header states no format");
      return header;
    }
    has_format = has_format || keyword == "format";
    if (const std::string what = TakeLine(header, line); !what.empty())
      return wrong(header.lines, what);
    if (header.lines > kMostLines) break;
  }
  return core::Fail(core::ErrorCode::kFormat,
                    source.name() + ": its header has no end (no line \"end_header\")");
}

std::optional<core::Geodetic> OriginFromComment(std::string_view comment) {
  constexpr std::array<std::string_view, 4> kAround{"origin: WGS 84 latitude ", " deg, longitude ",
                                                    " deg, ellipsoidal height ", " m"};
  std::array<double, 3> numbers{};
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!comment.starts_with(kAround[i])) return std::nullopt;
    comment.remove_prefix(kAround[i].size());
    const auto [end, error] =
        std::from_chars(comment.data(), comment.data() + comment.size(), numbers[i]);
    if (error != std::errc() || !std::isfinite(numbers[i])) return std::nullopt;
    comment.remove_prefix(static_cast<std::size_t>(end - comment.data()));
  }
  if (!comment.starts_with(kAround[3]) || std::abs(numbers[0]) > 90.0 ||
      std::abs(numbers[1]) > 360.0)
    return std::nullopt;
  return core::Geodetic{numbers[0] * core::kRadFromDeg, numbers[1] * core::kRadFromDeg, numbers[2]};
}

}  // namespace kawara::gis
