#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "gis/cloud/cloud_reader.hpp"
#include "gis/cloud/ply_header.hpp"

namespace kawara::gis {
namespace {

// A list this long in one vertex or face is damage, not data.
constexpr double kLongestList = 1e7;
constexpr std::size_t kLongestLine = 1U << 26U;

/// What a point is made of, and by which names writers call it.
enum Role : std::size_t { kX, kY, kZ, kRed, kGreen, kBlue, kIntensity, kTime, kRoles };
constexpr std::array<std::array<std::string_view, 7>, kRoles> kNames{{
    {"x"},
    {"y"},
    {"z"},
    {"red", "r", "diffuse_red"},
    {"green", "g", "diffuse_green"},
    {"blue", "b", "diffuse_blue"},
    {"intensity", "Intensity", "scalar_Intensity", "scalar_intensity", "reflectance"},
    {"time", "timestamp", "gps_time", "GpsTime", "scalar_GpsTime", "scalar_Time", "t"},
}};

struct Column {
  std::size_t property = 0;
  std::size_t offset = 0;  ///< bytes, where a vertex has no lists
  bool is_there = false;
};

class PlyReader : public CloudReader {
 public:
  explicit PlyReader(ByteSource source) : CloudReader(std::move(source)) {}
  core::Expected<void> Start();

 protected:
  void Fill(std::size_t most) override;

 private:
  std::string FindColumns();
  void FillFixed(std::size_t most, std::size_t stride);
  /// One of an element, its plain numbers into `values_`; false: the file ends, or error_.
  bool ReadOne(const PlyElement& element);
  bool ReadLine(const PlyElement& element);
  bool ReadBinary(const PlyElement& element);
  void Damaged(const std::string& what);
  CloudPoint PointOf(const std::array<double, kRoles>& v) const;
  std::uint8_t Colour(double value, Role role) const;

  PlyHeader header_;
  PlyElement vertex_;
  std::array<Column, kRoles> columns_;
  std::vector<double> values_;  ///< one a property; lists: unused
  bool swap_ = false;
  std::uint64_t line_ = 0;
};

std::string PlyReader::FindColumns() {
  std::size_t offset = 0;
  for (std::size_t i = 0; i < vertex_.properties.size(); ++i) {
    const PlyProperty& p = vertex_.properties[i];
    for (std::size_t role = 0; role < kRoles; ++role) {
      const auto& names = kNames[role];
      if (p.count_type || p.name.empty() ||
          std::find(names.begin(), names.end(), p.name) == names.end())
        continue;
      if (columns_[role].is_there && role <= kZ) return "two properties " + p.name + " of a vertex";
      if (!columns_[role].is_there) columns_[role] = {i, offset, true};
    }
    offset += SizeOf(p.type);
  }
  for (const Role role : {kX, kY, kZ})
    if (!columns_[role].is_there) return "its vertices have no x, y, z";
  return "";
}

core::Expected<void> PlyReader::Start() {
  auto header = ReadPlyHeader(source_);
  if (!header) return tl::unexpected(header.error());
  header_ = std::move(*header);
  line_ = header_.lines;
  swap_ = header_.format == PlyHeader::Format::kBigEndian;
  info_.format = CloudFormat::kPly;
  info_.comments = header_.comments;
  for (const std::string& comment : header_.comments)
    if (!info_.origin) info_.origin = OriginFromComment(comment);

  const auto vertex = std::find_if(header_.elements.begin(), header_.elements.end(),
                                   [](const PlyElement& e) { return e.name == "vertex"; });
  if (vertex == header_.elements.end())
    return core::Fail(core::ErrorCode::kFormat, source_.name() + ": it has no element vertex");
  vertex_ = *vertex;
  if (const std::string what = FindColumns(); !what.empty())
    return core::Fail(core::ErrorCode::kFormat, source_.name() + ": " + what);
  info_.promised = left_ = vertex_.count;
  info_.has_colour =
      columns_[kRed].is_there && columns_[kGreen].is_there && columns_[kBlue].is_there;
  info_.has_intensity = columns_[kIntensity].is_there;
  info_.has_time = columns_[kTime].is_there;

  for (auto before = header_.elements.begin(); before != vertex; ++before) {
    const auto stride = before->stride();
    if (header_.format != PlyHeader::Format::kAscii && stride) {
      if (*stride > 0 &&
          (before->count > source_.size() / *stride || !source_.Skip(before->count * *stride))) {
        FailAtEnd();
        return tl::unexpected(*error_);
      }
      continue;
    }
    if (before->properties.empty()) continue;  // no bytes
    for (std::uint64_t i = 0; i < before->count; ++i) {
      if (ReadOne(*before)) continue;
      if (!error_) FailAtEnd();
      return tl::unexpected(*error_);
    }
  }
  return {};
}

void PlyReader::Damaged(const std::string& what) {
  error_ = core::Error{core::ErrorCode::kFormat,
                       source_.name() + ": " +
                           (header_.format == PlyHeader::Format::kAscii
                                ? "line " + std::to_string(line_)
                                : "byte " + std::to_string(source_.offset())) +
                           ": " + what + " (after " + std::to_string(info_.promised - left_) +
                           " of " + std::to_string(info_.promised) + " points)"};
}

bool PlyReader::ReadOne(const PlyElement& element) {
  values_.assign(element.properties.size(), 0.0);
  return header_.format == PlyHeader::Format::kAscii ? ReadLine(element) : ReadBinary(element);
}

bool PlyReader::ReadLine(const PlyElement& element) {
  std::string_view line;
  do {
    if (!source_.Line(line, kLongestLine)) return false;
    ++line_;
  } while (line.find_first_not_of(" \t\r") == std::string_view::npos);
  std::size_t found = 0;
  const auto number = [&](double& value) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) {
      line = {};
      return false;
    }
    line.remove_prefix(begin);
    const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
    line.remove_prefix(word.size());
    ++found;
    const char* first = word.data() + (word.starts_with('+') ? 1 : 0);
    const char* last = word.data() + word.size();
    const auto [end, error] = std::from_chars(first, last, value);
    if (error == std::errc::result_out_of_range) value = std::nan("");
    return end == last && (error == std::errc() || error == std::errc::result_out_of_range);
  };
  const auto fail = [&](const std::string& what) {
    const bool is_cut = source_.offset() == source_.size() &&
                        line.find_first_not_of(" \t\r") == std::string_view::npos;
    if (!is_cut) Damaged(what);
    return false;
  };
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    double count = 1.0;
    const bool is_list = element.properties[i].count_type.has_value();
    if (is_list && (!number(count) || !(count >= 0.0 && count <= kLongestList))) {
      return fail("no length of list " + element.properties[i].name);
    }
    for (auto k = static_cast<std::uint64_t>(count); k > 0; --k) {
      double value = 0.0;
      if (!number(value)) {
        return fail("no number for " + element.properties[i].name + ", value " +
                    std::to_string(found) + " of the line");
      }
      if (!is_list) values_[i] = value;
    }
  }
  if (line.find_first_not_of(" \t\r") != std::string_view::npos) {
    Damaged("more values than its element " + element.name + " has properties");
    return false;
  }
  return true;
}

