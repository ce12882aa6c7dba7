#include "sim/motion/number_table.hpp"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <memory>
#include <system_error>

namespace kawara::sim {
namespace {

constexpr std::size_t kMaxTextBytes = std::size_t{256} << 20;

std::vector<std::string_view> SplitCommas(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// gzread() passes plain files through, so one path serves both.
core::Expected<std::string> ReadWholeFile(const std::string& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rb"), gzclose);
  if (!in) return core::Fail(core::ErrorCode::kIo, "open " + file + ": cannot be read");
  std::string text;
  std::array<char, 65536> chunk;
  for (;;) {
    const int n = gzread(in.get(), chunk.data(), static_cast<unsigned>(chunk.size()));
    if (n > 0) {
      text.append(chunk.data(), static_cast<std::size_t>(n));
      if (text.size() > kMaxTextBytes) {
        return core::Fail(core::ErrorCode::kFormat, "read " + file + ": larger than 256 MB");
      }
      continue;
    }
    int zlib_error = Z_OK;
    const char* what = gzerror(in.get(), &zlib_error);
    if (n < 0 || zlib_error != Z_OK) {  // a cut-off gzip gives n == 0 with Z_BUF_ERROR
      return core::Fail(core::ErrorCode::kIo,
                        "read " + file + ": damaged or cut off (" + what + ")");
    }
    return text;
  }
}

bool ParseNumber(std::string_view field, double& value) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

/// Takes the next line off `text`, without CR LF.
std::string_view TakeLine(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return line;
}

core::Expected<std::vector<std::size_t>> FindColumns(const std::string& file,
                                                     std::string_view header,
                                                     const std::vector<std::string>& columns) {
  const std::vector<std::string_view> names = SplitCommas(header);
  std::vector<std::size_t> index;
  for (const std::string& column : columns) {
    const auto found = std::find(names.begin(), names.end(), column);
    if (found == names.end()) {
      return core::Fail(
          core::ErrorCode::kFormat,
          file + ":1: no column '" + column + "' in the header '" + std::string(header) + "'");
    }
    index.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  return index;
}

}  // namespace

core::Error NumberTable::RowError(std::size_t row, std::string_view column,
                                  const std::string& what) const {
  return {core::ErrorCode::kFormat,
          file + ":" + std::to_string(row + 2) + ": column " + std::string(column) + ": " + what};
}

core::Expected<NumberTable> ReadNumberTable(const std::filesystem::path& path,
                                            const std::vector<std::string>& columns) {
  NumberTable table;
  std::error_code ignored;
  table.file = path.string();
  if (!std::filesystem::is_regular_file(path, ignored)) table.file += ".gz";
  if (!std::filesystem::is_regular_file(table.file, ignored)) {
    return core::Fail(core::ErrorCode::kNotFound,
                      "neither " + path.string() + " nor " + table.file + " exists");
  }
  const core::Expected<std::string> whole = ReadWholeFile(table.file);
  if (!whole) return tl::unexpected(whole.error());

  std::string_view text = *whole;
  const std::string_view header = TakeLine(text);
  const auto index = FindColumns(table.file, header, columns);
  if (!index) return tl::unexpected(index.error());
  const std::size_t width = SplitCommas(header).size();

  while (!text.empty()) {
    const std::string_view line = TakeLine(text);
    if (line.empty() && text.empty()) break;
    const std::vector<std::string_view> fields = SplitCommas(line);
    if (fields.size() != width) {
      return tl::unexpected(table.RowError(
          table.rows.size(), "count",
          "expected " + std::to_string(width) + " fields, found " + std::to_string(fields.size())));
    }
    std::vector<double>& row = table.rows.emplace_back(columns.size());
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (!ParseNumber(fields[(*index)[i]], row[i])) {
        return tl::unexpected(
            table.RowError(table.rows.size() - 1, columns[i],
                           "not a number: '" + std::string(fields[(*index)[i]]) + "'"));
      }
    }
  }
  return table;
}

}  // namespace kawara::sim
