#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/expected.hpp"
#include "core/time.hpp"
#include "tools/navigate/line_file.hpp"

namespace kawara::navigate {

/// A column the caller understands.
struct CsvColumn {
  enum class Kind : std::uint8_t {
    kNumber,          ///< must be there, a finite number in every row
    kTime,            ///< must be there, seconds
    kOptionalNumber,  ///< may be missing; a cell may be empty or "nan": unknown
    kOptionalTime,
  };
  std::string_view name;
  Kind kind = Kind::kNumber;
};

/// What there is to say about a file once it was read.
struct CsvReport {
  std::string file;
  std::int64_t good_rows = 0;
  std::int64_t bad_rows = 0;            ///< left out
  std::vector<std::string> complaints;  ///< "FILE:LINE: what", of the first bad rows
  std::vector<std::string> unused_columns;

  /// The lines for people: complaints, how many more there are, unused columns. Empty: all well.
  std::vector<std::string> Lines() const;
};

/// A CSV file of numbers, columns found by the names in its header, in any order; others are
/// ignored. Plain or gzip; empty lines and lines that begin with '#' are skipped. A row that is no
/// good (wrong number of fields, no number) is left out and reported; a file in which most are is
/// refused. One thread.
class CsvReader {
 public:
  enum class Header : std::uint8_t {
    kRequired,
    kOptional,  ///< without one, the columns are the required ones in the order given
  };

  /// One row: a number for each column asked for, NaN where it is unknown.
  struct Row {
    std::span<const double> number;
    std::span<const std::optional<core::GpsTime>> time;  ///< of the columns that are times
  };

  /// Reads the header. Errors: those of LineFile, and kFormat (empty file, no header, a column is
  /// missing or there twice) as "FILE:LINE: what".
  static core::Expected<CsvReader> Open(const std::string& path, std::span<const CsvColumn> columns,
                                        Header header = Header::kRequired);

  /// The next good row, valid until the next call; nothing at the end. Errors: those of LineFile;
  /// at the end kFormat if no row was good or most were bad.
  core::Expected<std::optional<Row>> Next();

  /// The row that came last makes no sense after all: it counts as bad.
  void Reject(const std::string& what);

  /// Is this column (by its place in `columns`) in the file?
  bool Has(std::size_t column) const { return field_of_[column].has_value(); }
  const CsvReport& report() const { return report_; }
  double progress() const { return file_.progress(); }

 private:
  CsvReader(LineFile file, std::span<const CsvColumn> columns);
  core::Expected<void> ReadHeader(Header header);
  core::Expected<void> UseNames(std::span<const std::string_view> names);
  core::Expected<void> Judge() const;
  core::Error Mistake(const std::string& what) const;
  void Complain(const std::string& what);
  bool ParseRow(std::span<const std::string_view> fields);

  LineFile file_;
  std::vector<CsvColumn> columns_;
  std::vector<std::optional<std::size_t>> field_of_;  ///< by column
  std::size_t fields_ = 0;
  std::optional<std::string> pending_;  ///< the first line, where it was no header
  std::vector<std::string_view> row_;   ///< the fields of the row at hand
  std::vector<double> number_;
  std::vector<std::optional<core::GpsTime>> time_;
  CsvReport report_;
};

}  // namespace kawara::navigate