bool PlyReader::ReadBinary(const PlyElement& element) {
  const std::uint64_t begin = source_.offset();
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const PlyProperty& p = element.properties[i];
    const std::size_t first = SizeOf(p.count_type.value_or(p.type));
    const auto bytes = source_.Peek(first);
    if (bytes.size() < first) return false;
    const double value = PlyValue(p.count_type.value_or(p.type), bytes.data(), swap_);
    source_.Take(first);
    if (!p.count_type) {
      values_[i] = value;
      continue;
    }
    if (!(value >= 0.0 && value <= kLongestList)) {
      Damaged("a list " + p.name + " of " + std::to_string(std::llround(value)) + " in the " +
              element.name + " at byte " + std::to_string(begin));
      return false;
    }
    if (!source_.Skip(static_cast<std::uint64_t>(value) * SizeOf(p.type))) return false;
  }
  return true;
}

std::uint8_t PlyReader::Colour(double value, Role role) const {
  double scale = 1.0;  // of a byte
  switch (vertex_.properties[columns_[role].property].type) {
    case PlyType::kFloat32:
    case PlyType::kFloat64:
      scale = 255.0;  // 0..1
      break;
    case PlyType::kInt16:
    case PlyType::kUint16:
      scale = 1.0 / 257.0;
      break;
    default:
      break;
  }
  value *= scale;
  return value >= 0.0 ? static_cast<std::uint8_t>(std::lround(std::min(value, 255.0))) : 0;
}

CloudPoint PlyReader::PointOf(const std::array<double, kRoles>& v) const {
  CloudPoint point;
  point.position = {v[kX], v[kY], v[kZ]};
  if (info_.has_colour)
    point.colour = {Colour(v[kRed], kRed), Colour(v[kGreen], kGreen), Colour(v[kBlue], kBlue)};
  point.intensity = static_cast<float>(v[kIntensity]);
  point.time_s = v[kTime];
  return point;
}

void PlyReader::FillFixed(std::size_t most, std::size_t stride) {
  for (std::size_t i = 0; i < most && left_ > 0; ++i) {
    const auto bytes = source_.Peek(stride);
    if (bytes.size() < stride) {
      FailAtEnd();
      return;
    }
    std::array<double, kRoles> v{};
    for (std::size_t role = 0; role < kRoles; ++role) {
      const Column& column = columns_[role];
      if (column.is_there)
        v[role] =
            PlyValue(vertex_.properties[column.property].type, bytes.data() + column.offset, swap_);
    }
    source_.Take(stride);
    --left_;
    Keep(PointOf(v));
  }
}

void PlyReader::Fill(std::size_t most) {
  if (const auto stride = vertex_.stride(); stride && header_.format != PlyHeader::Format::kAscii) {
    FillFixed(most, *stride);
    return;
  }
  for (std::size_t i = 0; i < most && left_ > 0; ++i) {
    if (!ReadOne(vertex_)) {
      if (!error_) FailAtEnd();
      return;
    }
    std::array<double, kRoles> v{};
    for (std::size_t role = 0; role < kRoles; ++role)
      if (columns_[role].is_there) v[role] = values_[columns_[role].property];
    --left_;
    Keep(PointOf(v));
  }
}

}  // namespace

core::Expected<CloudReaderPtr> OpenPly(ByteSource source) {
  auto reader = std::make_unique<PlyReader>(std::move(source));
  if (auto started = reader->Start(); !started) return tl::unexpected(started.error());
  return reader;
}

}  // namespace kawara::gis
