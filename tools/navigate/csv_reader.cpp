#include "tools/navigate/csv_reader.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "tools/navigate/decimal_time.hpp"

namespace kawara::navigate {
namespace {

constexpr std::size_t kMaxComplaints = 3;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  if (text.size() >= 2 && text.front() == '"' && text.back() == '"') {
    text.remove_prefix(1);
    text.remove_suffix(1);
  }
  return text;
}

void Split(std::string_view line, std::vector<std::string_view>& fields) {
  fields.clear();
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

std::optional<double> ParseNumber(std::string_view text) {
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

bool IsOptional(CsvColumn::Kind kind) {
  return kind == CsvColumn::Kind::kOptionalNumber || kind == CsvColumn::Kind::kOptionalTime;
}

bool IsTime(CsvColumn::Kind kind) {
  return kind == CsvColumn::Kind::kTime || kind == CsvColumn::Kind::kOptionalTime;
}

/// What of the user's file goes into a message: short, and nothing a terminal would obey.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kLongest = 40;
  std::string out = "'";
  for (const char c : text.substr(0, kLongest)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out + (text.size() > kLongest ? "...'" : "'");
}

template <class Names>
std::string Joined(const Names& names) {
  constexpr std::size_t kMost = 20;
  std::string out;
  std::size_t count = 0;
  for (const auto& name : names) {
    if (++count > kMost) return out + ", ...";
    out += (count == 1 ? "" : ", ") + std::string(name);
  }
  return out;
}

}  // namespace

std::vector<std::string> CsvReport::Lines() const {
  std::vector<std::string> lines = complaints;
  for (std::string& line : lines) line += "; row left out";
  if (bad_rows > static_cast<std::int64_t>(complaints.size())) {
    lines.push_back(file + ": " + std::to_string(bad_rows) + " rows of " +
                    std::to_string(good_rows + bad_rows) + " left out");
  }
  if (!unused_columns.empty()) lines.push_back(file + ": not used: " + Joined(unused_columns));
  return lines;
}

CsvReader::CsvReader(LineFile file, std::span<const CsvColumn> columns)
    : file_(std::move(file)),
      columns_(columns.begin(), columns.end()),
      field_of_(columns.size()),
      number_(columns.size(), kUnknown),
      time_(columns.size()) {
  report_.file = file_.path();
}

core::Expected<CsvReader> CsvReader::Open(const std::string& path,
                                          std::span<const CsvColumn> columns, Header header) {
  auto file = LineFile::Open(path);
  if (!file) return tl::unexpected(file.error());
  CsvReader reader(std::move(*file), columns);
  if (auto ok = reader.ReadHeader(header); !ok) return tl::unexpected(ok.error());
  return reader;
}

core::Error CsvReader::Mistake(const std::string& what) const {
  return {core::ErrorCode::kFormat,
          file_.path() + ":" + std::to_string(file_.line_number()) + ": " + what};
}

core::Expected<void> CsvReader::ReadHeader(Header header) {
  std::vector<std::string_view> wanted;
  for (const CsvColumn& column : columns_) {
    if (!IsOptional(column.kind)) wanted.push_back(column.name);
  }
  for (;;) {
    const auto line = file_.Next();
    if (!line) return tl::unexpected(line.error());
    if (!*line) {
      return core::Fail(core::ErrorCode::kFormat,
                        file_.path() + ": empty, expected a header line with " + Joined(wanted));
    }
    if (Trimmed(**line).empty() || (*line)->starts_with('#')) continue;
    std::vector<std::string_view> names;
    Split(**line, names);
    if (!std::ranges::all_of(names, [](auto name) { return ParseNumber(name).has_value(); })) {
      return UseNames(names);
    }
    if (header == Header::kRequired) {
      return tl::unexpected(Mistake("expected a header line with " + Joined(wanted) +
                                    ", found numbers: write the names above them"));
    }
    pending_ = **line;
    return UseNames(wanted);
  }
}

core::Expected<void> CsvReader::UseNames(std::span<const std::string_view> names) {
  fields_ = names.size();
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    const auto found = std::ranges::find(names, columns_[c].name);
    if (found == names.end()) {
      if (IsOptional(columns_[c].kind)) continue;
      return tl::unexpected(Mistake("no column '" + std::string(columns_[c].name) +
                                    "' (there are: " + Joined(names) + ")"));
    }
    if (std::ranges::count(names, columns_[c].name) > 1) {
      return tl::unexpected(
          Mistake("column '" + std::string(columns_[c].name) + "' is there more than once"));
    }
    field_of_[c] = static_cast<std::size_t>(found - names.begin());
  }
  for (const std::string_view name : names) {
    if (std::ranges::none_of(columns_, [name](const CsvColumn& c) { return c.name == name; })) {
      const std::string quoted = Quoted(name);
      report_.unused_columns.push_back(quoted.substr(1, quoted.size() - 2));
    }
  }
  return {};
}

void CsvReader::Complain(const std::string& what) {
  ++report_.bad_rows;
  if (report_.complaints.size() < kMaxComplaints)
    report_.complaints.push_back(Mistake(what).message);
}

void CsvReader::Reject(const std::string& what) {
  --report_.good_rows;
  Complain(what);
}

bool CsvReader::ParseRow(std::span<const std::string_view> fields) {
  if (fields.size() != fields_) {
    Complain("expected " + std::to_string(fields_) + " fields, found " +
             std::to_string(fields.size()));
    return false;
  }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!field_of_[c]) continue;
    const CsvColumn& column = columns_[c];
    const std::string_view field = fields[*field_of_[c]];
    const auto complain = [&](const char* what) {
      Complain(std::string(column.name) + " is " + Quoted(field) + ": " + what);
      return false;
    };
    number_[c] = kUnknown;
    time_[c].reset();
    if (field.empty() && IsOptional(column.kind)) continue;
    const std::optional<double> number = ParseNumber(field);
    if (!number) return complain("not a number");
    if (std::isnan(*number) && IsOptional(column.kind)) continue;
    if (!std::isfinite(*number)) return complain("not a finite number");
    number_[c] = *number;
    if (!IsTime(column.kind)) continue;
    time_[c] = ParseSeconds(field);
    if (!time_[c]) return complain("no time in seconds within +-4e9");
  }
  return true;
}

core::Expected<std::optional<CsvReader::Row>> CsvReader::Next() {
  for (;;) {
    std::string held;
    std::string_view text;
    if (pending_) {
      held = std::move(*pending_);
      pending_.reset();
      text = held;
    } else {
      const auto line = file_.Next();
      if (!line) return tl::unexpected(line.error());
      if (!*line) {
        if (auto ok = Judge(); !ok) return tl::unexpected(ok.error());
        return std::optional<Row>();
      }
      text = **line;
    }
    if (text.starts_with('#') || Trimmed(text).empty()) continue;
    Split(text, row_);
    if (!ParseRow(row_)) continue;
    ++report_.good_rows;
    return std::optional<Row>(Row{number_, time_});
  }
}

core::Expected<void> CsvReader::Judge() const {
  if (report_.good_rows > report_.bad_rows) return {};
  if (report_.bad_rows == 0) {
    return core::Fail(core::ErrorCode::kFormat, file_.path() + ": no rows behind the header");
  }
  return core::Fail(core::ErrorCode::kFormat,
                    report_.complaints.front() + "; so or similar " +
                        std::to_string(report_.bad_rows) + " of " +
                        std::to_string(report_.good_rows + report_.bad_rows) + " rows");
}

}  // namespace kawara::navigate
