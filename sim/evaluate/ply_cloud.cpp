#include "sim/evaluate/ply_cloud.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>

namespace kawara::sim {
namespace {

constexpr std::size_t kMostPoints = 1'000'000'000;

struct Property {
  std::string type;
  std::string name;
};

struct Header {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  Format format = Format::kAscii;
  std::size_t points = 0;
  std::vector<Property> properties;  ///< of a vertex
};

std::size_t SizeOf(const std::string& type) {
  static const std::map<std::string, std::size_t> kSizes{
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto found = kSizes.find(type);
  return found == kSizes.end() ? 0 : found->second;
}

template <class T>
double As(const std::uint8_t* bytes, bool swap) {
  std::array<std::uint8_t, sizeof(T)> ordered;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    ordered[i] = bytes[swap ? sizeof(T) - 1 - i : i];
  }
  return static_cast<double>(std::bit_cast<T>(ordered));
}

double Value(const std::uint8_t* bytes, const std::string& type, bool swap) {
  if (type == "float" || type == "float32") return As<float>(bytes, swap);
  if (type == "double" || type == "float64") return As<double>(bytes, swap);
  if (type == "char" || type == "int8") return As<std::int8_t>(bytes, swap);
  if (type == "uchar" || type == "uint8") return As<std::uint8_t>(bytes, swap);
  if (type == "short" || type == "int16") return As<std::int16_t>(bytes, swap);
  if (type == "ushort" || type == "uint16") return As<std::uint16_t>(bytes, swap);
  if (type == "int" || type == "int32") return As<std::int32_t>(bytes, swap);
  return As<std::uint32_t>(bytes, swap);
}

tl::unexpected<core::Error> Wrong(const std::string& path, const std::string& what) {
  return core::Fail(core::ErrorCode::kFormat, path + ": " + what);
}

core::Expected<Header> ReadHeader(std::istream& in, const std::string& path) {
  Header header;
  std::string line;
  std::string element;
  bool first_element = true;
  for (int number = 1; std::getline(in, line); ++number) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    std::istringstream words(line);
    std::string word, name, type;
    words >> word;
    if (number == 1) {
      if (word != "ply") return Wrong(path, "no PLY file");
    } else if (word == "format") {
      words >> type;
      header.format = type == "ascii"                  ? Header::Format::kAscii
                      : type == "binary_little_endian" ? Header::Format::kLittleEndian
                                                       : Header::Format::kBigEndian;
    } else if (word == "element") {
      words >> element;
      if (element == "vertex") {
        if (!first_element) return Wrong(path, "the vertices must be its first element");
        words >> header.points;
        if (!words || header.points > kMostPoints) return Wrong(path, "how many vertices?");
      }
      first_element = false;
    } else if (word == "property" && element == "vertex") {
      words >> type >> name;
      if (SizeOf(type) == 0) {
        return Wrong(path,
                     "line " + std::to_string(number) + ": a vertex property of type " + type);
      }
      header.properties.push_back({type, name});
    } else if (word == "end_header") {
      return header;
    }
    if (number > 10'000) break;
  }
  return Wrong(path, "its header has no end");
}

}  // namespace

core::Expected<std::vector<Eigen::Vector3d>> ReadPlyPoints(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return core::Fail(core::ErrorCode::kNotFound, path + ": cannot be opened");
  const auto header = ReadHeader(in, path);
  if (!header) return tl::unexpected(header.error());
  std::array<int, 3> column{-1, -1, -1};
  std::vector<std::size_t> offsets;
  std::size_t stride = 0;
  for (std::size_t i = 0; i < header->properties.size(); ++i) {
    const Property& p = header->properties[i];
    if (p.name == "x" || p.name == "y" || p.name == "z") {
      column[static_cast<std::size_t>(p.name[0] - 'x')] = static_cast<int>(i);
    }
    offsets.push_back(stride);
    stride += SizeOf(p.type);
  }
  if (column[0] < 0 || column[1] < 0 || column[2] < 0) return Wrong(path, "no x, y, z of vertices");

  const bool swap = header->format == Header::Format::kBigEndian;
  std::vector<Eigen::Vector3d> points;
  std::vector<std::uint8_t> bytes(stride);
  std::vector<double> numbers(header->properties.size());
  for (std::size_t i = 0; i < header->points; ++i) {
    Eigen::Vector3d point;
    if (header->format == Header::Format::kAscii) {
      for (double& number : numbers) in >> number;
      for (std::size_t k = 0; k < 3; ++k) {
        point[static_cast<Eigen::Index>(k)] = numbers[static_cast<std::size_t>(column[k])];
      }
    } else {
      in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(stride));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto c = static_cast<std::size_t>(column[k]);
        point[static_cast<Eigen::Index>(k)] =
            Value(bytes.data() + offsets[c], header->properties[c].type, swap);
      }
    }
    if (!in) {
      return Wrong(path, "ends after " + std::to_string(i) + " of " +
                             std::to_string(header->points) + " vertices");
    }
    if (point.allFinite()) points.push_back(point);
  }
  return points;
}

core::Expected<void> WritePlyPoints(const std::string& path,
                                    const std::vector<Eigen::Vector3d>& points) {
  std::ofstream out(path, std::ios::binary);
  out << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nend_header\n";
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3f p = point.cast<float>();
    out.write(reinterpret_cast<const char*>(p.data()), 3 * sizeof(float));
  }
  out.flush();
  if (!out) return core::Fail(core::ErrorCode::kIo, path + ": cannot be written (disk full?)");
  return {};
}

}  // namespace kawara::sim
