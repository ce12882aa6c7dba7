#include "gis/model/ply_reader.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace kawara::gis {
namespace {

static_assert(std::endian::native == std::endian::little, "PLY is read as it lies in memory");

/// The file's numbers that are wanted, in the order of `Layout::at`.
constexpr std::array<std::string_view, 6> kWanted{"x", "y", "z", "red", "green", "blue"};
constexpr std::size_t kFirstColour = 3;

/// Where a corner's numbers lie in its bytes.
struct Layout {
  std::size_t count = 0;   ///< corners
  std::size_t stride = 0;  ///< bytes a corner
  std::array<std::optional<std::size_t>, kWanted.size()> at;
  std::array<bool, kFirstColour> is_double{};
  std::size_t first_byte = 0;  ///< of the first corner in the file
};

std::size_t BytesOf(std::string_view type) {
  struct Size {
    std::string_view name;
    std::size_t bytes;
  };
  constexpr std::array<Size, 16> kSizes{{{"char", 1},
                                         {"uchar", 1},
                                         {"int8", 1},
                                         {"uint8", 1},
                                         {"short", 2},
                                         {"ushort", 2},
                                         {"int16", 2},
                                         {"uint16", 2},
                                         {"int", 4},
                                         {"uint", 4},
                                         {"int32", 4},
                                         {"uint32", 4},
                                         {"float", 4},
                                         {"float32", 4},
                                         {"double", 8},
                                         {"float64", 8}}};
  for (const Size& size : kSizes) {
    if (size.name == type) return size.bytes;
  }
  return 0;
}

/// The next line without its end; moves on. Empty: there is none.
std::optional<std::string_view> NextLine(std::string_view file, std::size_t& at) {
  const std::size_t end = file.find('\n', at);
  if (end == std::string_view::npos) return {};
  std::string_view line = file.substr(at, end - at);
  if (line.ends_with('\r')) line.remove_suffix(1);
  at = end + 1;
  return line;
}

/// The word before the first blank; the line goes on after it.
std::string_view TakeWord(std::string_view& line) {
  const std::string_view word = line.substr(0, line.find(' '));
  line.remove_prefix(std::min(line.size(), word.size() + 1));
  return word;
}

/// False: not a type of a fixed size, or none for this number.
bool AddProperty(std::string_view line, Layout& layout) {
  const std::string_view type = TakeWord(line);
  const std::size_t bytes = BytesOf(type);
  if (bytes == 0) return false;
  for (std::size_t i = 0; i < kWanted.size(); ++i) {
    if (line != kWanted[i]) continue;
    const bool is_double = type == "double" || type == "float64";
    const bool fits = i < kFirstColour ? is_double || type == "float" || type == "float32"
                                       : type == "uchar" || type == "uint8";
    if (!fits) return false;
    if (i < kFirstColour) layout.is_double[i] = is_double;
    layout.at[i] = layout.stride;
  }
  layout.stride += bytes;
  return true;
}

/// Empty: not such a file.
std::optional<Layout> ReadHeader(std::string_view file) {
  Layout layout;
  std::size_t at = 0;
  if (NextLine(file, at) != "ply") return {};
  if (NextLine(file, at) != "format binary_little_endian 1.0") return {};
  int elements = 0;
  while (auto line = NextLine(file, at)) {
    const std::string_view what = TakeWord(*line);
    if (what == "end_header") {
      layout.first_byte = at;
      for (const auto& place : layout.at) {
        if (!place) return {};
      }
      return layout;
    }
    if (what == "element" && elements++ == 0) {
      if (TakeWord(*line) != "vertex") return {};
      const auto read = std::from_chars(line->data(), line->data() + line->size(), layout.count);
      if (read.ec != std::errc() || read.ptr != line->data() + line->size()) return {};
    } else if (what == "property" && elements == 1) {
      if (!AddProperty(*line, layout)) return {};
    }
  }
  return {};
}

double NumberAt(const char* from, bool is_double) {
  double wide = 0.0;
  float narrow = 0.0F;
  if (is_double) {
    std::memcpy(&wide, from, sizeof wide);
    return wide;
  }
  std::memcpy(&narrow, from, sizeof narrow);
  return static_cast<double>(narrow);
}

}  // namespace

core::Expected<std::vector<core::ColouredPoint>> ReadPlyPoints(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  if (error) return tl::unexpected(core::ErrnoError("read " + path.string(), error.value()));
  std::string file(size, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in.read(file.data(), static_cast<std::streamsize>(size))) {
    return core::Fail(core::ErrorCode::kIo, "read " + path.string() + ": could not be read");
  }
  const auto layout = ReadHeader(file);
  if (!layout || (file.size() - layout->first_byte) / layout->stride < layout->count) {
    return core::Fail(core::ErrorCode::kFormat,
                      path.string() + ": not a whole binary PLY file with coloured corners");
  }
  std::vector<core::ColouredPoint> points(layout->count);
  const char* corner = file.data() + layout->first_byte;
  for (core::ColouredPoint& point : points) {
    for (std::size_t k = 0; k < kFirstColour; ++k) {
      point.position_m[static_cast<Eigen::Index>(k)] =
          NumberAt(corner + *layout->at[k], layout->is_double[k]);
      std::memcpy(&point.colour[k], corner + *layout->at[kFirstColour + k], 1);
    }
    corner += layout->stride;
  }
  return points;
}

}  // namespace kawara::gis
