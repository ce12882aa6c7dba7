#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/expected.hpp"

namespace kawara::sim {

/// A table of results or of truth, read by GDAL: a CSV file with a header, or a layer of a
/// GeoPackage (or of whatever else GDAL reads). Read whole; then immutable.
class Table {
 public:
  /// `layers`: the first of these names that the file has is taken (a CSV file has one layer,
  /// whatever its name). Errors: kNotFound, kFormat (no such layer: says which there are).
  static core::Expected<Table> Read(const std::string& path,
                                    const std::vector<std::string>& layers);

  const std::string& path() const { return path_; }
  std::size_t size() const { return size_; }
  bool Has(const std::string& column) const { return columns_.contains(column); }
  /// The first of `names` that is a column. kFormat: none is; the line says what is there.
  core::Expected<std::string> ColumnOf(const std::vector<std::string>& names) const;
  /// NaN where the cell is empty or no number. The column must exist.
  double Number(std::size_t row, const std::string& column) const;
  /// 0 where the cell is empty or no number. The column must exist.
  std::int64_t Integer(std::size_t row, const std::string& column) const;
  const std::string& Text(std::size_t row, const std::string& column) const;

 private:
  std::string path_;
  std::size_t size_ = 0;
  std::map<std::string, std::vector<std::string>> columns_;
};

}  // namespace kawara::sim
